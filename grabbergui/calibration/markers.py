"""ArUco markers and AprilTags, and boards of them: corners to a fraction of a pixel, and the target's pose.

A target is one marker, or a board of them: a grid, or a ChArUco board. A board may be partly hidden or out of
the image. The pose of a target is that of its middle: x right, y up, z out of its face.

Large images are searched reduced, and the corners found are then refined in the full image, so that an image
of nine megapixels takes about as long as one of half a megapixel.

Poses are by IPPE, with a covariance. In perspective a plane has two poses that explain its corners about
equally well when it is small or far. The better one is given where it is clearly better; else the view is
ambiguous and there is none. The other solution is kept, so that a filter can recognise a flip.
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
"(rows, columns), one byte a pixel."

# -- single markers ------------------------------------------------------------------------------
SEARCH_PIXELS = 700_000
"An image is halved until it is no larger than this before markers are searched in it."


@dataclass(frozen=True, eq=False)
class MarkerDetection:
    """One marker, or a board of markers that is one target."""

    marker_id: int
    "Of a board its first marker's."
    corners: NDArray[np.float64]
    "(4, 2) pixels of the full image, from the printed upper left on, clockwise as printed."
    pose: geometry.Pose | None = None
    "Marker (x right, y up, z out of its face) to camera; None where none may be trusted."
    problem: str = ""
    "Why there is no pose, as display text: ambiguous, behind the camera, no calibration."
    reprojection_error: float = 0.0
    "Root mean square over the corners' coordinates, pixels."
    covariance: NDArray[np.float64] | None = None
    "(6, 6) of the pose: metres along, then radians about the camera's axes, as ROS orders it."
    other_pose: geometry.Pose | None = None
    "The second solution, beside a `pose`; None where there is one solution only."
    points: NDArray[np.float64] | None = None
    "(n, 3) metres on the target whose places gave the `pose`."
    pixels: NDArray[np.float64] | None = None
    "(n, 2) where they are seen."


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
            raise UsageError(
                f"a marker of {size:g} m is impossible; give the edge of its black square in metres"
            )
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
        """All markers in an image (rows, columns) uint8, with poses where there is a calibration."""
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
    """Corners of an image reduced by `factor`, found again in the full one."""
    corners = (square + 0.5) * factor - 0.5
    # No wider than a third of a marker's cell, or the window would hold other edges than the corner's.
    edge = float(np.linalg.norm(corners[0] - corners[1]))
    reach = max(2, min(2 * factor, int(edge / 20)))
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 30, 0.01)
    found = cv2.cornerSubPix(
        grey, corners.astype(np.float32).reshape(-1, 1, 2), (reach, reach), (-1, -1), criteria
    )
    return np.asarray(found, np.float64).reshape(4, 2)


# -- boards of markers ---------------------------------------------------------------------------
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
                f"allowed: {fewest} to 50 each way, and more than one"
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


# -- poses ---------------------------------------------------------------------------------------
STEEPEST_VIEW = math.radians(72)
"Beyond this angle between the marker's face and the line of sight it is seen edge-on."
AMBIGUITY_RATIO = 1.5
"The second pose's reprojection error over the first's, below which they cannot be distinguished."
AMBIGUITY_ANGLE = math.radians(12)
"Two poses nearer to each other than this are as good as one."
LARGEST_ERROR = 0.03
"Reprojection error over the marker's edge beyond which its corners are no square's."
CORNER_NOISE = 0.2
"Pixels by which a corner is expected to be off, standard deviation of each coordinate."
CORNER_TRUST = 20
"As many residuals as that expectation is worth beside the measured ones: four corners leave only two."


def located(
    marker: MarkerDetection, points: NDArray[np.float64], pixels: NDArray[np.float64], of: Calibration
) -> MarkerDetection:
    """Return the marker with its pose, or with the reason why there is none.

    `points` are (n, 3) metres on the target, z = 0, at least four and not on a line; `pixels` (n, 2) is where
    they are seen. `of` is the calibration of images of this very size.
    """
    square = len(points) == 4
    method = cv2.SOLVEPNP_IPPE_SQUARE if square else cv2.SOLVEPNP_IPPE
    try:
        _, rotations, translations, errors = cv2.solvePnPGeneric(
            points, pixels, of.matrix, of.distortion, flags=method
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
    """The marker with the first of a solver's poses, or with the reason why it cannot be trusted.

    `errors` are the poses' reprojection errors in pixels, the smallest first.
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

    `error` is the reprojection error, root mean square over the corners' coordinates in pixels. The noise of
    corners is estimated from it and from `CORNER_NOISE`.
    """
    placed = points @ pose[:3, :3].T
    turn = geometry.vector_from_rotation(pose[:3, :3])
    _, derivatives = cv2.projectPoints(points, turn, pose[:3, 3], of.matrix, of.distortion)
    by_place = np.asarray(derivatives, np.float64)[:, 3:6].reshape(-1, 2, 3)
    # A turn ω about the camera's axes moves a corner r by ω × r, and row · (ω × r) = (r × row) · ω.
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
    """Return the most likely pose near one of IPPE's, which minimises another error."""
    turn, place = cv2.solvePnPRefineLM(
        points,
        pixels,
        of.matrix,
        of.distortion,
        geometry.vector_from_rotation(pose[:3, :3]).reshape(3, 1),
        pose[:3, 3].reshape(3, 1).copy(),
    )
    refined = geometry.pose(geometry.rotation_from_vector(turn.ravel()), place.ravel())
    near = geometry.is_pose(refined) and geometry.angle_between(pose, refined) < AMBIGUITY_ANGLE / 2
    return refined if near and refined[2, 3] > 0 else pose
