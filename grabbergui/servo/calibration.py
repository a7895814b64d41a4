"""Calibrating a camera from views of a printed board: ChArUco or chessboard.

A `Collector` takes pictures one after the other and keeps those views that add something; it tells how much
of the picture is covered by now. Once there are enough, `solve` gives the calibration with the error of
every view, and leaves out views that fit badly.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.core.calibration import Calibration
from grabbergui.core.errors import UsageError
from grabbergui.servo.aruco import dictionary_by_name
from grabbergui.servo.detection import Grey

Points = NDArray[np.float32]

GRID = (8, 6)
"Cells, across and down, in which coverage is counted."
FEWEST_VIEWS = 5
FEWEST_CORNERS = 8
_DIFFERENT = 0.06
"How far a view must be from all others, in parts of the picture and of its own size and tilt."
_BAD_VIEW = 2.5
"A view whose error is so many times the median is left out."


@dataclass(frozen=True, eq=False)
class View:
    """The board in one picture."""

    board: Points
    "(n, 3) corners on the board, metres."
    picture: Points
    "(n, 2) where they are seen, pixels."


class Board(Protocol):
    """A pattern of known size."""

    def find(self, grey: Grey) -> View | None:
        """Its corners in a picture, to a fraction of a pixel; None where too few are seen."""
        ...


class CharucoBoard:
    """A chessboard with markers in its white fields; may be partly out of the picture."""

    def __init__(self, columns: int, rows: int, square: float, marker: float, dictionary: str) -> None:
        """Numbers of fields, and edges of field and marker in metres."""
        _check(columns, rows, square)
        if not 0 < marker < square:
            raise UsageError(f"a marker of {marker:g} m does not fit into a field of {square:g} m")
        numbers = cv2.aruco.getPredefinedDictionary(dictionary_by_name(dictionary))
        if columns * rows // 2 > len(numbers.bytesList):
            raise UsageError(
                f"{dictionary} has {len(numbers.bytesList)} markers, the board needs {columns * rows // 2}"
            )
        self.pattern: Any = cv2.aruco.CharucoBoard((columns, rows), square, marker, numbers)
        "OpenCV's board, to print."
        self._detector = cv2.aruco.CharucoDetector(self.pattern)

    def find(self, grey: Grey) -> View | None:
        """See Board."""
        corners, ids, _, _ = self._detector.detectBoard(grey)
        if ids is None or len(ids) < FEWEST_CORNERS:
            return None
        board, picture = self.pattern.matchImagePoints(corners, ids)
        view = View(np.float32(board).reshape(-1, 3), np.float32(picture).reshape(-1, 2))
        # Corners of a single row say nothing about perspective.
        return view if np.ptp(view.board[:, 0]) > 0 and np.ptp(view.board[:, 1]) > 0 else None


class Chessboard:
    """A plain chessboard; all of it must be seen."""

    def __init__(self, columns: int, rows: int, square: float) -> None:
        """Numbers of fields, and the edge of a field in metres."""
        _check(columns, rows, square)
        self._inner = columns - 1, rows - 1
        grid = np.mgrid[0 : self._inner[0], 0 : self._inner[1]].T.reshape(-1, 2)
        self._board = np.hstack((grid * square, np.zeros((len(grid), 1)))).astype(np.float32)

    def find(self, grey: Grey) -> View | None:
        """See Board."""
        found, corners = cv2.findChessboardCornersSB(grey, self._inner, None, cv2.CALIB_CB_ACCURACY)
        return View(self._board, np.float32(corners).reshape(-1, 2)) if found else None


def _check(columns: int, rows: int, square: float) -> None:
    if not (3 <= columns <= 50 and 3 <= rows <= 50):
        raise UsageError(f"a board of {columns}×{rows} fields cannot be used; allowed is 3 to 50 each way")
    if not (math.isfinite(square) and 0.001 <= square <= 1):
        raise UsageError(f"fields of {square:g} m cannot be; allowed is 0.001 to 1")


@dataclass(frozen=True, eq=False)
class Result:
    """A calibration and how good it is."""

    calibration: Calibration
    errors: tuple[float, ...]
    "Root mean square reprojection error of each view, pixels; NaN of one that was left out."
    rms: float
    "Of all views used, pixels."
    uncertainty: tuple[float, float, float, float]
    "Standard deviations of fx, fy, cx, cy, pixels."


class Collector:
    """Gathers views of one board by one camera."""

    def __init__(self, board: Board, wanted: int = 20) -> None:
        """`wanted` is how many views are enough."""
        if not FEWEST_VIEWS <= wanted <= 200:
            raise UsageError(f"{wanted} views: allowed is {FEWEST_VIEWS} to 200")
        self.views: list[View] = []
        self.wanted = wanted
        self._board = board
        self._size: tuple[int, int] | None = None
        self._signs: list[NDArray[np.float64]] = []
        self._covered = np.zeros(GRID[::-1], bool)

    @property
    def coverage(self) -> float:
        """Part of the picture, 0 to 1, in which corners were seen."""
        return float(self._covered.mean())

    @property
    def complete(self) -> bool:
        """Whether there are enough views."""
        return len(self.views) >= self.wanted

    def missing(self) -> str:
        """Where the board should go next, for people; empty where everything is covered."""
        if self._covered.all():
            return ""
        down, across = (int(places[0]) for places in np.nonzero(~self._covered))
        rows = ("top", "middle", "bottom")[down * 3 // GRID[1]]
        columns = ("left", "centre", "right")[across * 3 // GRID[0]]
        return f"{rows} {columns}"

    def add(self, grey: Grey) -> bool:
        """Look at a picture (rows, columns) uint8; whether its view was new and is kept."""
        size = grey.shape[1], grey.shape[0]
        if self._size not in (None, size):
            raise UsageError(f"the pictures changed from {self._size} to {size} pixels; begin again")
        self._size = size
        view = self._board.find(grey)
        if view is None:
            return False
        sign = _sign(view, size)
        if any(np.abs(sign - other).max() < _DIFFERENT for other in self._signs):
            return False
        self._signs.append(sign)
        self.views.append(view)
        cells = (view.picture / size * GRID).astype(int)
        inside = ((cells >= 0) & (cells < GRID)).all(axis=1)
        self._covered[cells[inside, 1], cells[inside, 0]] = True
        return True

    def solve(self, camera_name: str = "camera") -> Result:
        """The calibration of what was gathered. Raises UsageError where that does not suffice."""
        if len(self.views) < FEWEST_VIEWS or self._size is None:
            raise UsageError(
                f"{len(self.views)} different views of the board are too few, at least {FEWEST_VIEWS} are "
                "needed; show it near and far, in every corner, and tilted"
            )
        used = list(range(len(self.views)))
        result = self._fit(used, camera_name)
        errors = np.array(result.errors)
        good = [index for index in used if errors[index] <= max(_BAD_VIEW * np.median(errors), 0.1)]
        if FEWEST_VIEWS <= len(good) < len(used):
            result = self._fit(good, camera_name)
        return result

    def _fit(self, used: list[int], camera_name: str) -> Result:
        assert self._size is not None
        try:
            rms, matrix, distortion, _, _, deviations, _, errors = cv2.calibrateCameraExtended(
                [self.views[index].board for index in used],
                [self.views[index].picture for index in used],
                self._size,
                np.eye(3),
                np.zeros(5),
            )
        except cv2.error as error:
            raise UsageError(
                "the views do not determine the camera; show the board tilted as well"
            ) from error
        each = np.full(len(self.views), np.nan)
        each[used] = np.ravel(errors)
        spread = np.ravel(deviations)[:4]
        return Result(
            Calibration(
                *self._size,
                np.array(matrix, np.float64),
                np.array(distortion, np.float64).ravel()[:5],
                camera_name,
            ),
            tuple(map(float, each)),
            float(rms),
            (float(spread[0]), float(spread[1]), float(spread[2]), float(spread[3])),
        )


def _sign(view: View, size: tuple[int, int]) -> NDArray[np.float64]:
    """What tells views apart: place, size and slant of the board, each about 0 to 1."""
    flat = cv2.findHomography(view.board[:, :2], view.picture)[0]
    low, high = view.board[:, :2].min(axis=0), view.board[:, :2].max(axis=0)
    corners = np.array([[[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]]])
    top_left, top_right, bottom_right, bottom_left = cv2.perspectiveTransform(corners.astype(float), flat)[0]
    top, bottom = np.linalg.norm(top_right - top_left), np.linalg.norm(bottom_right - bottom_left)
    left, right = np.linalg.norm(bottom_left - top_left), np.linalg.norm(bottom_right - top_right)
    middle = view.picture.mean(axis=0) / size
    outline = np.array([top_left, top_right, bottom_right, bottom_left], np.float32)
    scale = math.sqrt(abs(float(cv2.contourArea(outline))))
    slant = np.array([(top - bottom) / (top + bottom), (left - right) / (left + right)]) * 2
    return np.concatenate((middle, [scale / max(size)], slant))
