"""Boards of markers as one target with one pose: grids of ArUco markers or AprilTags, and ChArUco boards.

A board may be partly hidden or out of the image. Its pose is that of its middle: x right, y up, z out of its
face, as that of a single marker.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.calibration.markers import ArucoDetector, Grey, MarkerDetection, dictionary_by_name, located
from grabbergui.core.calibration import Calibration
from grabbergui.core.errors import UsageError

BOARD_KINDS = ("grid", "charuco")
FEWEST_POINTS = 6
"Corners that must be seen of a board: two markers of a grid, or six corners of ChArUco fields."
GAP = 0.25
"Of a marker's edge, between the markers of a grid and around those of a ChArUco board, unless it is given."


@dataclass(frozen=True)
class MarkerBoard:
    """A board as it is printed."""

    kind: str
    "`grid`: markers with gaps between them; `charuco`: a chessboard with markers in its white fields."
    columns: int
    "Markers across a grid, fields across a ChArUco board."
    rows: int
    size: float
    "Metres along the edge of a marker's black square."
    dictionary: str
    pitch: float = 0.0
    "Metres from one marker's edge to the next marker's; a field's edge. 0: a quarter more than `size`."
    first: int = 0
    "The first marker's number; the others follow row by row."

    def __post_init__(self) -> None:
        if self.kind not in BOARD_KINDS:
            raise UsageError(
                f"there is no kind of board '{self.kind}'; there are {' and '.join(BOARD_KINDS)}"
            )
        fewest = 1 if self.kind == "grid" else 3
        if not (fewest <= self.columns <= 50 and fewest <= self.rows <= 50 and self.columns * self.rows > 1):
            raise UsageError(
                f"a {self.kind} board of {self.columns}×{self.rows} cannot be used; "
                f"allowed is {fewest} to 50 each way, and more than one"
            )
        if not (math.isfinite(self.step) and self.size < self.step <= 10):
            raise UsageError(
                f"a pitch of {self.step:g} m must be more than the markers' size, {self.size:g} m, "
                "or they would overlap"
            )
        there = len(cv2.aruco.getPredefinedDictionary(dictionary_by_name(self.dictionary)).bytesList)
        if not 0 <= self.first <= there - self.markers:
            raise UsageError(
                f"the dictionary {self.dictionary} has the markers 0 to {there - 1}; "
                f"the board needs {self.markers} from {self.first} on"
            )

    @property
    def markers(self) -> int:
        """Return how many markers are on it."""
        fields = self.columns * self.rows
        return fields if self.kind == "grid" else fields // 2

    @property
    def step(self) -> float:
        """Return the metres from marker to marker, or of a field's edge."""
        return self.pitch or (1 + GAP) * self.size

    @property
    def extent(self) -> tuple[float, float]:
        """Return width and height of the printed pattern, metres."""
        gap = self.step - self.size if self.kind == "grid" else 0.0
        return self.columns * self.step - gap, self.rows * self.step - gap

    @cached_property
    def pattern(self) -> Any:
        """OpenCV's board; its origin is the upper left corner, y down."""
        numbers = cv2.aruco.getPredefinedDictionary(dictionary_by_name(self.dictionary))
        ids, shape = np.arange(self.first, self.first + self.markers), (self.columns, self.rows)
        if self.kind == "grid":
            return cv2.aruco.GridBoard(shape, self.size, self.step - self.size, numbers, ids)
        return cv2.aruco.CharucoBoard(shape, self.step, self.size, numbers, ids)

    def image(self, pixels_per_metre: float) -> Grey:
        """Return the board as it is printed, without a margin: (rows, columns) uint8."""
        width, height = (max(8, round(metres * pixels_per_metre)) for metres in self.extent)
        return np.asarray(self.pattern.generateImage((width, height)), np.uint8)

    def centred(self, points: NDArray[Any]) -> NDArray[np.float64]:
        """Return OpenCV's points of the board, (n, 3), from its middle and with y up."""
        width, height = self.extent
        flat = np.asarray(points, np.float64).reshape(-1, 3)
        return np.column_stack((flat[:, 0] - width / 2, height / 2 - flat[:, 1], np.zeros(len(flat))))


class BoardDetector:
    """Finds one board; detects it as if it were a marker. Use from one thread."""

    def __init__(self, board: MarkerBoard, calibration: Calibration | None = None) -> None:
        """Without a calibration there are no poses."""
        self._board = board
        self._calibration = calibration
        self._markers = ArucoDetector(board.dictionary, board.size)
        self._ids = range(board.first, board.first + board.markers)
        self._charuco = cv2.aruco.CharucoDetector(board.pattern) if board.kind == "charuco" else None

    def detect(self, grey: Grey) -> list[MarkerDetection]:
        """The board in an image (rows, columns) uint8: none, or one, with the reason if it has no pose."""
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
        """Return points on the board, (n, 3), and where they are seen, (n, 2) pixels."""
        corners = [marker.corners.astype(np.float32).reshape(1, 4, 2) for marker in markers]
        ids: Any = np.array([[marker.marker_id] for marker in markers], np.int32)
        found: Any = corners
        if self._charuco is not None:
            # Where fields meet, corners are sharper than those of markers.
            found, ids, _, _ = self._charuco.detectBoard(grey, None, None, corners, ids)
            if ids is None or len(ids) < FEWEST_POINTS:
                return np.zeros((0, 3)), np.zeros((0, 2))
        points, pixels = self._board.pattern.matchImagePoints(found, ids)
        return self._board.centred(points), np.asarray(pixels, np.float64).reshape(-1, 2)


def _around(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the corners of the box around points, clockwise from the upper left one."""
    (left, top), (right, bottom) = points.min(axis=0), points.max(axis=0)
    return np.array([(left, top), (right, top), (right, bottom), (left, bottom)])
