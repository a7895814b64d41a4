"""A rectangle of pixels."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Region:
    """A rectangle in a frame's own pixels: (0, 0) is the first pixel of its payload."""

    x: int
    y: int
    width: int
    height: int

    @property
    def right(self) -> int:
        """The first column beyond it."""
        return self.x + self.width

    @property
    def bottom(self) -> int:
        """The first line below it."""
        return self.y + self.height

    def clipped(self, width: int, height: int) -> Region:
        """The part inside a picture of that size, which is at least one pixel.

        A region that lies outside altogether becomes the pixel of the picture that is nearest to it.
        """
        left, top = min(max(self.x, 0), width - 1), min(max(self.y, 0), height - 1)
        right, bottom = min(max(self.right, left + 1), width), min(max(self.bottom, top + 1), height)
        return Region(left, top, right - left, bottom - top)
