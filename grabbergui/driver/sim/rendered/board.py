"""`sim:board`: a person who shows a ChArUco board to the camera, so that calibrating can be tried.

The board goes from pose to pose and rests at each: in every part of the picture, near and far, tilted. The
lens is a perfect one, so a good calibration finds no distortion, and the focal length of `scene.pinhole`.
"""

from __future__ import annotations

import math
from dataclasses import astuple, dataclass
from functools import cache

import cv2
import numpy as np

from grabbergui.driver.sim.rendered.scene import RenderedScene, Things, swaying
from grabbergui.driver.sim.rendered.textures import Texture
from grabbergui.driver.sim.rendered.world import Matrix, Panel

COLUMNS, ROWS, SQUARE, MARKER = 8, 6, 0.030, 0.022
"Fields across and down, edges of a field and of a marker in metres."
DICTIONARY = cv2.aruco.DICT_5X5_100
BORDER = 0.015
"Metres of white around."
MOVE_S, REST_S = 0.5, 0.9
"How long it takes from pose to pose, and stays."

_CAMERA = np.array([[0, 0, 1.0, 0.1], [-1.0, 0, 0, 0], [0, -1.0, 0, 0.75], [0, 0, 0, 1.0]])
"It looks straight ahead."
_HALF_X, _HALF_Y = 0.625, 0.525
"What half of the picture spans at a metre's distance, with the sensor's middle as after power-on."


@dataclass(frozen=True)
class Hold:
    """How the board is held."""

    across: float
    "−1 to 1: as far to the left or right as it can be seen whole, or nearly."
    down: float
    distance: float
    "Metres."
    yaw: float = 0.0
    "Degrees; its left edge comes nearer."
    pitch: float = 0.0
    "Degrees; its upper edge comes nearer."
    roll: float = 0.0

    def towards(self, other: Hold, part: float) -> Hold:
        """On the way to another."""
        smooth = part * part * (3 - 2 * part)
        return Hold(*(a + (b - a) * smooth for a, b in zip(astuple(self), astuple(other), strict=True)))

    @property
    def pose(self) -> Matrix:
        """In the camera's frame; the board's x to its right, y up, z out of its face."""
        yaw, pitch, roll = (math.radians(angle) for angle in (self.yaw, self.pitch, self.roll))
        rotation, _ = cv2.Rodrigues(np.array([0.0, yaw, 0.0]))
        tipped, _ = cv2.Rodrigues(np.array([pitch, 0.0, 0.0]))
        turned, _ = cv2.Rodrigues(np.array([0.0, 0.0, roll]))
        reach_x = 0.95 * _HALF_X * self.distance - SQUARE * (COLUMNS / 2 - 1)
        reach_y = 0.95 * _HALF_Y * self.distance - SQUARE * (ROWS / 2 - 1)
        pose = np.eye(4)
        pose[:3, :3] = rotation @ tipped @ turned @ np.diag([1.0, -1.0, -1.0])
        pose[:3, 3] = (self.across * reach_x, self.down * reach_y, self.distance)
        return pose


def holds() -> list[Hold]:
    """One round: parts of the picture and tilts in turn, so that few views cover much."""
    places = [
        Hold(across, down, 0.48, yaw, pitch)
        for across, down, yaw, pitch in (
            (0, 0, 0, 0), (-1, -1, 8, -8), (1, -1, -8, -8), (1, 1, -8, 8), (-1, 1, 8, 8),
            (0, -1, 0, -10), (0, 1, 0, 10), (-1, 0, 10, 0), (1, 0, -10, 0),
        )
    ]  # fmt: skip
    tilts = [
        Hold(0.2, 0.0, 0.45, 33), Hold(-0.2, 0.1, 0.45, -33), Hold(0.1, -0.1, 0.45, 0, 33),
        Hold(0.0, 0.2, 0.45, 0, -33), Hold(-0.3, -0.2, 0.5, 28, 24), Hold(0.3, 0.2, 0.5, -28, -24),
        Hold(0.0, 0.0, 0.28, 12, -6), Hold(0.0, 0.0, 0.29, -10, 10, 6),
        Hold(-0.6, 0.4, 0.75, -20, 12), Hold(0.7, -0.5, 0.8, 25, -10, -8), Hold(0.0, 0.6, 0.7, 18, -25),
        Hold(-0.8, -0.7, 0.5, 30, 10), Hold(0.8, 0.7, 0.5, -30, -12), Hold(0.5, -0.8, 0.42, 15, 28),
    ]  # fmt: skip
    both = [hold for pair in zip(places, tilts, strict=False) for hold in pair]
    return [*both, *tilts[len(places) :]]


class BoardScene(RenderedScene):
    """The room with a person who shows the board."""

    def __init__(self) -> None:
        super().__init__(Things(face=swaying(z=0.7), board=lambda seconds: None))
        self._holds = holds()
        self.mount(lambda time_ns: _CAMERA)

    def hold_at(self, seconds: float) -> Hold:
        """How the board is held at a time on the device's clock."""
        turn, since = divmod(seconds, MOVE_S + REST_S)
        here = self._holds[int(turn) % len(self._holds)]
        if since <= REST_S:
            return here
        return here.towards(self._holds[(int(turn) + 1) % len(self._holds)], (since - REST_S) / MOVE_S)

    def _standing(self, seconds: float) -> list[Panel]:
        pose = _CAMERA @ self.hold_at(seconds).pose
        width, height = COLUMNS * SQUARE + 2 * BORDER, ROWS * SQUARE + 2 * BORDER
        return [*super()._standing(seconds), Panel(pose, width, height, _texture(), fine=True)]


@cache
def _texture(pixels: int = 3600) -> Texture:
    """The board as it is printed, `pixels` per metre."""
    board = cv2.aruco.CharucoBoard(
        (COLUMNS, ROWS), SQUARE, MARKER, cv2.aruco.getPredefinedDictionary(DICTIONARY)
    )
    field, border = round(SQUARE * pixels), round(BORDER * pixels)
    drawn = board.generateImage((COLUMNS * field, ROWS * field))
    drawn = cv2.copyMakeBorder(drawn, border, border, border, border, cv2.BORDER_CONSTANT, value=255)
    grey = np.float32(0.04) + np.float32(0.86 / 255) * drawn.astype(np.float32)
    return np.dstack((grey, grey, grey, np.ones_like(grey)))
