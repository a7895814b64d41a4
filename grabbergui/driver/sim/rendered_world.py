"""Flat things in space, their projection by a pinhole camera, and their textures.

A `Panel` is a textured rectangle: x to its right, y up, z out of its face. Poses are (4, 4) matrices to the
world's coordinates (x forward, y left, z up, metres). Textures are (rows, columns, 4) float32: red, green,
blue reflectance 0 to 1 and opacity; they are drawn once, without any image file.
"""

from __future__ import annotations

import math
import weakref
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.driver.sim.scene import ILLUMINANT, LUMINANCE, UNIT

Texture = NDArray[np.float32]
Colour = tuple[float, float, float]

Matrix = NDArray[np.float64]
_NEAR = 0.05
"Metres before the camera at which things are cut off."
_LEVELS = 6
pyramids: dict[int, dict[bool, list[NDArray[np.uint16]]]] = {}
"By the texture's id, as long as that lives, and whether they are grey."


def _opaque(rgb: NDArray[np.float32]) -> Texture:
    return np.dstack((rgb, np.ones(rgb.shape[:2], np.float32))).astype(np.float32)


@cache
def plaster(colour: Colour, seed: int, size: int = 512) -> Texture:
    """Return a wall: irregular brightness, a lighter rail, and lines at each quarter that show motion."""
    random = np.random.default_rng(seed)
    clouds = np.zeros((size, size), np.float32)
    for cells, weight in ((4, 0.10), (16, 0.06), (64, 0.03)):
        coarse = random.standard_normal((cells, cells)).astype(np.float32)
        clouds += weight * cv2.resize(coarse, (size, size), interpolation=cv2.INTER_CUBIC)
    rgb = np.clip(np.array(colour, np.float32) * (1 + clouds[..., None]), 0, 1)
    rgb[:: size // 4] *= 0.8
    rgb[:, :: size // 4] *= 0.8
    return _opaque(rgb)


@cache
def planks(size: int = 512, boards: int = 8) -> Texture:
    """Return a wooden floor."""
    random = np.random.default_rng(5)
    grain = cv2.resize(random.standard_normal((boards * 8, 24)).astype(np.float32), (size, size))
    tone = np.repeat(random.uniform(0.75, 1.1, boards).astype(np.float32), size // boards)[:, None]
    rgb = np.array((0.42, 0.29, 0.18), np.float32) * ((1 + 0.08 * grain) * tone)[..., None]
    rgb[:: size // boards] *= 0.5
    return _opaque(np.clip(rgb, 0, 1))


@cache
def marker_board(dictionary: int, marker_id: int, side: int = 640) -> Texture:
    """Return a white board with an ArUco marker that covers its middle 5/8."""
    board = np.full((side, side), 0.9, np.float32)
    inner = side * 5 // 8
    drawn = cv2.aruco.generateImageMarker(
        cv2.aruco.getPredefinedDictionary(dictionary), marker_id, inner, borderBits=1
    )
    start = (side - inner) // 2
    board[start : start + inner, start : start + inner] = 0.04 + 0.86 * (drawn / 255)
    return _opaque(np.repeat(board[..., None], 3, axis=2))


def printed(drawing: NDArray[np.uint8], border: int) -> Texture:
    """Return a grey drawing (rows, columns) as ink on paper, with a white border given in its pixels."""
    wide = cv2.copyMakeBorder(drawing, border, border, border, border, cv2.BORDER_CONSTANT, value=(255,))
    grey = np.float32(0.04) + np.float32(0.86 / 255) * wide.astype(np.float32)
    return _opaque(np.dstack((grey, grey, grey)))


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
        """Return the distance in metres from a point to its plane, which decides which panel hides another.

        Not to its middle: of two that hang one behind the other the lower is nearer to a low eye.
        """
        return float((eye - self.pose[:3, 3]) @ self.pose[:3, 2])


def _pyramid(texture: Texture, grey: bool) -> list[NDArray[np.uint16]]:
    """Return a texture's radiance and opacity (65535 is solid) at full size, half size and so on.

    (rows, columns, 4), the radiance multiplied by the opacity. In `grey` it is three times the same: OpenCV
    projects four channels of 16 bits faster than any other number.
    """
    kinds = pyramids.get(id(texture))
    if kinds is None:
        kinds = pyramids[id(texture)] = {}
        weakref.finalize(texture, pyramids.pop, id(texture), None)
    levels = kinds.get(grey)
    if levels is None:
        light: Any = texture[..., :3] * np.array([UNIT * answer for answer in ILLUMINANT], np.float32)
        light = cv2.transform(light, np.repeat(LUMINANCE, 3, axis=0)) if grey else light
        opacity = texture[..., 3:]
        levels = [np.rint(np.dstack((light * opacity, 65535 * opacity))).astype(np.uint16)]
        while len(levels) < _LEVELS and min(levels[-1].shape[:2]) > 8:
            height, width = levels[-1].shape[:2]
            half = cv2.resize(levels[-1], (width // 2, height // 2), interpolation=cv2.INTER_AREA)
            levels.append(np.asarray(half, np.uint16))
        kinds[grey] = levels
    return levels


def draw(panel: Panel, out: NDArray[np.uint16], view: Matrix, pinhole: Matrix) -> None:
    """Lay a panel over `out`, (rows, columns, 3), or (rows, columns) in grey.

    `view` takes the world to the camera (z forward, y down), `pinhole` (3, 3) directions to pixels.
    """
    seen = (view[:3, :3] @ panel.corners.T).T + view[:3, 3]
    if np.linalg.det(seen[[0, 1, 3]]) <= 0:
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
    texture = _level(panel, outline, samples, grey=out.ndim == 2)
    size = (int(right - left) * samples, int(bottom - top) * samples)
    # Beyond the last texel's middle there is as much of it again, and the mask cuts at its end.
    painted = cv2.warpPerspective(
        texture,
        place @ pinhole @ _to_camera(panel, view, texture),
        size,
        borderMode=cv2.BORDER_REPLICATE,
    )
    mask = np.zeros((size[1], size[0]), np.uint8)
    shape = np.rint(((outline - (left, top) + 0.5) * samples - 0.5) * 16).astype(np.int32)
    cv2.fillConvexPoly(mask, shape, 255, cv2.LINE_8, 4)
    region = out[top:bottom, left:right]
    if not panel.fine:
        cv2.copyTo(_light(painted, region), mask, region)
        return
    covered = cv2.resize(
        cv2.copyTo(painted, mask), (int(right - left), int(bottom - top)), interpolation=cv2.INTER_AREA
    )
    shade: Any = 1 - cv2.extractChannel(covered, 3) * np.float32(1 / 65535)
    if region.ndim == 3:  # numpy takes three times as long to repeat a channel
        shade = cv2.cvtColor(shade, cv2.COLOR_GRAY2BGR)
    cv2.add(cv2.multiply(region, shade, dtype=cv2.CV_16U), _light(covered, region), dst=region)


def _light(painted: Any, out: NDArray[np.uint16]) -> Any:
    """Return the radiance alone, in as many channels as `out` has."""
    return cv2.extractChannel(painted, 0) if out.ndim == 2 else cv2.cvtColor(painted, cv2.COLOR_BGRA2BGR)


def _to_camera(panel: Panel, view: Matrix, texture: NDArray[np.uint16]) -> Matrix:
    """Return the matrix (3, 3) from a texel (column, row, 1) to the camera's coordinates."""
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


def _level(panel: Panel, outline: Matrix, samples: int, grey: bool) -> NDArray[np.uint16]:
    """Return the level of the texture whose texels are about as large as the sampled area."""
    levels = _pyramid(panel.texture, grey)
    area = abs(float(cv2.contourArea(outline.astype(np.float32)))) * samples**2
    texels = panel.texture.shape[0] * panel.texture.shape[1]
    index = int(math.log2(max(1.0, texels / max(area, 1.0))) / 2)
    return levels[min(index, len(levels) - 1)]


def _clipped(points: Matrix) -> Matrix:
    """Return a polygon's part that lies before the camera (Sutherland and Hodgman)."""
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
    # A corner almost level with the camera projects far outside the image; drawing takes 26 bits.
    flat: Matrix = np.clip(projected[:, :2] / projected[:, 2:], -60_000, 60_000)
    return flat
