"""What the things of the rendered scene look like: reflectances, drawn once, without any picture file.

Textures are (rows, columns, 4) float32: red, green, blue reflectance 0 to 1 and opacity.
"""

from __future__ import annotations

from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

Texture = NDArray[np.float32]
Colour = tuple[float, float, float]

_HAIR, _SKIN = (0.10, 0.06, 0.04), (0.80, 0.60, 0.48)


def _opaque(rgb: NDArray[np.float32]) -> Texture:
    return np.dstack((rgb, np.ones(rgb.shape[:2], np.float32))).astype(np.float32)


@cache
def plaster(colour: Colour, seed: int, size: int = 512) -> Texture:
    """A wall: clouds of lighter and darker, a lighter rail, and a line every quarter to see motion by."""
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
    """A wooden floor."""
    random = np.random.default_rng(5)
    grain = cv2.resize(random.standard_normal((boards * 8, 24)).astype(np.float32), (size, size))
    tone = np.repeat(random.uniform(0.75, 1.1, boards).astype(np.float32), size // boards)[:, None]
    rgb = np.array((0.42, 0.29, 0.18), np.float32) * ((1 + 0.08 * grain) * tone)[..., None]
    rgb[:: size // boards] *= 0.5
    return _opaque(np.clip(rgb, 0, 1))


@cache
def marker_board(dictionary: int, marker_id: int, side: int = 640) -> Texture:
    """A white board with an ArUco marker that covers its middle 5/8."""
    board = np.full((side, side), 0.9, np.float32)
    inner = side * 5 // 8
    drawn = cv2.aruco.generateImageMarker(
        cv2.aruco.getPredefinedDictionary(dictionary), marker_id, inner, borderBits=1
    )
    start = (side - inner) // 2
    board[start : start + inner, start : start + inner] = 0.04 + 0.86 * (drawn / 255)
    return _opaque(np.repeat(board[..., None], 3, axis=2))


@cache
def torso(size: int = 128) -> Texture:
    """Shoulders in a pullover, cut out."""
    drawing = _Drawing(size, (0.16, 0.25, 0.42))
    rows, columns = drawing.y, drawing.x
    wide = 40 + 84 * np.clip((rows - 4) / 70, 0, 1) ** 0.5
    drawing.rgb *= (0.75 + 0.25 * np.exp(-(((columns - 128) / 90) ** 2)))[..., None]
    return np.dstack((drawing.rgb, (np.abs(columns - 128) < wide).astype(np.float32)))


@cache
def face(size: int = 256) -> Texture:
    """A face from the front, cut out; a cascade classifier takes it for one."""
    drawing = _Drawing(size, _HAIR)
    head = np.maximum(drawing.blob(128, 110, 88, 104, 0.05), drawing.blob(128, 225, 34, 50, 0.05))
    drawing.paint(drawing.blob(128, 245, 40, 60), (0.62, 0.45, 0.36))
    oval = drawing.blob(128, 136, 70, 94, 0.06)
    drawing.paint(oval, _SKIN)
    sides = 0.72 + 0.28 * np.exp(-(((drawing.x - 128) / 58) ** 2))
    drawing.rgb *= (1 - oval * (1 - sides))[..., None]
    drawing.paint(0.9 * drawing.blob(128, 56, 66, 34, 0.3), _HAIR)
    for side in (-1, 1):
        _eye(drawing, 128 + side * 30)
    drawing.paint(0.5 * drawing.blob(128, 132, 8, 34, 1.0), (0.95, 0.76, 0.63))
    drawing.paint(0.5 * drawing.blob(128, 160, 17, 6, 0.9), (0.5, 0.32, 0.26))
    for side in (-1, 1):
        drawing.paint(0.8 * drawing.blob(128 + side * 8, 162, 4, 2.5, 0.6), (0.3, 0.16, 0.13))
    drawing.paint(0.9 * drawing.blob(128, 190, 27, 7.5, 0.3), (0.62, 0.26, 0.24))
    drawing.paint(0.9 * drawing.blob(128, 189, 26, 1.6, 0.5), (0.25, 0.08, 0.08))
    drawing.paint(0.35 * drawing.blob(128, 204, 18, 4, 1.0), (0.45, 0.3, 0.24))
    return np.dstack((drawing.rgb, head)).astype(np.float32)


def _eye(drawing: _Drawing, x: float) -> None:
    drawing.paint(0.55 * drawing.blob(x, 112, 24, 15, 0.9), (0.35, 0.22, 0.17))  # socket
    drawing.paint(0.9 * drawing.blob(x, 98, 21, 4.5, 0.5), _HAIR)  # brow
    drawing.paint(drawing.blob(x, 116, 14, 6.5, 0.25), (0.9, 0.88, 0.85))
    drawing.paint(drawing.blob(x, 116, 6.5, 6.5, 0.2), (0.12, 0.08, 0.06))
    drawing.paint(drawing.blob(x - 2, 114, 1.8, 1.8, 0.4), (0.95, 0.95, 0.95))
    drawing.paint(0.8 * drawing.blob(x, 110, 16, 2.2, 0.5), (0.12, 0.07, 0.05))  # lid


class _Drawing:
    """Ellipses with soft edges on a square of 256 units."""

    def __init__(self, size: int, ground: Colour) -> None:
        units = (np.arange(size, dtype=np.float32) + 0.5) * (256 / size)
        self.x, self.y = np.meshgrid(units, units)
        self.rgb = np.tile(np.array(ground, np.float32), (size, size, 1))

    def blob(self, x: float, y: float, wide: float, high: float, soft: float = 0.08) -> NDArray[np.float32]:
        """Opacity of an ellipse, its edge `soft` of its radius wide."""
        radius = np.hypot((self.x - x) / wide, (self.y - y) / high)
        opacity: NDArray[np.float32] = np.clip((1 - radius) / soft + 0.5, 0, 1).astype(np.float32)
        return opacity

    def paint(self, opacity: NDArray[np.float32], colour: Colour) -> None:
        """Lay a colour over what is there."""
        weight = opacity[..., None]
        self.rgb = self.rgb * (1 - weight) + weight * np.array(colour, np.float32)
