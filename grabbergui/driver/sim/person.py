"""A person from the front, painted as a texture: a face that a detector takes for one, and a torso."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from grabbergui.driver.sim.rendered_world import Colour, Texture

_HAIR, _SKIN = (0.10, 0.06, 0.04), (0.80, 0.60, 0.48)


@cache
def torso(size: int = 128) -> Texture:
    """Return shoulders in a pullover, cut out."""
    drawing = _Drawing(size, (0.16, 0.25, 0.42))
    rows, columns = drawing.y, drawing.x
    wide = 40 + 84 * np.clip((rows - 4) / 70, 0, 1) ** 0.5
    drawing.rgb *= (0.75 + 0.25 * np.exp(-(((columns - 128) / 90) ** 2)))[..., None]
    return np.dstack((drawing.rgb, (np.abs(columns - 128) < wide).astype(np.float32)))


@cache
def face(size: int = 256) -> Texture:
    """Return a face from the front, cut out; a cascade classifier takes it for one."""
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
        """Return the opacity of an ellipse whose edge is `soft` times its radius wide."""
        radius = np.hypot((self.x - x) / wide, (self.y - y) / high)
        opacity: NDArray[np.float32] = np.clip((1 - radius) / soft + 0.5, 0, 1).astype(np.float32)
        return opacity

    def paint(self, opacity: NDArray[np.float32], colour: Colour) -> None:
        """Blend a colour over the texture."""
        weight = opacity[..., None]
        self.rgb = self.rgb * (1 - weight) + weight * np.array(colour, np.float32)
