"""Calibrates a camera from views of a printed board.

A `Collector` examines image after image and keeps the views that differ from those before. `Coverage` counts
the parts of the image, tilts and distances that were seen. Once there are enough views, `solve` returns the
calibration with the error of every view; it leaves out views that fit badly.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass, field
from enum import Enum

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.calibration.boards import Board, View
from grabbergui.calibration.markers import Grey
from grabbergui.core.calibration import Calibration
from grabbergui.core.errors import CalibrationError, UsageError
from grabbergui.core.image_geometry import ImageGeometry

FEWEST_VIEWS = 5
MOST_VIEWS = 200
_DIFFERENT = 0.06
"Least distance of a view's `ViewPlacement` from all others."
_STILL = 0.003
"Most movement of corners from image to image, relative to the image's longer side."
_BAD_VIEW = 2.5
"Error of a view that is left out, relative to the median."


GRID = (8, 6)
"Columns and rows of cells of the image, in which corners are counted."
TILTED = 0.08
"Least slant of a tilted board: about 15° if it fills half of the image."
NEAR, FAR = 0.40, 0.22
"Sizes, relative to the image's longer side, above which a board is near and below which it is far."

Counts = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class ViewPlacement:
    """Position, size and slant of the board in a view, each about 0 to 1, to compare views."""

    x: float
    y: float
    size: float
    slant_x: float
    "Positive if the board's right edge is nearer."
    slant_y: float
    "Positive if its lower edge is nearer."

    def apart(self, other: ViewPlacement) -> float:
        """Return the largest difference to another placement."""
        return float(np.abs(self._vector - other._vector).max())

    @property
    def _vector(self) -> NDArray[np.float64]:
        return np.array([self.x, self.y, self.size, self.slant_x, self.slant_y])


def _zeros(*shape: int) -> Counts:
    return np.zeros(shape, np.int64)


@dataclass(eq=False)
class Coverage:
    """Counts of the corners, tilts and sizes seen so far."""

    cells: Counts = field(default_factory=lambda: _zeros(GRID[1], GRID[0]))
    "Corners in each cell of the image, (rows, columns)."
    tilts: Counts = field(default_factory=lambda: _zeros(3, 3))
    "Views by nearer edge, (3, 3): upper, none, lower; left, none, right."
    sizes: Counts = field(default_factory=lambda: _zeros(3))
    "Views by distance: far, medium, near."

    def add(self, view: View, placement: ViewPlacement, size: tuple[int, int]) -> None:
        """Count a view in an image of `size`."""
        places = (view.image / size * GRID).astype(int)
        inside = ((places >= 0) & (places < GRID)).all(axis=1)
        np.add.at(self.cells, (places[inside, 1], places[inside, 0]), 1)
        self.tilts[_third(placement.slant_y), _third(placement.slant_x)] += 1
        self.sizes[0 if placement.size < FAR else 2 if placement.size > NEAR else 1] += 1

    def copy(self) -> Coverage:
        """Return a copy."""
        return Coverage(self.cells.copy(), self.tilts.copy(), self.sizes.copy())

    @property
    def part(self) -> float:
        """The fraction of the image, 0 to 1, in which corners were seen."""
        return float((self.cells > 0).mean())

    def missing(self) -> str:
        """Return how to hold the board next, as display text; empty if everything is covered.

        Views without tilt cannot distinguish focal length and distance, so tilts come first after some views.
        """
        views = int(self.sizes.sum())
        for name, seen in (
            ("with its left edge nearer", self.tilts[:, 0]),
            ("with its right edge nearer", self.tilts[:, 2]),
            ("with its upper edge nearer", self.tilts[0]),
            ("with its lower edge nearer", self.tilts[2]),
        ):
            if views >= 4 and not seen.any():
                return name
        empty = np.argwhere(self.cells == 0)
        if len(empty):
            down, across = (int(place) for place in empty[0])
            rows = ("top", "middle", "bottom")[down * 3 // GRID[1]]
            columns = ("left", "centre", "right")[across * 3 // GRID[0]]
            return f"at the {rows} {columns}"
        if not self.sizes[2]:
            return "nearer"
        return "" if self.sizes[0] or self.sizes[1] else "farther away"


def _third(slant: float) -> int:
    return 0 if slant < -TILTED else 2 if slant > TILTED else 1


class ViewVerdict(Enum):
    """The result of examining an image; the values are display text."""

    NOT_SEEN = "no board is seen"
    MOVING = "hold it still"
    KNOWN = "this view is there already"
    KEPT = "kept"


@dataclass(frozen=True, eq=False)
class Result:
    """A calibration and its accuracy."""

    calibration: Calibration
    errors: tuple[float, ...]
    "Root mean square reprojection error of each view, pixels; NaN for one that was left out."
    rms: float
    "Root mean square reprojection error of all used views, pixels."
    uncertainty: tuple[float, float, float, float]
    "Standard deviations of fx, fy, cx, cy, pixels."
    residuals: tuple[NDArray[np.float64], ...]
    "(n, 2) pixels from the detected to the expected corners of every view, including those left out."

    def error_of(self, number: int) -> float:
        """Return the root mean square error of a view, which may have been left out."""
        return math.sqrt(float((self.residuals[number] ** 2).sum(axis=1).mean()))


class Collector:
    """Collects views of a board by a camera. Use from one thread."""

    def __init__(self, board: Board, wanted: int = 20, still: bool = False) -> None:
        """`wanted` is the number of views to collect; with `still`, the board must be at rest."""
        if not FEWEST_VIEWS <= wanted <= MOST_VIEWS:
            raise UsageError(f"{wanted} views: out of range; allowed: {FEWEST_VIEWS} to {MOST_VIEWS}")
        self.views: list[View] = []
        self.wanted = wanted
        self.coverage = Coverage()
        self.last: View | None = None
        "The board in the newest image."
        self._board = board
        self._still = still
        self._size: tuple[int, int] | None = None
        self.geometry: ImageGeometry | None = None
        "Where the images of the kept views lie on the sensor; None if the camera does not report it."
        self._placements: list[ViewPlacement] = []

    @property
    def complete(self) -> bool:
        """Whether there are enough views."""
        return len(self.views) >= self.wanted

    def look(self, grey: Grey, keep: bool = True, geometry: ImageGeometry | None = None) -> ViewVerdict:
        """Examine an image (rows, columns) uint8, and keep its view if it differs from those before.

        With `keep` false, only return the result. Raises CalibrationError for an image of another size, or of
        other pixels of the sensor than the kept views.
        """
        size = grey.shape[1], grey.shape[0]
        if self._size is not None and self._size != size:
            before_text, now_text = (f"{width}×{height}" for width, height in (self._size, size))
            raise CalibrationError(f"the images changed from {before_text} to {now_text} pixels; begin again")
        if self.views and geometry != self.geometry:
            raise CalibrationError("the region, binning or mirroring of the images changed; begin again")
        self._size, self.geometry = size, geometry
        before, self.last = self.last, self._board.find(grey)
        view = self.last
        if view is None:
            return ViewVerdict.NOT_SEEN
        if self._still and (before is None or _moved(before, view) > _STILL * max(size)):
            return ViewVerdict.MOVING
        placement = placed(view, size)
        if any(placement.apart(other) < _DIFFERENT for other in self._placements):
            return ViewVerdict.KNOWN
        if keep:
            self._placements.append(placement)
            self.views.append(view)
            self.coverage.add(view, placement, size)
        return ViewVerdict.KEPT

    def solve(
        self,
        camera_name: str = "camera",
        used: Collection[int] | None = None,
        left_out: Collection[int] = (),
    ) -> Result:
        """Calibrate from the collected views. Raises CalibrationError if they are not sufficient.

        `used` are the numbers of the views to use; by default all but those in `left_out` and those that fit
        badly.
        """
        chosen = sorted(set(range(len(self.views))) - set(left_out) if used is None else set(used))
        if len(chosen) < FEWEST_VIEWS or self._size is None:
            raise CalibrationError(
                f"calibration needs at least {FEWEST_VIEWS} different views of the board, not {len(chosen)}; "
                "show it near and far, in every corner, and tilted"
            )
        result = self._fit(chosen, self._size, camera_name)
        if used is None:
            errors = np.array(result.errors)
            limit = max(_BAD_VIEW * float(np.median(errors)), 0.1)
            good = [number for number in chosen if errors[number] <= limit]
            if FEWEST_VIEWS <= len(good) < len(chosen):
                result = self._fit(good, self._size, camera_name)
        return result

    def _fit(self, used: list[int], size: tuple[int, int], camera_name: str) -> Result:
        try:
            rms, matrix, distortion, _, _, deviations, _, errors = cv2.calibrateCameraExtended(
                [self.views[number].board for number in used],
                [self.views[number].image for number in used],
                size,
                np.eye(3),
                np.zeros(5),
            )
        except cv2.error as error:
            raise CalibrationError(
                "the views do not determine the camera; show the board tilted as well"
            ) from error
        each = np.full(len(self.views), np.nan)
        each[used] = np.ravel(errors)
        spread = np.ravel(deviations)[:4]
        calibration = Calibration(
            *size,
            np.array(matrix, np.float64),
            np.array(distortion, np.float64).ravel()[:5],
            camera_name,
            geometry=self.geometry,
        )
        return Result(
            calibration,
            tuple(map(float, each)),
            float(rms),
            (float(spread[0]), float(spread[1]), float(spread[2]), float(spread[3])),
            tuple(_residuals(view, calibration) for view in self.views),
        )


def placed(view: View, size: tuple[int, int]) -> ViewPlacement:
    """Return the placement of a board in an image of `size`."""
    flat = cv2.findHomography(view.board[:, :2], view.image)[0]
    low, high = view.board[:, :2].min(axis=0), view.board[:, :2].max(axis=0)
    corners = np.array([[[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]]])
    outline = cv2.perspectiveTransform(corners.astype(float), flat)[0]
    # The board may be rotated, so its upper left corner is the one nearest to that of the image.
    outline = np.roll(outline, -int(np.argmin(outline.sum(axis=1))), axis=0)
    if cv2.contourArea(outline.astype(np.float32), oriented=True) < 0:
        outline = outline[[0, 3, 2, 1]]
    top, right, bottom, left = (
        float(np.linalg.norm(outline[(side + 1) % 4] - outline[side])) for side in range(4)
    )
    middle = view.image.mean(axis=0) / size
    scale = math.sqrt(abs(float(cv2.contourArea(outline.astype(np.float32)))))
    return ViewPlacement(
        float(middle[0]),
        float(middle[1]),
        scale / max(size),
        2 * (right - left) / (right + left),
        2 * (bottom - top) / (bottom + top),
    )


def _moved(before: View, after: View) -> float:
    """Return the mean movement of the corners in both views, pixels; infinite if there are none."""
    _, first, second = np.intersect1d(before.ids, after.ids, return_indices=True)
    if not len(first):
        return math.inf
    return float(np.linalg.norm(before.image[first] - after.image[second], axis=1).mean())


def _residuals(view: View, calibration: Calibration) -> NDArray[np.float64]:
    _, rotation, translation = cv2.solvePnP(
        view.board, view.image, calibration.matrix, calibration.pinhole_distortion
    )
    seen, _ = cv2.projectPoints(
        view.board, rotation, translation, calibration.matrix, calibration.pinhole_distortion
    )
    residuals: NDArray[np.float64] = seen.reshape(-1, 2).astype(np.float64) - view.image
    return residuals
