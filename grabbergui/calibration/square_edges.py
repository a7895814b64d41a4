"""Corners of a printed black square as the intersections of its edges.

Blur rounds a corner off, and whoever looks for it there finds it too far inside: by 0.15 to 0.6 pixels,
which makes a marker of 60 pixels seem half a percent to two percent farther away. Blur leaves a straight edge
where it is.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]
"(n, 2): x and y in pixels; the centre of the first pixel is at 0, 0."

LEAST_EDGE = 24.0
"Pixels of the shortest edge that is measured; the black of a shorter one is too narrow to look across."
AT_THE_ENDS = 0.12
"Share of an edge at each end where the corner's blur reaches."
ACROSS = 0.09
"Pixels to look across an edge each way, as a share of its length: about half a cell of a marker."
MOST_ACROSS = 6.0
"Pixels to look across an edge at most."
STEP = 0.5
"Pixels between two looks across an edge."
MOST_PLACES = 80
"Places along an edge where it is measured, at most one per pixel."
LEAST_PLACES = 8
"Places that must show the edge."
LEAST_STEP = 8.0
"Grey values from black to white below which a place does not show the edge."
LEAST_ANGLE = 0.1
"Sine of the angle of two edges, below which they do not make a corner."
MOST_MOVED = 3.0
"Pixels that a corner may move."


def intersected(grey: NDArray[np.uint8], corners: Points) -> Points:
    """Return the corners (4, 2), in order around the square, more accurately; unchanged if that fails.

    `grey` is (rows, columns). Edges are measured as parabolas, as a lens bends them.
    """
    found = corners
    for _ in range(2):  # the second time, the looks are centred on the edges
        edges = [_edge(grey, found[index], found[(index + 1) % 4]) for index in range(4)]
        measured = [edge for edge in edges if edge is not None]
        if len(measured) < 4:
            return corners
        found = np.array([_meet(measured[index - 1], measured[index], found[index]) for index in range(4)])
        if not np.all(np.abs(found - corners) <= MOST_MOVED):  # also where one is not a number
            return corners
    return found


class _Edge:
    """An edge from `start`, `along` a direction, displaced to `aside` by a parabola of the way along."""

    def __init__(self, start: Points, along: Points, aside: Points, parabola: NDArray[np.float64]) -> None:
        self.aside = aside
        self._start, self._along, self._parabola = start, along, parabola

    def offset(self, place: Points) -> float:
        """Return where the edge is, in pixels to `aside`, beside a place."""
        way = float((place - self._start) @ self._along)
        return float(self._start @ self.aside + np.polyval(self._parabola, way))


def _edge(grey: NDArray[np.uint8], start: Points, end: Points) -> _Edge | None:
    """Measure the edge between two corners; None if the image does not show it."""
    length = float(np.linalg.norm(end - start))
    if length < LEAST_EDGE:
        return None
    along = (end - start) / length
    aside = np.array([along[1], -along[0]])  # outwards, as the corners go round clockwise
    count = int(min(MOST_PLACES, (1 - 2 * AT_THE_ENDS) * length))
    ways = np.linspace(AT_THE_ENDS, 1 - AT_THE_ENDS, count) * length
    reach = min(MOST_ACROSS, ACROSS * length)
    looks = np.arange(-reach, reach + STEP / 2, STEP)
    places = (start + ways[:, None, None] * along + looks[None, :, None] * aside).astype(np.float32)
    values = cv2.remap(grey, places[..., 0], places[..., 1], cv2.INTER_LINEAR).astype(np.float64)
    rises = np.clip(np.diff(values, axis=1), 0, None)  # from the black to the white outside
    total = rises.sum(axis=1)
    shown = total >= LEAST_STEP
    if np.count_nonzero(shown) < LEAST_PLACES:
        return None
    offsets = rises[shown] @ (looks[:-1] + STEP / 2) / total[shown]
    ways = ways[shown]
    straight = np.abs(offsets - np.median(offsets)) <= max(0.5, reach / 3)  # not a thumb over the edge
    if np.count_nonzero(straight) < LEAST_PLACES:
        return None
    return _Edge(start, along, aside, np.polyfit(ways[straight], offsets[straight], 2))


def _meet(one: _Edge, other: _Edge, corner: Points) -> Points:
    """Return where two edges meet near a corner; not a number where they are nearly parallel."""
    sides = np.array([one.aside, other.aside])
    if abs(np.linalg.det(sides)) < LEAST_ANGLE:
        return np.full(2, np.nan)
    for _ in range(3):
        corner = np.linalg.solve(sides, [one.offset(corner), other.offset(corner)])
    return corner
