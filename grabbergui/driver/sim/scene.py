"""The scene in front of the simulated camera.

A scene gives linear radiance: `UNIT` is the light that fills a pixel to white in `UNIT_EXPOSURE_US` at 0 dB.
Any image can be a scene; the default one is drawn here: a grey gradient that wanders, with things in it
that show focus, motion and colour.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.driver.sim.registers import SENSOR_HEIGHT, SENSOR_WIDTH
from grabbergui.driver.sim.settings import FrameSettings

UNIT = 8192
UNIT_EXPOSURE_US = 10_000.0

ILLUMINANT = (1 / 1.6, 1.0, 1 / 1.3)
"Response of the sensor to the scene's light in red, green and blue; white balance has to compensate it."
LUMINANCE = np.array([[0.299, 0.587, 0.114]], np.float32)
"Weight of each colour in a grey image."
_STRIP_ROWS = 64
"So many rows stay in the processor's cache."
_SPAN = (2640, 2240)
"""Columns and rows in the middle over which the gradient runs from dark to bright."""
_PATCHES = (
    (0.60, 0.10, 0.10), (0.75, 0.30, 0.06), (0.80, 0.62, 0.08), (0.34, 0.58, 0.10), (0.08, 0.45, 0.16),
    (0.06, 0.45, 0.42), (0.07, 0.30, 0.62), (0.12, 0.12, 0.55), (0.36, 0.12, 0.50), (0.66, 0.16, 0.36),
)  # fmt: skip
"Reflectances in red, green and blue."


@dataclass(frozen=True)
class SceneView:
    """The view of the sensor at one moment: a window on an image."""

    image: NDArray[np.uint16]
    "(rows, columns, 3) radiance in red, green, blue. The same object as long as it did not change."
    x: int = 0
    "Column of the image on which the sensor's first pixel lies; even, and so is `y`."
    y: int = 0


class Scene(ABC):
    """Something to look at. Used from one thread, the one that renders."""

    ahead = 0.0
    """Seconds before an exposure's end at which its image may be drawn, if what it shows can be foretold.

    A sensor has its image when the exposure ends; one that is only drawn then comes late by the drawing.
    """

    @abstractmethod
    def view(self, time_ns: int) -> SceneView:
        """Return the view at a time on the device's clock; at least a sensor's size from (x, y) on."""

    def prepare(self) -> None:
        """Do once what takes long, which must not make the first frames late."""
        self.view(0)

    def rendered(
        self, time_ns: int, settings: FrameSettings, *, grey: bool = False
    ) -> NDArray[np.uint16] | None:
        """Return one frame's radiance (height, width, 3): binned, mirrored and cropped.

        In `grey` it is (height, width), which takes a third of the time.

        For scenes that change with every frame, so that only the visible part is drawn. The default, None,
        means that `view` is used.
        """
        return None


class StudioScene(Scene):
    """A grey gradient with test figures, wandering slowly on a figure of eight."""

    MARGIN = 192
    "Largest displacement in pixels."
    PERIOD_S = 12.0

    def view(self, time_ns: int) -> SceneView:
        """Return the studio, moved on."""
        phase = 2 * math.pi * (time_ns * 1e-9 / self.PERIOD_S)
        x = round(self.MARGIN / 2 * (1 + math.sin(phase)))
        y = round(self.MARGIN / 2 * (1 + math.sin(2 * phase) / 2))
        return SceneView(studio_image(), x & ~1, y & ~1)


@cache
def studio_image() -> NDArray[np.uint16]:
    """Return the default scene, drawn once: the sensor and its margin, radiance up to about 1.3 units.

    Whole numbers, in strips: memory that is touched for the first time costs more than what is drawn in it.
    """
    height, width = SENSOR_HEIGHT + StudioScene.MARGIN, SENSOR_WIDTH + StudioScene.MARGIN
    grey = _gradient(height, width)
    _grid(grey)
    centre = (width // 2, height // 2)
    _siemens_star(grey, (centre[0] - 300, centre[1] - 60), 210)
    _steps(grey, (centre[0] - 480, centre[1] + 250), 96, 10)
    _line_pairs(grey, (centre[0] + 60, centre[1] - 270))
    _checkerboard(grey, (centre[0] + 330, centre[1] - 80), 40, (7, 5))
    for x, y in ((360, 330), (width - 360, 330), (360, height - 330), (width - 360, height - 330)):
        _siemens_star(grey, (x, y), 150)
        cv2.circle(grey, (x, y), 190, 0.75 * UNIT, 6, cv2.LINE_AA)
    cv2.putText(
        grey,
        "grabbergui",
        (centre[0] - 10, centre[1] + 205),
        cv2.FONT_HERSHEY_DUPLEX,
        2.6,
        0.95 * UNIT,
        5,
        cv2.LINE_AA,
    )
    image = np.empty((height, width, 3), np.uint16)
    answers: tuple[Any, ...] = ILLUMINANT
    for rows in _strips(height):
        cv2.merge([cv2.multiply(grey[rows], answer) for answer in answers], image[rows])
    _colour_patches(image, (centre[0] - 480, centre[1] + 370), 96)
    return image


def _strips(height: int) -> Iterator[slice]:
    return (slice(top, top + _STRIP_ROWS) for top in range(0, height, _STRIP_ROWS))


def _gradient(height: int, width: int) -> NDArray[np.uint16]:
    """Return grey from dark to bright along the diagonal, with a soft spot of light."""
    x = (np.arange(width, dtype=np.float32) - width / 2) / _SPAN[0] + 0.5
    y = (np.arange(height, dtype=np.float32)[:, None] - height / 2) / _SPAN[1] + 0.5
    spot_x, spot_y = np.exp(-(((x - 0.66) / 0.22) ** 2)), np.exp(-(((y - 0.36) / 0.22) ** 2))
    grey = np.empty((height, width), np.uint16)
    for rows in _strips(height):
        strip = (0.18 * UNIT * spot_y[rows]) * spot_x
        strip += np.float32(0.31 * UNIT) * x
        strip += np.float32(0.31 * UNIT) * y[rows] + np.float32(0.06 * UNIT)
        grey[rows] = np.maximum(strip, 0.02 * UNIT, out=strip)
    return grey


def _grid(grey: NDArray[np.uint16]) -> None:
    """Draw lines every 128 pixels, one of them through the centre."""
    height, width = grey.shape
    for lines in (grey[height // 2 % 128 :: 128], grey[:, width // 2 % 128 :: 128]):
        lines[...] = lines * 0.86


def _siemens_star(grey: NDArray[np.uint16], centre: tuple[int, int], radius: int, spokes: int = 36) -> None:
    """Draw spokes that converge at the centre; the radius at which they merge shows the sharpness."""
    x0, y0 = centre
    y, x = np.mgrid[-radius : radius + 1, -radius : radius + 1].astype(np.float32)
    distance = np.hypot(x, y)
    # The edge is as wide as a pixel, so that the star looks as if a lens had drawn it.
    wave = np.sin(np.arctan2(y, x) * spokes) * distance / spokes * 2
    star = (0.05 + 0.85 * np.clip(wave + 0.5, 0, 1)) * UNIT
    patch = grey[y0 - radius : y0 + radius + 1, x0 - radius : x0 + radius + 1]
    np.copyto(patch, star, "unsafe", where=distance <= radius)


def _steps(grey: NDArray[np.uint16], corner: tuple[int, int], size: int, count: int) -> None:
    """Draw neutral patches from black to beyond white."""
    x, y = corner
    for index, value in enumerate(np.linspace(0.02, 1.1, count)):
        grey[y : y + size, x + index * size : x + (index + 1) * size] = value * UNIT


def _line_pairs(grey: NDArray[np.uint16], corner: tuple[int, int]) -> None:
    """Draw vertical lines of 1 to 6 pixels."""
    x, y = corner
    for width in range(1, 7):
        columns = (np.arange(72) // width) % 2
        grey[y : y + 130, x : x + 72] = np.where(columns, 0.9, 0.05) * UNIT
        x += 84


def _checkerboard(
    grey: NDArray[np.uint16], corner: tuple[int, int], size: int, fields: tuple[int, int]
) -> None:
    x, y = corner
    columns, rows = fields
    board = (0.05 + 0.85 * (np.indices((rows, columns)).sum(axis=0) % 2)) * UNIT
    grey[y : y + rows * size, x : x + columns * size] = np.kron(board, np.ones((size, size)))


def _colour_patches(image: NDArray[np.uint16], corner: tuple[int, int], size: int) -> None:
    x, y = corner
    for patch in _PATCHES:
        image[y : y + size, x : x + size] = np.multiply(patch, ILLUMINANT) * UNIT
        x += size
