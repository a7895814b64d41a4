"""ArUco markers and AprilTags by OpenCV's detector: corners to a fraction of a pixel, and their poses.

Large pictures are searched reduced, and the corners found are then refined in the full picture, so that a
picture of nine megapixels takes about as long as one of half a megapixel.
"""

from __future__ import annotations

import math
import re
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.calibration.marker_pose import MarkerDetection, located
from grabbergui.core.calibration import Calibration
from grabbergui.core.errors import UsageError

SEARCH_PIXELS = 700_000
"A picture is halved until it is no larger than this before markers are searched in it."
Grey = NDArray[np.uint8]
"(rows, columns), one byte a pixel."


def dictionary_by_name(name: str) -> int:
    """OpenCV's number of `4X4_50`, `tag36h11`, `DICT_ARUCO_ORIGINAL` …. UsageError lists what there is."""
    known = {entry[5:].upper(): entry for entry in dir(cv2.aruco) if entry.startswith("DICT_")}
    # AprilTag's own library writes tag36h11 for what OpenCV calls APRILTAG_36H11.
    wanted = re.sub(r"^TAG_?(?=\d)", "APRILTAG_", name.upper().removeprefix("DICT_"))
    if wanted not in known:
        raise UsageError(f"there is no marker dictionary {name}; there are {', '.join(sorted(known))}")
    return int(getattr(cv2.aruco, known[wanted]))


def check_marker(dictionary: str, marker: int) -> None:
    """Raises UsageError for an id that the dictionary does not have; it would be looked for for ever."""
    ids = len(cv2.aruco.getPredefinedDictionary(dictionary_by_name(dictionary)).bytesList)
    if not 0 <= marker < ids:
        raise UsageError(f"the dictionary {dictionary} has no marker {marker}; it has 0 to {ids - 1}")


class ArucoDetector:
    """Markers of one dictionary and size. Use from one thread."""

    def __init__(
        self,
        dictionary: str = "4X4_50",
        size: float = 0.10,
        calibration: Calibration | None = None,
        search_pixels: int = SEARCH_PIXELS,
    ) -> None:
        """`size` is the edge of the black square in metres; without a calibration there are no poses."""
        if not (math.isfinite(size) and 0.001 <= size <= 10):
            raise UsageError(f"a marker of {size:g} m cannot be; give the edge of its black square in metres")
        parameters = cv2.aruco.DetectorParameters()
        parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
        self._detector = cv2.aruco.ArucoDetector(
            cv2.aruco.getPredefinedDictionary(dictionary_by_name(dictionary)), parameters
        )
        self._calibration = calibration
        self._search_pixels = search_pixels
        half = size / 2
        self._square = np.array([[-half, half, 0], [half, half, 0], [half, -half, 0], [-half, -half, 0]])

    def detect(self, grey: Grey) -> list[MarkerDetection]:
        """All markers in a picture (rows, columns) uint8, with poses where there is a calibration."""
        reduced, factor = grey, 1
        while reduced.size > self._search_pixels:
            reduced = cv2.resize(reduced, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)  # type: ignore[assignment]
            factor *= 2
        corners, ids, _ = self._detector.detectMarkers(reduced)
        if ids is None:
            return []
        squares = [np.asarray(square, np.float64).reshape(4, 2) for square in corners]
        if factor > 1:
            squares = [_refined(grey, square, factor) for square in squares]
        return [
            self._with_pose(MarkerDetection(int(marker_id), square), grey.shape[1], grey.shape[0])
            for marker_id, square in zip(np.ravel(ids), squares, strict=True)
        ]

    def _with_pose(self, marker: MarkerDetection, width: int, height: int) -> MarkerDetection:
        if self._calibration is None:
            return replace(marker, problem="the camera is not calibrated")
        calibration = self._calibration.scaled_to(width, height)
        return located(marker, self._square, marker.corners, calibration)


def _refined(grey: Grey, square: NDArray[np.float64], factor: int) -> NDArray[np.float64]:
    """Corners of a picture reduced by `factor`, found again in the full one."""
    corners = (square + 0.5) * factor - 0.5
    # No wider than a third of a marker's cell, or the window would hold other edges than the corner's.
    edge = float(np.linalg.norm(corners[0] - corners[1]))
    reach = max(2, min(2 * factor, int(edge / 20)))
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 30, 0.01)
    found = cv2.cornerSubPix(
        grey, corners.astype(np.float32).reshape(-1, 1, 2), (reach, reach), (-1, -1), criteria
    )
    return np.asarray(found, np.float64).reshape(4, 2)
