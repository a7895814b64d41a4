"""How a picture is turned and mirrored for looking at it; the frame itself stays as it is."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.core.region import Region

_ROTATIONS = {1: cv2.ROTATE_90_CLOCKWISE, 2: cv2.ROTATE_180, 3: cv2.ROTATE_90_COUNTERCLOCKWISE}


@dataclass(frozen=True)
class Orientation:
    """First mirrored, then turned. What is seen is the *view*; both have their origin at the top left."""

    quarter_turns: int = 0
    "Clockwise, 0 … 3."
    mirrored_x: bool = False
    "Left and right exchanged, as the view shows it."
    mirrored_y: bool = False

    @property
    def neutral(self) -> bool:
        """Whether the view is the frame."""
        return self == Orientation()

    def turned(self, quarters: int) -> Orientation:
        """Turned further, clockwise."""
        return replace(self, quarter_turns=(self.quarter_turns + quarters) % 4)

    def mirrored(self, *, x: bool = False, y: bool = False) -> Orientation:
        """What is seen just now, left and right (`x`) or top and bottom (`y`) exchanged."""
        if self.quarter_turns % 2:
            x, y = y, x  # the view's columns are the frame's lines
        return replace(self, mirrored_x=self.mirrored_x ^ x, mirrored_y=self.mirrored_y ^ y)

    def view_size(self, width: int, height: int) -> tuple[int, int]:
        """Of a frame of that size. It works the other way round as well."""
        return (height, width) if self.quarter_turns % 2 else (width, height)

    def to_view(self, region: Region, width: int, height: int) -> Region:
        """Where a region of a frame of that size is seen."""
        region = self._mirrored(region, width, height)
        return _rotated(region, width, height, self.quarter_turns)

    def to_frame(self, region: Region, width: int, height: int) -> Region:
        """The region of a frame of that size that is seen there. Both sizes are the frame's."""
        view_width, view_height = self.view_size(width, height)
        region = _rotated(region, view_width, view_height, -self.quarter_turns % 4)
        return self._mirrored(region, width, height)

    def pixel(self, x: int, y: int, width: int, height: int) -> tuple[int, int]:
        """Column and line of the frame's pixel that is seen there."""
        region = self.to_frame(Region(x, y, 1, 1), width, height)
        return region.x, region.y

    def applied(self, pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Pixels of the frame, (height, width[, 3]), as they are seen; contiguous, perhaps themselves."""
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
