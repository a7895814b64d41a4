"""The automatic modes at work: what a picture shows becomes registers for the next one."""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray

from grabbergui.core.pfnc import Family
from grabbergui.driver.sim import auto
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.memory import Register, RegisterMemory
from grabbergui.driver.sim.registers import Auto, TestPattern
from grabbergui.driver.sim.settings import FrameSettings


def regulate(memory: RegisterMemory, settings: FrameSettings, values: NDArray[Any]) -> None:
    """Let the modes that are on look at a picture made with `settings`. The caller holds the lock."""
    if settings.test_pattern not in (TestPattern.OFF, TestPattern.FRAME_COUNTER):
        return
    if memory.integer(reg.EXPOSURE_AUTO) or memory.integer(reg.GAIN_AUTO):
        measured = auto.brightness(values, settings.pixel_format.depth)
        target = memory.number(reg.AUTO_TARGET_BRIGHTNESS)
        _set_light(memory, settings, auto.correction(measured, target, settings))
    if memory.integer(reg.BALANCE_WHITE_AUTO) and settings.pixel_format.family is not Family.MONO:
        factors = auto.balance(values, settings)
        if factors is not None:
            _set_balance(memory, settings, factors)


def _set_light(memory: RegisterMemory, settings: FrameSettings, factor: float) -> None:
    exposure, gain = settings.exposure_us, settings.gain_db
    exposures, gains = auto.Limits(exposure, exposure), auto.Limits(gain, gain)
    if memory.integer(reg.EXPOSURE_AUTO):
        exposures = auto.Limits(
            memory.number(reg.AUTO_EXPOSURE_LOWER), memory.number(reg.AUTO_EXPOSURE_UPPER)
        )
    if memory.integer(reg.GAIN_AUTO):
        gains = auto.Limits(memory.number(reg.AUTO_GAIN_LOWER), memory.number(reg.AUTO_GAIN_UPPER))
    done = factor == 1.0
    if not done:
        wanted_exposure, wanted_gain = auto.share_light(factor, exposure, gain, exposures, gains)
        raw_gain = round(wanted_gain * 100)
        # At its limits it is as good as it can be.
        done = abs(wanted_exposure / exposure - 1) < 1e-9 and raw_gain == round(gain * 100)
        if memory.integer(reg.EXPOSURE_AUTO):
            memory.set(reg.EXPOSURE_TIME, wanted_exposure)
        if memory.integer(reg.GAIN_AUTO):
            memory.set(reg.GAIN_RAW, raw_gain)
    if done:
        _end_once(memory, reg.EXPOSURE_AUTO)
        _end_once(memory, reg.GAIN_AUTO)


def _set_balance(memory: RegisterMemory, settings: FrameSettings, factors: tuple[float, float]) -> None:
    if all(abs(factor - 1) < auto.BALANCE_TOLERANCE for factor in factors):
        _end_once(memory, reg.BALANCE_WHITE_AUTO)
        return
    red, _, blue = settings.optics.ratios
    targets = ((reg.BALANCE_RATIO[0], red * factors[0]), (reg.BALANCE_RATIO[2], blue * factors[1]))
    for register, ratio in targets:
        memory.set(register, min(max(ratio, register.minimum or 0), register.maximum or ratio))


def _end_once(memory: RegisterMemory, mode: Register) -> None:
    if memory.integer(mode) == Auto.ONCE:
        memory.set(mode, Auto.OFF)
