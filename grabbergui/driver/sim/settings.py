"""Settings as registers: those that shape a frame, derived ones, and those that automatic modes change.

Automatic exposure, gain and white balance (`regulate`) work on the frame alone, as a camera does, and settle
within a few frames: the sensor is linear, so one frame that is neither black nor white shows the right
exposure at once.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.component import ComponentKind, PayloadType
from grabbergui.core.pfnc import Family, PixelFormat, by_code
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.memory import Register, RegisterMemory
from grabbergui.driver.sim.packing import COLOURED, sensor_depth
from grabbergui.driver.sim.registers import Auto, BinningMode, Chunk, TestPattern


class Optics(NamedTuple):
    """The processing between scene and pixel apart from exposure; the key of cached images."""

    binning_horizontal: int = 1
    binning_vertical: int = 1
    reverse_x: bool = False
    reverse_y: bool = False
    gamma: float = 1.0
    ratios: tuple[float, float, float] = (1.0, 1.0, 1.0)
    "Amplification of red, green, blue; ones for a monochrome format."


@dataclass(frozen=True)
class FrameSettings:
    """All that the sensor needs to know to make a frame."""

    width: int
    height: int
    offset_x: int
    offset_y: int
    pixel_format: PixelFormat
    optics: Optics
    exposure_us: float
    gain_db: float
    black_level: float
    "In values of an 8-bit pixel."
    test_pattern: TestPattern = TestPattern.OFF
    binning_modes: tuple[BinningMode, BinningMode] = (BinningMode.AVERAGE, BinningMode.AVERAGE)
    "Horizontal, vertical."
    payload_type: PayloadType = PayloadType.IMAGE
    components: tuple[ComponentKind, ...] = (ComponentKind.INTENSITY,)
    lut: bytes | None = field(default=None, repr=False)
    "The look-up table, 16 bits big-endian; None while it is off."

    @property
    def image_bytes(self) -> int:
        """Bytes of the image without chunks."""
        return self.pixel_format.image_bytes(self.width, self.height)

    @property
    def amplification(self) -> float:
        """Gain and summing pixels, as a factor."""
        horizontal, vertical = self.binning_modes
        factor: float = 10 ** (self.gain_db / 20)
        if horizontal is BinningMode.SUM:
            factor *= self.optics.binning_horizontal
        if vertical is BinningMode.SUM:
            factor *= self.optics.binning_vertical
        return factor


def settings_of(memory: RegisterMemory) -> FrameSettings:
    """Return the settings in the registers at the moment. The caller holds the lock."""
    pixel_format = by_code(memory.integer(reg.PIXEL_FORMAT))
    red, green, blue = (memory.number(ratio) for ratio in reg.BALANCE_RATIO)
    optics = Optics(
        memory.integer(reg.BINNING_HORIZONTAL),
        memory.integer(reg.BINNING_VERTICAL),
        bool(memory.integer(reg.REVERSE_X)),
        bool(memory.integer(reg.REVERSE_Y)),
        memory.number(reg.GAMMA),
        (1.0, 1.0, 1.0) if pixel_format.family is Family.MONO else (red, green, blue),
    )
    horizontal, vertical = reg.BINNING_HORIZONTAL_MODE, reg.BINNING_VERTICAL_MODE
    return FrameSettings(
        memory.integer(reg.WIDTH),
        memory.integer(reg.HEIGHT),
        memory.integer(reg.OFFSET_X),
        memory.integer(reg.OFFSET_Y),
        pixel_format,
        optics,
        memory.number(reg.EXPOSURE_TIME),
        memory.integer(reg.GAIN_RAW) / 100,
        memory.number(reg.BLACK_LEVEL),
        TestPattern(memory.integer(reg.TEST_PATTERN)),
        (BinningMode(memory.integer(horizontal)), BinningMode(memory.integer(vertical))),
        _payload_type(memory),
        _components(memory),
        memory.read(*reg.LUT_VALUE_ALL) if memory.integer(reg.LUT_ENABLE) else None,
    )


_COMPONENTS = {
    reg.Component.INTENSITY: ComponentKind.INTENSITY,
    reg.Component.RANGE: ComponentKind.RANGE,
    reg.Component.CONFIDENCE: ComponentKind.CONFIDENCE,
}


def _components(memory: RegisterMemory) -> tuple[ComponentKind, ...]:
    return tuple(
        kind
        for which, kind in _COMPONENTS.items()
        # A user set from outside may say otherwise, but the intensity is always sent.
        if which is reg.Component.INTENSITY or memory.integer(reg.COMPONENT_ENABLE[which])
    )


def _payload_type(memory: RegisterMemory) -> PayloadType:
    """Return what frames carry; USB3 Vision has fewer kinds than GigE Vision."""
    usb = memory.integer(reg.DEVICE_TL_TYPE) == reg.TransportLayer.USB3_VISION
    content = reg.FrameContent(memory.integer(reg.PAYLOAD_TYPE))
    if content is reg.FrameContent.CHUNK_ONLY:
        return PayloadType.CHUNK
    if memory.integer(reg.GENDC_STREAMING_MODE):
        return PayloadType.GENDC
    if usb:
        return PayloadType.IMAGE
    if content is not reg.FrameContent.IMAGE:
        return PayloadType[content.name]
    if compression := memory.integer(reg.IMAGE_COMPRESSION_MODE):
        return PayloadType[reg.Compression(compression).name]
    return PayloadType.MULTI_PART if len(_components(memory)) > 1 else PayloadType.IMAGE


# -- derived registers ---------------------------------------------------------------------------
DECIDING = (
    reg.WIDTH,
    reg.HEIGHT,
    reg.BINNING_HORIZONTAL,
    reg.BINNING_VERTICAL,
    reg.PIXEL_FORMAT,
    reg.CHUNK_MODE_ACTIVE,
    *reg.CHUNK_ENABLE,
    *reg.COMPONENT_ENABLE,
    reg.IMAGE_COMPRESSION_MODE,
    reg.GENDC_STREAMING_MODE,
    reg.PAYLOAD_TYPE,
)
"Features that decide the payload's size, locked while streaming."

_AXES = (
    (reg.SENSOR_WIDTH, reg.BINNING_HORIZONTAL, reg.WIDTH_MAX, reg.WIDTH, reg.OFFSET_X),
    (reg.SENSOR_HEIGHT, reg.BINNING_VERTICAL, reg.HEIGHT_MAX, reg.HEIGHT, reg.OFFSET_Y),
)


def update_geometry(memory: RegisterMemory) -> None:
    """Recompute the sizes and colours that depend on the `DECIDING` registers."""
    for sensor, binning, limit, size, offset in _AXES:
        most = sensor // memory.integer(binning)
        most -= (most - int(size.minimum or 0)) % size.step
        memory.set(limit, most)
        memory.set(size, min(memory.integer(size), most))
        # A larger image reduces the offset.
        room = most - memory.integer(size)
        memory.set(offset, min(memory.integer(offset), room - room % offset.step))
    pixel_format = by_code(memory.integer(reg.PIXEL_FORMAT))
    memory.set(reg.IS_COLOR, int(pixel_format.family is not Family.MONO))
    colour_filter = reg.ColorFilter.NONE
    if pixel_format.family is Family.BAYER:
        colour_filter = reg.ColorFilter[f"BAYER_{pixel_format.order}"]
    memory.set(reg.PIXEL_COLOR_FILTER, colour_filter)


def active_chunks(memory: RegisterMemory) -> tuple[Chunk, ...]:
    """Return the chunks that are enabled at the moment."""
    alone = memory.integer(reg.PAYLOAD_TYPE) == reg.FrameContent.CHUNK_ONLY
    if not memory.integer(reg.CHUNK_MODE_ACTIVE) and not alone:
        return ()
    enabled = (chunk for chunk in Chunk if memory.integer(reg.CHUNK_ENABLE[chunk]))
    return tuple(chunk for chunk in enabled if chunk is not Chunk.IMAGE)


def fastest_rate(memory: RegisterMemory) -> float:
    """Return the frame rate (Hz) that exposure, readout and link allow; the XML has the same formula."""
    exposed = memory.number(reg.EXPOSURE_TIME) + reg.EXPOSURE_OVERHEAD_US
    lines = memory.integer(reg.HEIGHT) * memory.integer(reg.BINNING_VERTICAL)
    slowest = max(exposed, lines * reg.LINE_TIME_US + reg.FRAME_OVERHEAD_US)
    if memory.integer(reg.LINK_THROUGHPUT_LIMIT_MODE):
        payload = memory.integer(reg.PAYLOAD_SIZE)
        slowest = max(slowest, payload * 1e6 / memory.integer(reg.LINK_THROUGHPUT_LIMIT))
    return min(1e6 / slowest, reg.FASTEST_RATE)


# -- automatic modes -----------------------------------------------------------------------------
BRIGHTNESS_TOLERANCE = 0.01
"Difference from the target, as a part of white, that is good enough."
BALANCE_TOLERANCE = 0.01
"Difference of the factors of red and blue from 1 that is good enough."
_STRONGEST_STEP = 8.0
"Largest change of the light from one frame to the next, as a factor."


@dataclass(frozen=True)
class Limits:
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
    factor: float, exposure_us: float, gain_db: float, exposures: Limits, gains: Limits
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
    exposures, gains = Limits(exposure, exposure), Limits(gain, gain)
    if memory.integer(reg.EXPOSURE_AUTO):
        exposures = Limits(memory.number(reg.AUTO_EXPOSURE_LOWER), memory.number(reg.AUTO_EXPOSURE_UPPER))
    if memory.integer(reg.GAIN_AUTO):
        gains = Limits(memory.number(reg.AUTO_GAIN_LOWER), memory.number(reg.AUTO_GAIN_UPPER))
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
