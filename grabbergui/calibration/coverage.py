"""The coverage of a set of views of a board: parts of the image, tilts, distances."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from grabbergui.calibration.boards import View

GRID = (8, 6)
"Cells of the picture, across and down, in which corners are counted."
TILTED = 0.08
"Slant from which a board counts as tilted: about 15° where it fills half of the picture."
NEAR, FAR = 0.40, 0.22
"Size of the board in parts of the picture's longer side from, and below, which it is near or far."

Counts = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Placement:
    """How one view differs from another: place, size and slant of the board, each about 0 to 1."""

    x: float
    y: float
    size: float
    slant_x: float
    "Positive where the board's right edge is nearer."
    slant_y: float
    "Positive where its lower edge is nearer."

    def apart(self, other: Placement) -> float:
        """By how much two differ at most."""
        return float(np.abs(self._vector - other._vector).max())

    @property
    def _vector(self) -> NDArray[np.float64]:
        return np.array([self.x, self.y, self.size, self.slant_x, self.slant_y])


def _none(*shape: int) -> Counts:
    return np.zeros(shape, np.int64)


@dataclass(eq=False)
class Coverage:
    """Counts of what was seen."""

    cells: Counts = field(default_factory=lambda: _none(GRID[1], GRID[0]))
    "Corners seen in each cell of the picture, (rows, columns)."
    tilts: Counts = field(default_factory=lambda: _none(3, 3))
    "Views by tilt: upper edge nearer, none, lower edge nearer; left, none, right in each."
    sizes: Counts = field(default_factory=lambda: _none(3))
    "Views by distance: far, between, near."

    def add(self, view: View, placement: Placement, size: tuple[int, int]) -> None:
        """Count a view in a picture of `size`."""
        places = (view.picture / size * GRID).astype(int)
        inside = ((places >= 0) & (places < GRID)).all(axis=1)
        np.add.at(self.cells, (places[inside, 1], places[inside, 0]), 1)
        self.tilts[_third(placement.slant_y), _third(placement.slant_x)] += 1
        self.sizes[0 if placement.size < FAR else 2 if placement.size > NEAR else 1] += 1

    def copy(self) -> Coverage:
        """As it is now."""
        return Coverage(self.cells.copy(), self.tilts.copy(), self.sizes.copy())

    @property
    def part(self) -> float:
        """Of the picture, 0 to 1, in which corners were seen."""
        return float((self.cells > 0).mean())

    def missing(self) -> str:
        """Return how the board should be held next, as display text; empty where everything is covered.

        Focal length and distance cannot be distinguished by views that are not tilted, so tilts come first
        once there are some views.
        """
        views = int(self.sizes.sum())
        for name, seen in (
            ("with its left edge nearer", self.tilts[:, 0]),
            ("with its right edge nearer", self.tilts[:, 2]),
            ("with its upper edge nearer", self.tilts[0]),
            ("with its lower edge nearer", self.tilts[2]),
        ):
            if views >= 4 and not seen.any():
                return name
        empty = np.argwhere(self.cells == 0)
        if len(empty):
            down, across = (int(place) for place in empty[0])
            rows = ("top", "middle", "bottom")[down * 3 // GRID[1]]
            columns = ("left", "centre", "right")[across * 3 // GRID[0]]
            return f"at the {rows} {columns}"
        if not self.sizes[2]:
            return "nearer"
        return "" if self.sizes[0] or self.sizes[1] else "farther away"


def _third(slant: float) -> int:
    return 0 if slant < -TILTED else 2 if slant > TILTED else 1
