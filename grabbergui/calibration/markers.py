"""Detects ArUco markers, AprilTags and boards of them, with subpixel corners and the target's pose.

A target is a marker or a board of markers: a grid, or a ChArUco board. A board may be partly hidden or
outside the image. The pose of a target is that of its centre: x right, y up, z out of its face.

Large images are reduced for the search, and the corners are then refined in the full image, so that an image
of nine megapixels takes about as long as one of half a megapixel.

Poses are computed by IPPE, with a covariance. If a plane is small or far away, two poses explain its corners
about equally well. If one is clearly better, it is the result, and the other is kept so that a filter can
recognise a flip; else the view is ambiguous and has no pose.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.calibration import geometry
from grabbergui.core.calibration import Calibration
from grabbergui.core.errors import UsageError

Grey = NDArray[np.uint8]
"(rows, columns), a byte per pixel."

# -- single markers ------------------------------------------------------------------------------
SEARCH_PIXELS = 700_000
"Largest image in which markers are searched. Larger ones are halved until they fit."


@dataclass(frozen=True, eq=False)
class MarkerDetection:
    """A detected marker, or a board of markers that is one target."""

    marker_id: int
    "Id of the marker, or of a board's first marker."
    corners: NDArray[np.float64]
    "(4, 2) pixels of the full image, clockwise from the printed marker's upper left corner."
    pose: geometry.Pose | None = None
    "Marker (x right, y up, z out of its face) to camera; None if there is no reliable one."
    problem: str = ""
    "Why there is no pose, as display text: ambiguous, behind the camera, no calibration."
    reprojection_error: float = 0.0
    "Root mean square over the corners' coordinates, pixels."
    covariance: NDArray[np.float64] | None = None
    "(6, 6) of the pose: metres along, then radians about the camera's axes, in ROS's order."
    other_pose: geometry.Pose | None = None
    "The second solution; None if there is only one."
    points: NDArray[np.float64] | None = None
    "(n, 3) metres on the target, from which the `pose` was computed."
    pixels: NDArray[np.float64] | None = None
    "(n, 2) the same points in the image, pixels."


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


# -- boards of markers ---------------------------------------------------------------------------
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


# -- poses ---------------------------------------------------------------------------------------
STEEPEST_VIEW = math.radians(72)
"Largest angle between a marker's normal and the line of sight; beyond it the marker is seen edge-on."
AMBIGUITY_RATIO = 1.5
"Ratio of the second pose's reprojection error to the first's, below which the view is ambiguous."
AMBIGUITY_ANGLE = math.radians(12)
"Angle between two poses below which they count as one."
LARGEST_ERROR = 0.03
"Largest reprojection error of a square, relative to the marker's edge."
CORNER_NOISE = 0.2
"Expected standard deviation of each coordinate of a corner, pixels."
CORNER_TRUST = 20
"Weight of this expectation in residuals; four corners leave only two measured ones."


def located(
    marker: MarkerDetection, points: NDArray[np.float64], pixels: NDArray[np.float64], of: Calibration
) -> MarkerDetection:
    """Return the marker with its pose, or with the reason why there is none.

    `points` are (n, 3) metres on the target with z = 0, at least four and not on a line; `pixels` are the
    same (n, 2) points in the image. `of` is the calibration of images of exactly this size.
    """
    square = len(points) == 4
    method = cv2.SOLVEPNP_IPPE_SQUARE if square else cv2.SOLVEPNP_IPPE
    try:
        _, rotations, translations, errors = cv2.solvePnPGeneric(
            points, pixels, of.matrix, of.pinhole_distortion, flags=method
        )
    except cv2.error:
        return replace(marker, problem="its corners are no square's")
    poses = [
        geometry.pose(geometry.rotation_from_vector(rotation.ravel()), translation.ravel())
        for rotation, translation in zip(rotations, translations, strict=True)
    ]
    found = judged(marker, poses, [float(error) for error in np.ravel(errors)])
    if found.pose is None:
        return found
    pose = _refined_pose(found.pose, points, pixels, of)
    covariance = pose_covariance(pose, points, of, found.reprojection_error)
    if covariance is None:
        return replace(found, pose=None, problem="its corners do not fix its pose")
    return replace(found, pose=pose, covariance=covariance, points=points, pixels=pixels)


def judged(marker: MarkerDetection, poses: list[geometry.Pose], errors: list[float]) -> MarkerDetection:
    """Return the marker with the first of a solver's poses, or with the reason why it is not reliable.

    `errors` are the reprojection errors of the poses in pixels, the smallest first.
    """
    if not poses or not geometry.is_pose(poses[0]) or not math.isfinite(errors[0]):
        return replace(marker, problem="no pose fits its corners")
    edge = float(np.linalg.norm(marker.corners - np.roll(marker.corners, 1, axis=0), axis=1).mean())
    best = poses[0]
    position, normal = best[:3, 3], best[:3, 2]
    if position[2] <= 0:
        return replace(marker, problem="it would be behind the camera")
    if errors[0] > LARGEST_ERROR * edge:
        return replace(marker, problem="its corners are no square's", reprojection_error=errors[0])
    view = math.acos(float(np.clip(-normal @ position / np.linalg.norm(position), -1, 1)))
    if view > STEEPEST_VIEW:
        return replace(marker, problem="it is seen edge-on", reprojection_error=errors[0])
    other = poses[1] if len(poses) > 1 and geometry.is_pose(poses[1]) else None
    if other is not None:
        apart = geometry.angle_between(best, other)
        if apart > AMBIGUITY_ANGLE and errors[1] < AMBIGUITY_RATIO * max(errors[0], 1e-3 * edge):
            return replace(marker, problem="two poses explain it", reprojection_error=errors[0])
    return replace(marker, pose=best, reprojection_error=errors[0], other_pose=other)


def pose_covariance(
    pose: geometry.Pose, points: NDArray[np.float64], of: Calibration, error: float
) -> NDArray[np.float64] | None:
    """Return the (6, 6) covariance of a pose from the derivatives of its reprojection; None if singular.

    `error` is the reprojection error, the root mean square over the corners' coordinates in pixels. The noise
    of corners is estimated from it and from `CORNER_NOISE`.
    """
    placed = points @ pose[:3, :3].T
    turn = geometry.vector_from_rotation(pose[:3, :3])
    _, derivatives = cv2.projectPoints(points, turn, pose[:3, 3], of.matrix, of.pinhole_distortion)
    by_place = np.asarray(derivatives, np.float64)[:, 3:6].reshape(-1, 2, 3)
    # A rotation ω about the camera's axes moves a corner r by ω × r, and row · (ω × r) = (r × row) · ω.
    by_turn = np.cross(placed[:, None, :], by_place)
    jacobian = np.concatenate((by_place, by_turn), axis=2).reshape(-1, 6)
    freedom = max(2 * len(points) - 6, 0)
    squares = 2 * len(points) * error**2
    noise = (CORNER_TRUST * CORNER_NOISE**2 + squares) / (CORNER_TRUST + freedom)
    try:
        covariance = noise * np.linalg.inv(jacobian.T @ jacobian)
    except np.linalg.LinAlgError:
        return None
    sound = np.isfinite(covariance).all() and (np.diag(covariance) > 0).all()
    return np.asarray((covariance + covariance.T) / 2, np.float64) if sound else None


def _refined_pose(
    pose: geometry.Pose, points: NDArray[np.float64], pixels: NDArray[np.float64], of: Calibration
) -> geometry.Pose:
    """Return the pose with the least reprojection error near one of IPPE's."""
    turn, place = cv2.solvePnPRefineLM(
        points,
        pixels,
        of.matrix,
        of.pinhole_distortion,
        geometry.vector_from_rotation(pose[:3, :3]).reshape(3, 1),
        pose[:3, 3].reshape(3, 1).copy(),
    )
    refined = geometry.pose(geometry.rotation_from_vector(turn.ravel()), place.ravel())
    near = geometry.is_pose(refined) and geometry.angle_between(pose, refined) < AMBIGUITY_ANGLE / 2
    return refined if near and refined[2, 3] > 0 else pose
