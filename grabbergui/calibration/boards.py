"""Calibration boards of known size, and finding them in an image.

Large images are reduced for the search, and the corners are then refined in the full image.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from grabbergui.calibration.markers import Grey, dictionary_named, halved, subpixel, unreduced
from grabbergui.core.errors import UsageError

Points = NDArray[np.float32]

_FEWEST_CORNERS = 8
"Fewest visible corners of a ChArUco board, which may be partly outside the image."
_SINGULAR = 1e-6
"Below this ratio of singular values, equations count as dependent; 32-bit coordinates are exact to 1e-7."
SEARCH_PIXELS = 1_600_000
"Largest image in which a board is searched. Larger ones are halved until they fit."
KINDS = ("charuco", "chessboard")


@dataclass(frozen=True, eq=False)
class View:
    """The board in one image."""

    board: Points
    "(n, 3) corners on the board, metres from its upper left corner."
    image: Points
    "(n, 2) the same corners in the image, pixels."
    ids: NDArray[np.int64]
    "(n,) ids of the corners."


@dataclass(frozen=True)
class Rectangle:
    """A part of a drawing of a board; metres from its upper left corner, y down."""

    x: float
    y: float
    width: float
    height: float
    dark: bool
    "Whether it is black, or else white on black."


class Board(Protocol):
    """A pattern of known size."""

    columns: int
    rows: int
    square: float
    "Edge of a square, metres."

    @property
    def title(self) -> str:
        """The description that is printed below the board."""
        ...

    def find(self, grey: Grey) -> View | None:
        """Return its corners in an image, with subpixel accuracy; None if too few are visible."""
        ...

    def drawing(self) -> list[Rectangle]:
        """Return the rectangles to print; later ones cover earlier ones."""
        ...


class CharucoBoard(Board):
    """A chessboard with markers in its white squares; may be partly outside the image."""

    def __init__(self, columns: int, rows: int, square: float, marker: float, dictionary: str) -> None:
        """Numbers of squares, and edges of square and marker in metres."""
        _check(columns, rows, square)
        if not 0 < marker < square:
            raise UsageError(f"a marker of {marker:g} m does not fit into a square of {square:g} m")
        self._numbers = dictionary_named(dictionary)
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
            f"squares {1e3 * self.square:g} mm, markers {1e3 * self._marker:g} mm"
        )

    @override
    def find(self, grey: Grey) -> View | None:
        reduced, factor = halved(grey, SEARCH_PIXELS)
        corners, ids, _, _ = self._detector.detectBoard(reduced)
        if ids is None or len(ids) < _FEWEST_CORNERS:
            return None
        board, image = self.pattern.matchImagePoints(corners, ids)
        board, image = np.float32(board).reshape(-1, 3), np.float32(image).reshape(-1, 2)
        if not _determine_perspective(board):
            return None
        image = _refined(grey, board, image, factor, self.square)
        return View(board, image, np.ravel(ids).astype(np.int64))

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
        """Return the bits of a marker, (side, side), 1 where it is white."""
        codes = self._numbers.bytesList[number : number + 1]
        return np.asarray(cv2.aruco.Dictionary.getBitsFromByteList(codes, self._numbers.markerSize), np.uint8)


class Chessboard(Board):
    """A plain chessboard, which must be entirely visible."""

    def __init__(self, columns: int, rows: int, square: float) -> None:
        """Numbers of squares, and the edge of a square in metres."""
        _check(columns, rows, square)
        self.columns, self.rows, self.square = columns, rows, square
        self._inner = columns - 1, rows - 1
        grid = np.mgrid[0 : self._inner[0], 0 : self._inner[1]].T.reshape(-1, 2)
        self._board = np.hstack(((grid + 1) * square, np.zeros((len(grid), 1)))).astype(np.float32)

    @property
    @override
    def title(self) -> str:
        return f"Chessboard {self.columns}×{self.rows}: squares {1e3 * self.square:g} mm"

    @override
    def find(self, grey: Grey) -> View | None:
        reduced, factor = halved(grey, SEARCH_PIXELS)
        found, corners = cv2.findChessboardCornersSB(reduced, self._inner, None, cv2.CALIB_CB_ACCURACY)
        if not found:
            return None
        image = _refined(grey, self._board, np.float32(corners).reshape(-1, 2), factor, self.square)
        return View(self._board, image, np.arange(len(self._board)))

    @override
    def drawing(self) -> list[Rectangle]:
        return _dark_fields(self.columns, self.rows, self.square)


@dataclass(frozen=True)
class BoardSettings:
    """The description of a board by its user."""

    kind: str = KINDS[0]
    columns: int = 8
    rows: int = 6
    square: float = 0.03
    "Edge of a square, metres."
    marker: float = 0.022
    "Edge of the black square of a ChArUco board's markers, metres."
    dictionary: str = "5X5_100"

    def board(self) -> Board:
        """Return the board. Raises UsageError for an impossible one."""
        if self.kind == "chessboard":
            return Chessboard(self.columns, self.rows, self.square)
        return CharucoBoard(self.columns, self.rows, self.square, self.marker, self.dictionary)


def _determine_perspective(board: Points) -> bool:
    """Return whether corners determine a homography; not if all, or all but one, are on one line.

    Each corner gives two linear equations for the nine elements, which are determined up to a factor.
    """
    flat = board[:, :2].astype(np.float64)
    flat -= flat.mean(axis=0)
    x, y = flat.T / np.abs(flat).max()
    one, zero = np.ones_like(x), np.zeros_like(x)
    across = np.stack((x, y, one, zero, zero, zero, -x * x, -x * y, -x), axis=1)
    down = np.stack((zero, zero, zero, x, y, one, -y * x, -y * y, -y), axis=1)
    strengths = np.linalg.svd(np.concatenate((across, down)), compute_uv=False)
    return bool(strengths[7] > _SINGULAR * strengths[0])


def _check(columns: int, rows: int, square: float) -> None:
    if not (3 <= columns <= 50 and 3 <= rows <= 50):
        raise UsageError(f"a board of {columns}×{rows} squares cannot be used; allowed: 3 to 50 each way")
    if not (math.isfinite(square) and 0.001 <= square <= 1):
        raise UsageError(f"squares of {square:g} m are impossible; allowed: 0.001 to 1")


def _dark_fields(columns: int, rows: int, square: float) -> list[Rectangle]:
    return [
        Rectangle(column * square, row * square, square, square, dark=True)
        for row in range(rows)
        for column in range(columns)
        if (row + column) % 2 == 0
    ]


def _runs(bits: NDArray[np.uint8]) -> list[tuple[int, int]]:
    """Return start and length of every run of ones."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], bits, [0]))))
    return [(int(start), int(end - start)) for start, end in edges.reshape(-1, 2)]


def _refined(grey: Grey, board: Points, image: Points, factor: int, square: float) -> Points:
    """Refine corners that were found in an image reduced by `factor`, in the full image."""
    if factor == 1:
        return image
    full = unreduced(image, factor).astype(np.float32)
    # The window must contain no other corner, so it depends on the average area of a square in the image.
    on_board = np.ascontiguousarray(board[:, :2])
    fields = max(cv2.contourArea(cv2.convexHull(on_board)) / square**2, 1.0)
    field = cv2.contourArea(cv2.convexHull(full)) / fields
    return subpixel(grey, full, max(2, min(3 * factor, int(math.sqrt(field) / 5))), 0.005)
