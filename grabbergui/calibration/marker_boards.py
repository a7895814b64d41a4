"""Boards of markers (a grid, or a ChArUco board), and their detection in an image.

A board may be partly hidden or outside the image.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.calibration.marker_pose import MarkerDetection, located
from grabbergui.calibration.markers import ArucoDetector, Grey, dictionary_named
from grabbergui.core.calibration import Calibration
from grabbergui.core.errors import UsageError

BOARD_KINDS = ("grid", "charuco")
FEWEST_POINTS = 6
"Fewest visible corners of a board: two markers of a grid, or six corners of ChArUco squares."
GAP = 0.25
"Default gap between markers of a grid, and around those of a ChArUco board, relative to a marker's edge."


@dataclass(frozen=True)
class MarkerBoard:
    """The description of a printed board."""

    kind: str
    "`grid`: markers with gaps between them; `charuco`: a chessboard with markers in its white squares."
    columns: int
    "Markers across a grid, squares across a ChArUco board."
    rows: int
    size: float
    "Edge of a marker's black square, metres."
    dictionary: str
    pitch: float = 0.0
    "Metres from marker to marker, or the edge of a square; 0 for a quarter more than `size`."
    first: int = 0
    "Id of the first marker; the others follow row by row."

    def __post_init__(self) -> None:
        if self.kind not in BOARD_KINDS:
            raise UsageError(
                f"there is no kind of board '{self.kind}'; there are {' and '.join(BOARD_KINDS)}"
            )
        fewest = 1 if self.kind == "grid" else 3
        if not (fewest <= self.columns <= 50 and fewest <= self.rows <= 50 and self.columns * self.rows > 1):
            raise UsageError(
                f"a {self.kind} board of {self.columns}×{self.rows} cannot be used; "
                f"allowed: {fewest} to 50 each way, and more than one"
            )
        if not (math.isfinite(self.step) and self.size < self.step <= 10):
            raise UsageError(
                f"a pitch of {self.step:g} m must be more than the markers' size, {self.size:g} m, "
                "or they would overlap"
            )
        ids = len(dictionary_named(self.dictionary).bytesList)
        if not 0 <= self.first <= ids - self.markers:
            raise UsageError(
                f"the dictionary {self.dictionary} has the markers 0 to {ids - 1}; "
                f"the board needs {self.markers} from {self.first} on"
            )

    @property
    def markers(self) -> int:
        """Number of markers."""
        fields = self.columns * self.rows
        return fields if self.kind == "grid" else fields // 2

    @property
    def step(self) -> float:
        """Metres from marker to marker, or the edge of a square."""
        return self.pitch or (1 + GAP) * self.size

    @property
    def extent(self) -> tuple[float, float]:
        """Width and height of the printed pattern, metres."""
        gap = self.step - self.size if self.kind == "grid" else 0.0
        return self.columns * self.step - gap, self.rows * self.step - gap

    @cached_property
    def pattern(self) -> Any:
        """OpenCV's board; its origin is the upper left corner, y down."""
        numbers = dictionary_named(self.dictionary)
        ids, shape = np.arange(self.first, self.first + self.markers), (self.columns, self.rows)
        if self.kind == "grid":
            return cv2.aruco.GridBoard(shape, self.size, self.step - self.size, numbers, ids)
        return cv2.aruco.CharucoBoard(shape, self.step, self.size, numbers, ids)

    def image(self, pixels_per_metre: float) -> Grey:
        """Return the printed board without a margin: (rows, columns) uint8."""
        width, height = (max(8, round(metres * pixels_per_metre)) for metres in self.extent)
        return np.asarray(self.pattern.generateImage((width, height)), np.uint8)

    def centred(self, points: NDArray[Any]) -> NDArray[np.float64]:
        """Convert OpenCV's points of the board to (n, 3) coordinates from its centre, with y up."""
        width, height = self.extent
        flat = np.asarray(points, np.float64).reshape(-1, 3)
        return np.column_stack((flat[:, 0] - width / 2, height / 2 - flat[:, 1], np.zeros(len(flat))))


class BoardDetector:
    """Detects a board as if it were a marker. Use from one thread."""

    def __init__(self, board: MarkerBoard, calibration: Calibration | None = None) -> None:
        """Without a calibration there are no poses."""
        self._board = board
        self._calibration = calibration
        self._markers = ArucoDetector(board.dictionary, board.size)
        self._ids = range(board.first, board.first + board.markers)
        self._charuco = cv2.aruco.CharucoDetector(board.pattern) if board.kind == "charuco" else None

    def detect(self, grey: Grey) -> list[MarkerDetection]:
        """Return the board in an image (rows, columns) uint8, if any, with the reason if it has no pose."""
        markers = [marker for marker in self._markers.detect(grey) if marker.marker_id in self._ids]
        if not markers:
            return []
        seen = MarkerDetection(self._board.first, _around(np.vstack([marker.corners for marker in markers])))
        if len({marker.marker_id for marker in markers}) < len(markers):
            return [replace(seen, problem="several boards are seen")]
        points, pixels = self._corners(grey, markers)
        if len(points) < FEWEST_POINTS or np.linalg.matrix_rank(points - points.mean(axis=0), 1e-6) < 2:
            return [replace(seen, problem="too little of the board is seen")]
        width, height = self._board.extent
        outline = np.array([(-1, 1), (1, 1), (1, -1), (-1, -1)], np.float64) * (width / 2, height / 2)
        plane, _ = cv2.findHomography(points[:, :2], pixels)
        if plane is not None:
            corners = cv2.perspectiveTransform(outline[:, None], plane).reshape(4, 2)
            seen = replace(seen, corners=np.asarray(corners, np.float64))
        if self._calibration is None:
            return [replace(seen, problem="the camera is not calibrated")]
        return [located(seen, points, pixels, self._calibration.scaled_to(grey.shape[1], grey.shape[0]))]

    def _corners(
        self, grey: Grey, markers: list[MarkerDetection]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return points on the board, (n, 3), and in the image, (n, 2) pixels."""
        corners = [marker.corners.astype(np.float32).reshape(1, 4, 2) for marker in markers]
        ids: Any = np.array([[marker.marker_id] for marker in markers], np.int32)
        found: Any = corners
        if self._charuco is not None:
            # The corners where fields meet are sharper than those of markers.
            found, ids, _, _ = self._charuco.detectBoard(grey, None, None, corners, ids)
            if ids is None or len(ids) < FEWEST_POINTS:
                return np.zeros((0, 3)), np.zeros((0, 2))
        points, pixels = self._board.pattern.matchImagePoints(found, ids)
        return self._board.centred(points), np.asarray(pixels, np.float64).reshape(-1, 2)


def _around(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the corners of the box around points, clockwise from the upper left one."""
    (left, top), (right, bottom) = points.min(axis=0), points.max(axis=0)
    return np.array([(left, top), (right, top), (right, bottom), (left, bottom)])
