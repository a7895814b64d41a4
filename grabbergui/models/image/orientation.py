"""The orientation of the image on the screen: rotated, mirrored."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.core.pixels import Region

_ROTATIONS = {1: cv2.ROTATE_90_CLOCKWISE, 2: cv2.ROTATE_180, 3: cv2.ROTATE_90_COUNTERCLOCKWISE}


@dataclass(frozen=True)
class Orientation:
    """Mirroring, then rotation of a frame into the *view*; both have their origin at the top left."""

    quarter_turns: int = 0
    "Clockwise, 0 … 3."
    mirrored_x: bool = False
    "Whether left and right of the frame are exchanged."
    mirrored_y: bool = False

    @property
    def neutral(self) -> bool:
        """Whether the view equals the frame."""
        return self == Orientation()

    def turned(self, quarters: int) -> Orientation:
        """Return the orientation rotated clockwise."""
        return replace(self, quarter_turns=(self.quarter_turns + quarters) % 4)

    def mirrored(self, *, x: bool = False, y: bool = False) -> Orientation:
        """Return the current view with left and right (`x`) or top and bottom (`y`) exchanged."""
        if self.quarter_turns % 2:
            x, y = y, x  # the view's columns are the frame's lines
        return replace(self, mirrored_x=self.mirrored_x ^ x, mirrored_y=self.mirrored_y ^ y)

    def view_size(self, width: int, height: int) -> tuple[int, int]:
        """Return the view's size for a frame of that size, and vice versa."""
        return (height, width) if self.quarter_turns % 2 else (width, height)

    def to_view(self, region: Region, width: int, height: int) -> Region:
        """Return the region of the view that shows a region of a frame of that size."""
        region = self._mirrored(region, width, height)
        return _rotated(region, width, height, self.quarter_turns)

    def to_frame(self, region: Region, width: int, height: int) -> Region:
        """Return the region of a frame that a region of the view shows. Width and height are the frame's."""
        view_width, view_height = self.view_size(width, height)
        region = _rotated(region, view_width, view_height, -self.quarter_turns % 4)
        return self._mirrored(region, width, height)

    def pixel(self, x: int, y: int, width: int, height: int) -> tuple[int, int]:
        """Return the column and line in the frame of a pixel of the view."""
        region = self.to_frame(Region(x, y, 1, 1), width, height)
        return region.x, region.y

    def place_in(self, other: Orientation, x: float, y: float) -> tuple[float, float]:
        """Return where `other` shows what this orientation shows at `x`, `y`, in fractions of the view."""
        fine = 1 << 20
        region = self.to_frame(Region(round(x * fine), round(y * fine), 1, 1), fine, fine)
        region = other.to_view(region, fine, fine)
        return region.x / fine, region.y / fine

    def applied(self, pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Return the frame's pixels, (height, width[, 3]), in this orientation; contiguous, maybe no copy."""
        if self.mirrored_x or self.mirrored_y:
            code = -1 if self.mirrored_x and self.mirrored_y else int(self.mirrored_x)
            pixels = np.asarray(cv2.flip(pixels, code), np.uint8)
        if self.quarter_turns:
            pixels = np.asarray(cv2.rotate(pixels, _ROTATIONS[self.quarter_turns]), np.uint8)
        return pixels

    def _mirrored(self, region: Region, width: int, height: int) -> Region:
        x = width - region.right if self.mirrored_x else region.x
        y = height - region.bottom if self.mirrored_y else region.y
        return Region(x, y, region.width, region.height)


def _rotated(region: Region, width: int, height: int, quarters: int) -> Region:
    for _ in range(quarters):
        region = Region(height - region.bottom, region.x, region.height, region.width)
        width, height = height, width
    return region


def scaled_region(region: Region, size: tuple[int, int], other: tuple[int, int]) -> Region:
    """Return a region of an image of `size` as the same region of an image of the size `other`.

    Rounds outwards; sizes are (width, height).
    """
    if size == other:
        return region
    left, right = region.x * other[0] // size[0], -(-region.right * other[0] // size[0])
    top, bottom = region.y * other[1] // size[1], -(-region.bottom * other[1] // size[1])
    return Region(left, top, right - left, bottom - top)
