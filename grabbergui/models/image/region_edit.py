"""Moving and resizing a region of the sensor with the mouse, in steps that the camera accepts. No I/O.

All lengths are pixels of the sensor as the camera counts them (OffsetX, Width); (0, 0) is its first pixel.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from grabbergui.core.pixels import Region


@dataclass(frozen=True)
class AxisLimits:
    """The limits and the step that a camera accepts along one axis."""

    sensor: int
    "Pixels of the sensor."
    least: int = 1
    "Smallest size."
    step: int = 1
    "Sizes are `least` and a multiple of this more."
    offset_step: int = 1

    def moved(self, start: int, size: int, by: int) -> tuple[int, int]:
        """Return start and size after a move."""
        return self._offset(start + by, size), size

    def first_moved(self, start: int, size: int, by: int) -> tuple[int, int]:
        """Return start and size after the first pixel was dragged; the last one stays if steps allow."""
        end = start + size
        length = self.size(end - max(0, start + by), end)
        return self._offset(end - length, length), length

    def last_moved(self, start: int, size: int, by: int) -> tuple[int, int]:
        """Return start and size after the last pixel was dragged."""
        return start, self.size(size + by, self.sensor - start)

    def size(self, wanted: int, most: int) -> int:
        """Return the size that the camera accepts nearest to `wanted`, of at most `most`."""
        steps = round((min(wanted, most) - self.least) / self.step)
        if self.least + steps * self.step > most:
            steps -= 1
        return self.least + max(0, steps) * self.step

    def _offset(self, wanted: int, size: int) -> int:
        most = max(0, self.sensor - size)
        return (
            min(round(min(max(wanted, 0), most) / self.offset_step), most // self.offset_step)
            * self.offset_step
        )


@dataclass(frozen=True)
class RegionLimits:
    """The limits and steps of a camera's region."""

    x: AxisLimits
    y: AxisLimits

    @property
    def whole(self) -> Region:
        """The whole sensor."""
        return Region(0, 0, self.x.sensor, self.y.sensor)


class Grip(Enum):
    """The part of a region that is dragged: which of its sides move (left, top, right, bottom)."""

    MIDDLE = (True, True, True, True)
    LEFT = (True, False, False, False)
    TOP = (False, True, False, False)
    RIGHT = (False, False, True, False)
    BOTTOM = (False, False, False, True)
    TOP_LEFT = (True, True, False, False)
    TOP_RIGHT = (False, True, True, False)
    BOTTOM_LEFT = (True, False, False, True)
    BOTTOM_RIGHT = (False, False, True, True)


def grip_at(region: Region, x: float, y: float, reach: float) -> Grip | None:
    """Return what is at a place: a side, a corner or the middle, each within `reach`, or None elsewhere."""
    if not (region.x - reach <= x <= region.right + reach and region.y - reach <= y <= region.bottom + reach):
        return None
    right, bottom = abs(x - region.right) <= reach, abs(y - region.bottom) <= reach
    left, top = abs(x - region.x) <= reach and not right, abs(y - region.y) <= reach and not bottom
    if not (left or top or right or bottom):
        middle_x, middle_y = region.x + region.width / 2, region.y + region.height / 2
        return Grip.MIDDLE if abs(x - middle_x) <= reach and abs(y - middle_y) <= reach else None
    return Grip((left, top, right, bottom))


def dragged(region: Region, grip: Grip, dx: float, dy: float, limits: RegionLimits) -> Region:
    """Return the region after a drag of one part by so many pixels, as the camera accepts it."""
    left, top, right, bottom = grip.value
    x, width = _along(limits.x, region.x, region.width, left, right, round(dx))
    y, height = _along(limits.y, region.y, region.height, top, bottom, round(dy))
    return Region(x, y, width, height)


def _along(axis: AxisLimits, start: int, size: int, first: bool, last: bool, by: int) -> tuple[int, int]:
    if first and last:
        return axis.moved(start, size, by)
    if first:
        return axis.first_moved(start, size, by)
    return axis.last_moved(start, size, by) if last else (start, size)
