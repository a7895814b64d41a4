"""Lines and labels over an image, in its pixels. A window paints them; a video has them in its frames."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

Points = NDArray[np.float64]
Colour = tuple[int, int, int]
"Red, green, blue."
GOOD: Colour = (60, 200, 90)
BAD: Colour = (230, 50, 50)


@dataclass(frozen=True, eq=False)
class Stroke:
    """A line through points."""

    points: Points
    "(n, 2) pixels of the full image, whose first pixel's centre is (0, 0)."
    colour: Colour
    closed: bool = False
    weight: int = 1
    "Thickness relative to the thinnest line."


@dataclass(frozen=True)
class Label:
    """A text."""

    text: str
    place: tuple[float, float]
    "Its lower left corner, pixels."
    colour: Colour


@dataclass(frozen=True, eq=False)
class Drawing:
    """All overlays of one image."""

    strokes: list[Stroke] = field(default_factory=list)
    labels: list[Label] = field(default_factory=list)


def crosses(points: ArrayLike, arm: float, colour: Colour) -> list[Stroke]:
    """Return a cross on each of (n, 2) points; `arm` is half its size, pixels."""
    return [
        Stroke(np.array([point - end, point + end]), colour)
        for point in np.asarray(points, np.float64)
        for end in ((arm, 0.0), (0.0, arm))
    ]
