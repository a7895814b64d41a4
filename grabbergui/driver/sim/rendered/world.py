"""Flat things in space, and how a pinhole camera sees them.

A `Panel` is a textured rectangle: x to its right, y up, z out of its face. Poses are (4, 4) matrices to the
world's coordinates (x forward, y left, z up, metres).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.driver.sim.rendered.textures import Texture
from grabbergui.driver.sim.scene import ILLUMINANT, UNIT

Matrix = NDArray[np.float64]
_NEAR = 0.05
"Metres before the camera at which things are cut off."
_LEVELS = 6


@dataclass(frozen=True, eq=False)
class Panel:
    """A textured rectangle, seen from its front only."""

    pose: Matrix
    width: float
    "Metres."
    height: float
    texture: Texture
    fine: bool = False
    "Whether its pixels are averaged from several samples, as edges that are measured need."

    @cached_property
    def corners(self) -> Matrix:
        """(4, 3), in the world, around the rectangle."""
        x, y = self.width / 2, self.height / 2
        flat = np.array([(-x, y, 0, 1), (x, y, 0, 1), (x, -y, 0, 1), (-x, -y, 0, 1)])
        world: Matrix = (self.pose @ flat.T).T[:, :3]
        return world

    def distance_from(self, eye: Matrix) -> float:
        """Metres from a point to the plane it lies in, by which what hides what is decided.

        Not to its middle: of two that hang one behind the other the lower is nearer to a low eye.
        """
        return float((eye - self.pose[:3, 3]) @ self.pose[:3, 2])


_pyramids: dict[int, tuple[Texture, list[NDArray[np.uint16]]]] = {}


def _pyramid(texture: Texture) -> list[NDArray[np.uint16]]:
    """Radiance and opacity (65535 is solid) of a texture at full size and, in turn, at half of it."""
    held = _pyramids.get(id(texture))
    if held is None or held[0] is not texture:
        scale = np.array([UNIT * answer for answer in ILLUMINANT] + [65535.0], np.float32)
        levels = [np.rint(texture * scale).astype(np.uint16)]
        while len(levels) < _LEVELS and min(levels[-1].shape[:2]) > 8:
            height, width = levels[-1].shape[:2]
            half = cv2.resize(levels[-1], (width // 2, height // 2), interpolation=cv2.INTER_AREA)
            levels.append(np.asarray(half, np.uint16))
        held = _pyramids[id(texture)] = (texture, levels)
    return held[1]


def draw(panel: Panel, out: NDArray[np.uint16], view: Matrix, pinhole: Matrix) -> None:
    """Lay a panel over `out` (rows, columns, 3).

    `view` takes the world to the camera (z forward, y down), `pinhole` (3, 3) directions to pixels.
    """
    seen = (view[:3, :3] @ panel.corners.T).T + view[:3, 3]
    if float(np.dot(np.cross(seen[1] - seen[0], seen[3] - seen[0]), seen[0])) <= 0:
        return  # its back
    outline = _project(_clipped(seen), pinhole)
    if outline is None:
        return
    height, width = out.shape[:2]
    left, top = np.floor(outline.min(axis=0)).astype(int)
    right, bottom = np.ceil(outline.max(axis=0)).astype(int) + 1
    left, top, right, bottom = max(left, 0), max(top, 0), min(right, width), min(bottom, height)
    if left >= right or top >= bottom:
        return
    samples = 2 if panel.fine else 1
    place = np.array([[samples, 0, (samples - 1) / 2], [0, samples, (samples - 1) / 2], [0, 0, 1.0]])
    place = place @ np.array([[1, 0, -left], [0, 1, -top], [0, 0, 1.0]])
    texture = _level(panel, outline, samples)
    size = (int(right - left) * samples, int(bottom - top) * samples)
    painted = cv2.warpPerspective(texture, place @ pinhole @ _to_camera(panel, view, texture), size)
    mask = np.zeros((size[1], size[0]), np.uint8)
    shape = np.rint(((outline - (left, top) + 0.5) * samples - 0.5) * 16).astype(np.int32)
    cv2.fillConvexPoly(mask, shape, 255, cv2.LINE_8, 4)
    region = out[top:bottom, left:right]
    if not panel.fine:
        cv2.copyTo(painted[..., :3], mask, region)
        return
    opacity = painted[..., 3].astype(np.float32) * (mask != 0) / 65535
    light = painted[..., :3] * opacity[..., None]
    shrunk = (int(right - left), int(bottom - top))
    opacity = cv2.resize(opacity, shrunk, interpolation=cv2.INTER_AREA)
    light = cv2.resize(light, shrunk, interpolation=cv2.INTER_AREA)
    region[:] = np.rint(region * (1 - opacity[..., None]) + light).astype(np.uint16)


def _to_camera(panel: Panel, view: Matrix, texture: NDArray[np.uint16]) -> Matrix:
    """(3, 3): a texel's column and row, 1 → the point in the camera's coordinates."""
    rows, columns = texture.shape[:2]
    step_x, step_y = panel.width / columns, panel.height / rows
    flat = np.array(
        [
            [step_x, 0, step_x / 2 - panel.width / 2],
            [0, -step_y, panel.height / 2 - step_y / 2],
            [0, 0, 0],
            [0, 0, 1],
        ]
    )
    to_camera: Matrix = (view @ panel.pose @ flat)[:3]
    return to_camera


def _level(panel: Panel, outline: Matrix, samples: int) -> NDArray[np.uint16]:
    """The level of the texture whose texels are about as large as what is sampled."""
    levels = _pyramid(panel.texture)
    area = abs(float(cv2.contourArea(outline.astype(np.float32)))) * samples**2
    texels = panel.texture.shape[0] * panel.texture.shape[1]
    index = int(math.log2(max(1.0, texels / max(area, 1.0))) / 2)
    return levels[min(index, len(levels) - 1)]


def _clipped(points: Matrix) -> Matrix:
    """A polygon's part that lies before the camera (Sutherland and Hodgman)."""
    kept = []
    for start, end in zip(points, np.roll(points, -1, axis=0), strict=True):
        if start[2] >= _NEAR:
            kept.append(start)
        if (start[2] >= _NEAR) != (end[2] >= _NEAR):
            kept.append(start + (end - start) * (_NEAR - start[2]) / (end[2] - start[2]))
    return np.array(kept).reshape(-1, 3)


def _project(points: Matrix, pinhole: Matrix) -> Matrix | None:
    if len(points) < 3:
        return None
    projected = (pinhole @ points.T).T
    # A corner that is almost beside the camera lies far outside the picture; drawing takes 26 bits.
    flat: Matrix = np.clip(projected[:, :2] / projected[:, 2:], -60_000, 60_000)
    return flat
