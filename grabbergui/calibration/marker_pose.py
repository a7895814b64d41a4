"""The pose of a marker or a board of markers from its corners.

It is the pose of the centre: x right, y up, z out of the face.

Poses are computed by IPPE, with a covariance. If a plane is small or far away, two poses explain its corners
about equally well. If one is clearly better, it is the result, and the other is kept so that a filter can
recognise a flip; else the view is ambiguous and has no pose.
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
