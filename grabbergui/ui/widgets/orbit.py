"""A point of view that goes round a point, and where it sees things. No painting here."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise

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

    def line(self, points: ArrayLike, width: float, height: float) -> list[tuple[Points, float]]:
        """The parts of a line that lie before the eye: (2, 2) pixels of each, and its depth in metres."""
        seen = self.seen(points)
        parts = []
        for start, end in pairwise(seen):
            if max(start[2], end[2]) <= NEAR:
                continue
            if start[2] < NEAR:
                start = start + (end - start) * (NEAR - start[2]) / (end[2] - start[2])
            elif end[2] < NEAR:
                end = end + (start - end) * (NEAR - end[2]) / (start[2] - end[2])
            both = np.array([start, end])
            parts.append((self.flat(both, width, height), float(both[:, 2].mean())))
        return parts
