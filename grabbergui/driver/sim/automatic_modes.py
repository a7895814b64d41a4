"""Automatic exposure, gain and white balance of the simulated camera.

They work on the frame alone, as a camera does, and settle
within a few frames: the sensor is linear, so one frame that is neither black nor white shows the right
exposure at once.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.pfnc import Family
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.enumerations import Auto, TestPattern
from grabbergui.driver.sim.memory import Register, RegisterMemory
from grabbergui.driver.sim.packing import COLOURED, sensor_depth
from grabbergui.driver.sim.settings import FrameSettings

BRIGHTNESS_TOLERANCE = 0.01
"Difference from the target, as a part of white, that is good enough."
BALANCE_TOLERANCE = 0.01
"Difference of the factors of red and blue from 1 that is good enough."
_STRONGEST_STEP = 8.0
"Largest change of the light from one frame to the next, as a factor."


@dataclass(frozen=True)
class ModeRange:
    """Range for an automatic mode; both ends are equal while the mode is off."""

    low: float
    high: float

    def clip(self, value: float) -> float:
        """Return the nearest value inside."""
        return min(max(value, self.low), self.high)


class Brightness(NamedTuple):
    """Brightness of an image as a fraction of white."""

    mean: float
    saturated: float
    "Fraction of the pixels that are saturated."


def brightness(values: NDArray[Any], depth: int) -> Brightness:
    """Measure the brightness of an image on a sample of its pixels."""
    height, width = values.shape[:2]
    step = 7  # odd, so that it falls on all sites of a Bayer pattern
    sample = values[:: step if height > 256 else 1, :: step if width > 256 else 1]
    white = (1 << depth) - 1
    return Brightness(float(sample.mean()) / white, float((sample >= white).mean()))


def correction(measured: Brightness, target: float, settings: FrameSettings) -> float:
    """Return the factor by which the light must change to reach the target; 1.0 within the tolerance."""
    if abs(measured.mean - target) < BRIGHTNESS_TOLERANCE:
        return 1.0
    black = settings.black_level / 255
    # White pixels cannot grow brighter: the others have to make up for them.
    white = measured.saturated if target > measured.mean else 0.0
    ratio: float = max(target - white - black, 0.01) / max(measured.mean - white - black, 1e-3)
    step: float = ratio ** (1 / settings.optics.gamma)
    return min(max(step, 1 / _STRONGEST_STEP), _STRONGEST_STEP)


def share_light(
    factor: float, exposure_us: float, gain_db: float, exposures: ModeRange, gains: ModeRange
) -> tuple[float, float]:
    """Spread a change of light over exposure time and gain, exposure first, gain as low as can be."""
    light = factor * exposure_us * 10 ** (gain_db / 20)
    exposure = exposures.clip(light / 10 ** (gains.low / 20))
    gain = gains.clip(20 * float(np.log10(max(light, 1e-9) / exposure)))
    # The part beyond the limit of gain goes back to the exposure.
    exposure = exposures.clip(light / 10 ** (gain / 20))
    return exposure, gain


def balance(values: NDArray[Any], settings: FrameSettings) -> tuple[float, float] | None:
    """Return the factors of red and blue that make grey neutral; None if the image does not allow it.

    The median of the pixels' ratios is that of grey as long as half of the image is grey. Saturated and dark
    pixels do not count.
    """
    pixel_format = settings.pixel_format
    black = settings.black_level / 255 * ((1 << sensor_depth(pixel_format)) - 1)
    white = (1 << sensor_depth(pixel_format)) - 1
    red, green, blue = (plane.astype(np.float32) for plane in _planes(values, settings))
    usable = np.ones(red.shape, bool)
    for plane in (red, green, blue):
        usable &= (plane > black + 0.04 * white) & (plane < 0.97 * white)
    if np.count_nonzero(usable) < 64:
        return None
    red, green, blue = (plane[usable] - black for plane in (red, green, blue))
    inverse = 1 / settings.optics.gamma
    return float(np.median(green / red)) ** inverse, float(np.median(green / blue)) ** inverse


def _planes(values: NDArray[Any], settings: FrameSettings) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    """Return red, green and blue of a sample of the pixels."""
    if settings.pixel_format.family is not Family.BAYER:
        sample = values[::8, ::8]
        return sample[:, :, 0], sample[:, :, 1], sample[:, :, 2]
    order = settings.pixel_format.order
    step = 8
    site = {
        "RG": ((0, 0), (0, 1), (1, 1)),
        "GR": ((0, 1), (0, 0), (1, 0)),
        "GB": ((1, 0), (0, 0), (0, 1)),
        "BG": ((1, 1), (0, 1), (0, 0)),
    }[order]
    rows, columns = values.shape[0] & ~1, values.shape[1] & ~1
    red, green, blue = (values[row:rows:step, column:columns:step] for row, column in site)
    return red, green, blue


def regulate(memory: RegisterMemory, settings: FrameSettings, values: NDArray[Any]) -> None:
    """Run the active automatic modes on an image made with `settings`. The caller holds the lock."""
    if settings.test_pattern not in (TestPattern.OFF, TestPattern.FRAME_COUNTER):
        return
    if memory.integer(reg.EXPOSURE_AUTO) or memory.integer(reg.GAIN_AUTO):
        measured = brightness(values, sensor_depth(settings.pixel_format))
        target = memory.number(reg.AUTO_TARGET_BRIGHTNESS)
        _set_light(memory, settings, correction(measured, target, settings))
    if memory.integer(reg.BALANCE_WHITE_AUTO) and (
        settings.pixel_format.family is Family.BAYER or settings.pixel_format.family in COLOURED
    ):
        factors = balance(values, settings)
        if factors is not None:
            _set_balance(memory, settings, factors)


def _set_light(memory: RegisterMemory, settings: FrameSettings, factor: float) -> None:
    exposure, gain = settings.exposure_us, settings.gain_db
    exposures, gains = ModeRange(exposure, exposure), ModeRange(gain, gain)
    if memory.integer(reg.EXPOSURE_AUTO):
        exposures = ModeRange(memory.number(reg.AUTO_EXPOSURE_LOWER), memory.number(reg.AUTO_EXPOSURE_UPPER))
    if memory.integer(reg.GAIN_AUTO):
        gains = ModeRange(memory.number(reg.AUTO_GAIN_LOWER), memory.number(reg.AUTO_GAIN_UPPER))
    done = factor == 1.0
    if not done:
        wanted_exposure, wanted_gain = share_light(factor, exposure, gain, exposures, gains)
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
    if all(abs(factor - 1) < BALANCE_TOLERANCE for factor in factors):
        _end_once(memory, reg.BALANCE_WHITE_AUTO)
        return
    red, _, blue = settings.optics.ratios
    targets = ((reg.BALANCE_RATIO[0], red * factors[0]), (reg.BALANCE_RATIO[2], blue * factors[1]))
    for register, ratio in targets:
        memory.set(register, min(max(ratio, register.minimum or 0), register.maximum or ratio))


def _end_once(memory: RegisterMemory, mode: Register) -> None:
    if memory.integer(mode) == Auto.ONCE:
        memory.set(mode, Auto.OFF)
