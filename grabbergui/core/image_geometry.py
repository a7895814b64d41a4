"""Where the pixels of a camera's images lie on its sensor (SFNC, Image Format Control).

The sensor's pixels are combined (binning) or skipped (decimation), then mirrored, and then the region is cut
out: `OffsetX` counts pixels of the image, from the edge that is left after mirroring.
"""

from __future__ import annotations

from dataclasses import dataclass

from grabbergui.core.errors import UsageError

LARGEST_OFFSET = (1 << 31) - 1
"""Largest number in the description of a geometry."""


@dataclass(frozen=True)
class ImageGeometry:
    """Everything but the size of an image that determines where its pixels lie on the sensor."""

    whole: tuple[int, int]
    "Width and height of the largest image with this binning (WidthMax, HeightMax), pixels."
    offset: tuple[int, int] = (0, 0)
    "Column and row of the image's first pixel in the largest image (OffsetX, OffsetY)."
    binning: tuple[float, float] = (1, 1)
    """Pixels of the sensor for each pixel of the image, along x and y: binning times decimation. The pixel
    counts as the middle of them all, though decimation may take any of them."""
    reversed: tuple[bool, bool] = (False, False)
    "Whether the image is mirrored along x and along y (ReverseX, ReverseY)."

    def __post_init__(self) -> None:
        numbers = (*self.whole, *self.offset, *self.binning)
        if min(*self.whole, *self.binning) <= 0 or min(self.offset) < 0 or max(numbers) > LARGEST_OFFSET:
            raise UsageError(
                f"an image of at most {self.whole[0]}×{self.whole[1]} pixels that begins at "
                f"{self.offset[0]}, {self.offset[1]} with a binning of {self.binning[0]:g}×"
                f"{self.binning[1]:g} is impossible"
            )

    @property
    def sensor(self) -> tuple[float, float]:
        """Width and height of the largest image in pixels of the sensor."""
        return self.whole[0] * self.binning[0], self.whole[1] * self.binning[1]

    def same_sensor(self, other: ImageGeometry) -> bool:
        """Return whether both are of one area, within the pixels that binning leaves over."""
        return all(
            abs(ours - theirs) < max(1.0, *binning)
            for ours, theirs, binning in zip(
                self.sensor, other.sensor, zip(self.binning, other.binning, strict=True), strict=True
            )
        )
