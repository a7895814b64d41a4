"""The settings in the registers that shape a frame."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

from grabbergui.core.component import ComponentKind, PayloadType
from grabbergui.core.pfnc import Family, PixelFormat, by_code
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.enumerations import (
    BinningMode,
    ComponentSelector,
    Compression,
    FrameContent,
    TestPattern,
    TransportLayer,
)
from grabbergui.driver.sim.memory import RegisterMemory

_COMPONENTS = {
    ComponentSelector.INTENSITY: ComponentKind.INTENSITY,
    ComponentSelector.RANGE: ComponentKind.RANGE,
    ComponentSelector.CONFIDENCE: ComponentKind.CONFIDENCE,
}


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


def _components(memory: RegisterMemory) -> tuple[ComponentKind, ...]:
    return tuple(
        kind
        for which, kind in _COMPONENTS.items()
        # A user set from outside may say otherwise, but the intensity is always sent.
        if which is ComponentSelector.INTENSITY or memory.integer(reg.COMPONENT_ENABLE[which])
    )


def _payload_type(memory: RegisterMemory) -> PayloadType:
    """Return what frames carry; USB3 Vision has fewer kinds than GigE Vision."""
    usb = memory.integer(reg.DEVICE_TL_TYPE) == TransportLayer.USB3_VISION
    content = FrameContent(memory.integer(reg.PAYLOAD_TYPE))
    if content is FrameContent.CHUNK_ONLY:
        return PayloadType.CHUNK
    if memory.integer(reg.GENDC_STREAMING_MODE):
        return PayloadType.GENDC
    if usb:
        return PayloadType.IMAGE
    if content is not FrameContent.IMAGE:
        return PayloadType[content.name]
    if compression := memory.integer(reg.IMAGE_COMPRESSION_MODE):
        return PayloadType[Compression(compression).name]
    return PayloadType.MULTI_PART if len(_components(memory)) > 1 else PayloadType.IMAGE
