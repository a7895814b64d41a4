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
PLACES = np.linspace(0.12, 0.88, 48)
"Where an edge is measured, as shares of its length: not at the ends, which the corners' blur reaches."
POWERS = np.vander(PLACES, 3, increasing=True)
LOOKS = np.linspace(-1.0, 1.0, 17)
"Where each place is looked at across the edge, from inside to outside, in units of the reach."
REACH, MOST_REACH = 0.09, 6.0
"Pixels to look each way: a share of the edge's length, about half a cell of a marker, and the most."
LEAST_STEP = 8.0
"Grey values from black to white below which a place does not show the edge."
LEAST_PLACES = 24
"Places that must show each edge, near one line."
LEAST_ANGLE = 0.1
"Sine of the angle of two edges, below which they do not make a corner."
MOST_MOVED = 3.0
"Pixels that a corner may move."
NEARLY_RIGHT = 0.3
"Pixels that the corners were wrong, below which the edges are not measured again from where they were found."
BEFORE, NEXT = (3, 0, 1, 2), (1, 2, 3, 0)
"The edge or corner before each, and the next one."


def intersected(grey: NDArray[np.uint8], corners: Points) -> Points:
    """Return the corners (4, 2), clockwise around the square, more accurately; unchanged if that fails.

    `grey` is (rows, columns). Edges are measured as parabolas, as a lens bends them.
    """
    found = corners
    for _ in range(2):
        measured = _measured(grey, found)
        if measured is None or np.abs(measured - corners).max() > MOST_MOVED:
            return corners
        moved, found = np.abs(measured - found).max(), measured
        if moved < NEARLY_RIGHT:
            break
    return found


def _measured(grey: NDArray[np.uint8], corners: Points) -> Points | None:
    """Return where the edges between these corners meet; None if the image does not show them."""
    edges = corners[NEXT, :] - corners
    lengths = np.sqrt(np.sum(edges**2, axis=1))
    if lengths.min() < LEAST_EDGE:
        return None
    along = edges / lengths[:, None]
    aside = np.column_stack([along[:, 1], -along[:, 0]])  # outwards
    sides = np.stack([aside[BEFORE, :], aside], axis=1)
    if np.abs(np.linalg.det(sides)).min() < LEAST_ANGLE:
        return None
    offsets, shown = _offsets(grey, corners, edges, aside, np.minimum(MOST_REACH, REACH * lengths))
    if shown.sum(axis=1).min() < LEAST_PLACES:
        return None
    weighted = POWERS.T * shown[:, None, :]
    parabolas = np.linalg.solve(weighted @ POWERS, weighted @ offsets[:, :, None])[..., 0]
    starts = np.stack([corners[BEFORE, :], corners], axis=1)
    ways = (along / lengths[:, None])[[BEFORE, (0, 1, 2, 3)]].transpose(1, 0, 2)
    bent = parabolas[[BEFORE, (0, 1, 2, 3)]].transpose(1, 0, 2)
    met = corners
    for _ in range(2):  # along the parabolas of the edge before each corner and of the one after it
        share = np.sum((met[:, None] - starts) * ways, axis=2)
        moved = bent[..., 0] + share * (bent[..., 1] + share * bent[..., 2])
        met = corners + np.linalg.solve(sides, moved[:, :, None])[..., 0]
    return met


def _offsets(
    grey: NDArray[np.uint8], corners: Points, edges: Points, aside: Points, reach: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Return how many pixels outside each edge is (4, places), and whether the image shows it there."""
    looks = reach[:, None] * LOOKS
    along = corners[:, None] + PLACES[:, None] * edges[:, None]
    at = (along[:, :, None] + looks[:, None, :, None] * aside[:, None, None]).astype(np.float32)
    x, y = at.reshape(len(corners), -1, 2).transpose(2, 0, 1)
    values = cv2.remap(grey, x, y, cv2.INTER_LINEAR).astype(np.float64).reshape(at.shape[:-1])
    rises = np.clip(np.diff(values, axis=2), 0, None)  # from the black to the white outside
    steps = rises.sum(axis=2)
    offsets = (rises @ ((looks[:, 1:] + looks[:, :-1]) / 2)[:, :, None])[..., 0] / np.maximum(steps, 1.0)
    near = np.abs(offsets - np.median(offsets, axis=1, keepdims=True)) <= np.maximum(0.5, reach[:, None] / 3)
    return offsets, near & (steps >= LEAST_STEP)  # a thumb over the edge is not near
