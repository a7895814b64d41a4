"""The pose of a flat target from its corners: IPPE's two solutions, judged, with a covariance.

In perspective a plane has two poses that explain its corners about equally well when it is small or far. The
better one is given where it is clearly better; else the view is ambiguous and there is none. The other
solution is kept, so that a filter can recognise a flip.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.calibration import geometry
from grabbergui.core.calibration import Calibration

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


@dataclass(frozen=True, eq=False)
class MarkerDetection:
    """One marker, or a board of markers that is one target."""

    marker_id: int
    "Of a board its first marker's."
    corners: NDArray[np.float64]
    "(4, 2) pixels of the full picture, from the printed upper left on, clockwise as printed."
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
    pose = _refined(found.pose, points, pixels, of)
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


def _refined(
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
