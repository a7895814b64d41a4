"""What decides how one frame looks: a snapshot of the camera's registers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from grabbergui.core.pfnc import Family, PixelFormat, by_code
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.memory import RegisterMemory
from grabbergui.driver.sim.registers import BinningMode, TestPattern


class Optics(NamedTuple):
    """What happens between scene and pixel apart from exposure; a picture of it can be kept."""

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

    @property
    def image_bytes(self) -> int:
        """Bytes of the picture without chunks."""
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
    """What the registers say just now. The caller holds the lock."""
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
    )
