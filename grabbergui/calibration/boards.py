"""Boards of known size to calibrate by: their appearance, and finding them in an image.

Large images are searched reduced; the corners found are then refined in the full one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from grabbergui.calibration.markers import Grey, dictionary_by_name
from grabbergui.core.errors import UsageError

Points = NDArray[np.float32]

FEWEST_CORNERS = 8
SEARCH_PIXELS = 1_600_000
"An image is halved until it is no larger than this before a board is searched in it."
KINDS = ("charuco", "chessboard")


@dataclass(frozen=True, eq=False)
class View:
    """The board in one image."""

    board: Points
    "(n, 3) corners on the board, metres from its upper left corner."
    picture: Points
    "(n, 2) where they are seen, pixels."
    ids: NDArray[np.int64]
    "(n,) which corners they are."


@dataclass(frozen=True)
class Rectangle:
    """A part of a drawing of a board; metres from its upper left corner, y down."""

    x: float
    y: float
    width: float
    height: float
    dark: bool
    "Black; white otherwise, upon the black."


class Board(Protocol):
    """A pattern of known size."""

    columns: int
    rows: int
    square: float
    "Edge of a field, metres."

    @property
    def title(self) -> str:
        """The description that is printed below the board."""
        ...

    def find(self, grey: Grey) -> View | None:
        """Its corners in an image, to a fraction of a pixel; None where too few are seen."""
        ...

    def drawing(self) -> list[Rectangle]:
        """How to print it; later ones lie upon earlier ones."""
        ...


class CharucoBoard(Board):
    """A chessboard with markers in its white fields; may be partly out of the image."""

    def __init__(self, columns: int, rows: int, square: float, marker: float, dictionary: str) -> None:
        """Numbers of fields, and edges of field and marker in metres."""
        _check(columns, rows, square)
        if not 0 < marker < square:
            raise UsageError(f"a marker of {marker:g} m does not fit into a field of {square:g} m")
        self._numbers = cv2.aruco.getPredefinedDictionary(dictionary_by_name(dictionary))
        if columns * rows // 2 > len(self._numbers.bytesList):
            raise UsageError(
                f"{dictionary} has {len(self._numbers.bytesList)} markers, "
                f"the board needs {columns * rows // 2}"
            )
        self.columns, self.rows, self.square = columns, rows, square
        self._marker, self._dictionary = marker, dictionary
        self.pattern: Any = cv2.aruco.CharucoBoard((columns, rows), square, marker, self._numbers)
        "OpenCV's board."
        self._detector = cv2.aruco.CharucoDetector(self.pattern)

    @property
    @override
    def title(self) -> str:
        return (
            f"ChArUco {self.columns}×{self.rows}, {self._dictionary}: "
            f"fields {1e3 * self.square:g} mm, markers {1e3 * self._marker:g} mm"
        )

    @override
    def find(self, grey: Grey) -> View | None:
        reduced, factor = _reduced(grey)
        corners, ids, _, _ = self._detector.detectBoard(reduced)
        if ids is None or len(ids) < FEWEST_CORNERS:
            return None
        board, picture = self.pattern.matchImagePoints(corners, ids)
        board, picture = np.float32(board).reshape(-1, 3), np.float32(picture).reshape(-1, 2)
        # Corners of a single row say nothing about perspective.
        if np.ptp(board[:, 0]) == 0 or np.ptp(board[:, 1]) == 0:
            return None
        picture = _refined(grey, board, picture, factor, self.square)
        return View(board, picture, np.ravel(ids).astype(np.int64))

    @override
    def drawing(self) -> list[Rectangle]:
        parts = _dark_fields(self.columns, self.rows, self.square)
        side, number = self._numbers.markerSize, 0
        cell, margin = self._marker / (side + 2), (self.square - self._marker) / 2
        for row in range(self.rows):
            for column in range(self.columns):
                if (row + column) % 2 == 0:
                    continue
                x, y = column * self.square + margin, row * self.square + margin
                parts.append(Rectangle(x, y, self._marker, self._marker, dark=True))
                bits = self._bits(number)
                parts += [
                    Rectangle(x + (start + 1) * cell, y + (line + 1) * cell, length * cell, cell, dark=False)
                    for line in range(side)
                    for start, length in _runs(bits[line])
                ]
                number += 1
        return parts

    def _bits(self, number: int) -> NDArray[np.uint8]:
        """(side, side) of a marker, 1 where it is white."""
        codes = self._numbers.bytesList[number : number + 1]
        return np.asarray(cv2.aruco.Dictionary.getBitsFromByteList(codes, self._numbers.markerSize), np.uint8)


class Chessboard(Board):
    """A plain chessboard; all of it must be seen."""

    def __init__(self, columns: int, rows: int, square: float) -> None:
        """Numbers of fields, and the edge of a field in metres."""
        _check(columns, rows, square)
        self.columns, self.rows, self.square = columns, rows, square
        self._inner = columns - 1, rows - 1
        grid = np.mgrid[0 : self._inner[0], 0 : self._inner[1]].T.reshape(-1, 2)
        self._board = np.hstack(((grid + 1) * square, np.zeros((len(grid), 1)))).astype(np.float32)

    @property
    @override
    def title(self) -> str:
        return f"Chessboard {self.columns}×{self.rows}: fields {1e3 * self.square:g} mm"

    @override
    def find(self, grey: Grey) -> View | None:
        reduced, factor = _reduced(grey)
        found, corners = cv2.findChessboardCornersSB(reduced, self._inner, None, cv2.CALIB_CB_ACCURACY)
        if not found:
            return None
        picture = _refined(grey, self._board, np.float32(corners).reshape(-1, 2), factor, self.square)
        return View(self._board, picture, np.arange(len(self._board)))

    @override
    def drawing(self) -> list[Rectangle]:
        return _dark_fields(self.columns, self.rows, self.square)


@dataclass(frozen=True)
class BoardSettings:
    """Which board it is, as people say it."""

    kind: str = KINDS[0]
    columns: int = 8
    rows: int = 6
    square: float = 0.03
    "Edge of a field, metres."
    marker: float = 0.022
    "Edge of a marker's black square, metres; of a ChArUco board."
    dictionary: str = "5X5_100"

    def board(self) -> Board:
        """The board. Raises UsageError for one that cannot be."""
        if self.kind == "chessboard":
            return Chessboard(self.columns, self.rows, self.square)
        return CharucoBoard(self.columns, self.rows, self.square, self.marker, self.dictionary)


def _check(columns: int, rows: int, square: float) -> None:
    if not (3 <= columns <= 50 and 3 <= rows <= 50):
        raise UsageError(f"a board of {columns}×{rows} fields cannot be used; allowed is 3 to 50 each way")
    if not (math.isfinite(square) and 0.001 <= square <= 1):
        raise UsageError(f"fields of {square:g} m cannot be; allowed is 0.001 to 1")


def _dark_fields(columns: int, rows: int, square: float) -> list[Rectangle]:
    return [
        Rectangle(column * square, row * square, square, square, dark=True)
        for row in range(rows)
        for column in range(columns)
        if (row + column) % 2 == 0
    ]


def _runs(bits: NDArray[np.uint8]) -> list[tuple[int, int]]:
    """Start and length of every run of ones."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], bits, [0]))))
    return [(int(start), int(end - start)) for start, end in edges.reshape(-1, 2)]


def _reduced(grey: Grey) -> tuple[Grey, int]:
    factor = 1
    while grey.size > SEARCH_PIXELS:
        grey = cv2.resize(grey, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)  # type: ignore[assignment]
        factor *= 2
    return grey, factor


def _refined(grey: Grey, board: Points, picture: Points, factor: int, square: float) -> Points:
    """Corners found in an image reduced by `factor`, found again in the full one."""
    if factor == 1:
        return picture
    full = ((picture + 0.5) * factor - 0.5).astype(np.float32)
    # A window that holds no other corner, whatever the slant: of the hull's area, what one field takes.
    on_board = np.ascontiguousarray(board[:, :2])
    fields = max(cv2.contourArea(cv2.convexHull(on_board)) / square**2, 1.0)
    field = cv2.contourArea(cv2.convexHull(full)) / fields
    reach = max(2, min(3 * factor, int(math.sqrt(field) / 5)))
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 30, 0.005)
    found = cv2.cornerSubPix(grey, full.reshape(-1, 1, 2), (reach, reach), (-1, -1), criteria)
    return np.asarray(found, np.float32).reshape(-1, 2)
