"""Detects ArUco markers and AprilTags, with subpixel corners and the marker's pose.

Large images are reduced for the search, and the corners are then refined in the full image, so that an image
of nine megapixels takes about as long as one of half a megapixel.
"""

from __future__ import annotations

import math
import re
from dataclasses import replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.calibration.marker_pose import MarkerDetection, located
from grabbergui.calibration.square_edges import intersected
from grabbergui.core.calibration import Calibration
from grabbergui.core.errors import UsageError

Grey = NDArray[np.uint8]
"(rows, columns), a byte per pixel."

SEARCH_PIXELS = 700_000
"Largest image in which markers are searched. Larger ones are halved until they fit."


def dictionary_number(name: str) -> int:
    """Return OpenCV's number of `4X4_50`, `tag36h11` or `DICT_ARUCO_ORIGINAL`. Raises UsageError."""
    known = {entry[5:].upper(): entry for entry in dir(cv2.aruco) if entry.startswith("DICT_")}
    # OpenCV's APRILTAG_36H11 is tag36h11 in AprilTag's own library.
    wanted = re.sub(r"^TAG_?(?=\d)", "APRILTAG_", name.upper().removeprefix("DICT_"))
    if wanted not in known:
        raise UsageError(f"there is no marker dictionary {name}; there are {', '.join(sorted(known))}")
    return int(getattr(cv2.aruco, known[wanted]))


def dictionary_named(name: str) -> cv2.aruco.Dictionary:
    """Return OpenCV's dictionary of a name. Raises UsageError."""
    return cv2.aruco.getPredefinedDictionary(dictionary_number(name))


def check_marker(dictionary: str, marker: int) -> None:
    """Raise UsageError for an id that the dictionary does not have, which would never be found."""
    ids = len(dictionary_named(dictionary).bytesList)
    if not 0 <= marker < ids:
        raise UsageError(f"the dictionary {dictionary} has no marker {marker}; it has 0 to {ids - 1}")


class ArucoDetector:
    """Detects markers of one dictionary and size. Use from one thread."""

    def __init__(
        self,
        dictionary: str = "4X4_50",
        size: float = 0.10,
        calibration: Calibration | None = None,
        search_pixels: int = SEARCH_PIXELS,
    ) -> None:
        """`size` is the edge of the black square in metres; without a calibration there are no poses."""
        if not (math.isfinite(size) and 0.001 <= size <= 10):
            raise UsageError(
                f"a marker of {size:g} m is impossible; give the edge of its black square in metres"
            )
        parameters = cv2.aruco.DetectorParameters()
        parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
        self._detector = cv2.aruco.ArucoDetector(dictionary_named(dictionary), parameters)
        self._calibration = calibration
        self._search_pixels = search_pixels
        half = size / 2
        self._square = np.array([[-half, half, 0], [half, half, 0], [half, -half, 0], [-half, -half, 0]])

    def detect(self, grey: Grey) -> list[MarkerDetection]:
        """Return all markers in an image (rows, columns) uint8, with poses if there is a calibration."""
        searched, factor = halved(grey, self._search_pixels)
        corners, ids, _ = self._detector.detectMarkers(searched)
        if ids is None:
            return []
        squares = [np.asarray(square, np.float64).reshape(4, 2) for square in corners]
        if factor > 1:
            squares = [_refined(grey, square, factor) for square in squares]
        squares = [intersected(grey, square) for square in squares]
        return [
            self._with_pose(MarkerDetection(int(marker_id), square), grey.shape[1], grey.shape[0])
            for marker_id, square in zip(np.ravel(ids), squares, strict=True)
        ]

    def _with_pose(self, marker: MarkerDetection, width: int, height: int) -> MarkerDetection:
        if self._calibration is None:
            return replace(marker, problem="the camera is not calibrated")
        calibration = self._calibration.scaled_to(width, height)
        return located(marker, self._square, marker.corners, calibration)


def halved(grey: Grey, pixels: int) -> tuple[Grey, int]:
    """Return an image halved until it has at most so many pixels, and the factor."""
    factor = 1
    while grey.size > pixels:
        grey = cv2.resize(grey, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)  # type: ignore[assignment]
        factor *= 2
    return grey, factor


def unreduced(points: NDArray[Any], factor: int) -> NDArray[Any]:
    """Return points of an image reduced by `factor` in the full image; pixel centres are whole numbers."""
    return (points + 0.5) * factor - 0.5


def subpixel(grey: Grey, corners: NDArray[Any], reach: int, accuracy: float) -> NDArray[Any]:
    """Refine (n, 2) corners in windows of `reach` pixels each way, until they move less than `accuracy`."""
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 30, accuracy)
    starts = corners.astype(np.float32).reshape(-1, 1, 2)
    return cv2.cornerSubPix(grey, starts, (reach, reach), (-1, -1), criteria).reshape(-1, 2)


def _refined(grey: Grey, square: NDArray[np.float64], factor: int) -> NDArray[np.float64]:
    """Refine corners that were found in an image reduced by `factor`, in the full image."""
    corners = unreduced(square, factor)
    # Not wider than a third of a marker's cell, or the window would contain edges of other corners.
    edge = float(np.linalg.norm(corners[0] - corners[1]))
    return subpixel(grey, corners, max(2, min(2 * factor, int(edge / 20))), 0.01).astype(np.float64)
