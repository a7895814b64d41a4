"""What decides how one frame looks: a snapshot of the camera's registers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from grabbergui.core.pfnc import PixelFormat
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
