"""A point of view that goes round a point, and where it sees things. No painting here."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

Points = NDArray[np.float64]

NEAR = 0.05
"Metres before the eye at which lines are cut off."
STEEPEST = math.radians(85)
NEAREST, FARTHEST = 0.4, 12.0
"Metres from the eye to what it goes round."
FOCAL = 2.5
"Of the eye, in parts of the shorter side of what it sees."


@dataclass(frozen=True)
class Orbit:
    """An eye in a world whose z points up."""

    azimuth: float = math.radians(-38)
    "Radians about z from x, of the direction in which the eye is seen from the centre."
    elevation: float = math.radians(22)
    distance: float = 2.2
    "Metres."
    centre: tuple[float, float, float] = (0.3, -0.15, 0.28)

    def turned(self, right: float, down: float) -> Orbit:
        """As after a drag by so many radians: what is seen follows the hand."""
        elevation = min(max(self.elevation + down, -STEEPEST), STEEPEST)
        return replace(self, azimuth=self.azimuth - right, elevation=elevation)

    def nearer(self, factor: float) -> Orbit:
        """So many times nearer, within what makes sense."""
        return replace(self, distance=min(max(self.distance / factor, NEAREST), FARTHEST))

    @property
    def axes(self) -> Points:
        """(3, 3): rows are the eye's right, down and forward in the world."""
        ce, se = math.cos(self.elevation), math.sin(self.elevation)
        ca, sa = math.cos(self.azimuth), math.sin(self.azimuth)
        forward = -np.array([ce * ca, ce * sa, se])
        right = np.array([-sa, ca, 0.0])
        return np.array([right, np.cross(forward, right), forward])

    def seen(self, points: ArrayLike) -> Points:
        """(n, 3): points of the world as the eye has them, right, down and forward in metres."""
        axes = self.axes
        eye = np.array(self.centre) - self.distance * axes[2]
        turned: Points = (np.asarray(points, np.float64) - eye) @ axes.T
        return turned

    def flat(self, seen: Points, width: float, height: float) -> Points:
        """(n, 2): pixels of a view of that size. All must lie before the eye."""
        focal = FOCAL * min(width, height) / 2
        flat: Points = seen[:, :2] / seen[:, 2:] * focal + (width / 2, height / 2)
        return flat

    def segments(self, ends: ArrayLike, width: float, height: float) -> tuple[Points, Points]:
        """The parts of lines (n, 2, 3) that lie before the eye: (m, 2, 2) pixels, (m,) depths in metres."""
        seen = self.seen(np.asarray(ends, np.float64).reshape(-1, 3)).reshape(-1, 2, 3)
        seen = seen[seen[:, :, 2].max(axis=1) > NEAR]
        for this, other in ((0, 1), (1, 0)):
            behind = seen[:, this, 2] < NEAR
            start, end = seen[behind, this], seen[behind, other]
            part = (NEAR - start[:, 2]) / (end[:, 2] - start[:, 2])
            seen[behind, this] = start + (end - start) * part[:, None]
        flat = self.flat(seen.reshape(-1, 3), width, height).reshape(-1, 2, 2)
        return flat, seen[:, :, 2].mean(axis=1)

    def line(self, points: ArrayLike, width: float, height: float) -> tuple[Points, Points]:
        """The same of a line through points (n, 3)."""
        array = np.asarray(points, np.float64)
        return self.segments(np.stack((array[:-1], array[1:]), axis=1), width, height)
