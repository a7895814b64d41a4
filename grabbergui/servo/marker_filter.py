"""The filter of a marker's pose in the robot's base, where a moving head does not move a marker.

Views are weighted by their covariances, as in a Kalman filter with fading memory: at rest the newest view
gets the weight `smoothing`, and while the marker moves it gets nearly all. A view whose pose is the other of
a plane's two solutions (a flip) is recognised and ignored.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from grabbergui.calibration import geometry
from grabbergui.calibration.geometry import Pose, Vector
from grabbergui.calibration.marker_pose import AMBIGUITY_ANGLE, MarkerDetection

Covariance = NDArray[np.float64]
"(6, 6): metres along, then radians about the base's axes."

UNKNOWN = np.diag([0.003**2] * 3 + [math.radians(1.0) ** 2] * 3)
"Covariance of a detection that comes without one."
_TIMING_S = 0.005
"Seconds by which a frame's time and the joints' may disagree, which is noise while the head moves."
_MOVED = 14.2
"Squared innovation over its covariance that noise exceeds in 3 of 1000 views (chi-square, 3 axes)."


class MarkerFilter:
    """The marker's pose and its covariance. Use from one thread."""

    def __init__(self, smoothing: float) -> None:
        """`smoothing` is the newest view's weight at rest, more than 0 and at most 1."""
        self.pose: Pose | None = None
        "Marker to base; None before the first view."
        self.covariance: Covariance = UNKNOWN
        "The covariance of `pose`."
        self._keep = 1 - smoothing
        self._surprises = 0

    def restart(self) -> None:
        """Forget all views."""
        self.pose, self._surprises = None, 0

    def update(self, seen: Pose, covariance: Covariance) -> Pose:
        """Add a view by its pose in the base and its covariance; return the filtered pose."""
        if self.pose is None:
            self.pose, self.covariance = seen, covariance
            return seen
        innovation = geometry.diff(self.pose, seen)
        before = self.covariance / max(self._keep, 1e-3)
        if self._surprising(innovation, before + covariance):
            self._surprises += 1
        else:
            self._surprises = 0
        if self._surprises > 1:  # one may be noise; after two in a row, the marker moves
            before = before + np.diag(innovation**2)
        gain = np.linalg.solve(before + covariance, before).T
        self.pose = geometry.add_delta(self.pose, gain @ innovation)
        after = before - gain @ before
        self.covariance = (after + after.T) / 2
        return self.pose

    def _surprising(self, innovation: Vector, spread: Covariance) -> bool:
        """Return whether noise alone hardly explains the innovation."""
        return any(
            float(innovation[axes] @ np.linalg.solve(spread[axes, axes], innovation[axes])) > _MOVED
            for axes in (slice(0, 3), slice(3, 6))
        )


def is_flip(marker: MarkerDetection, camera: Pose, known: Pose) -> bool:
    """Return whether a view contradicts the `known` pose, while its other solution agrees with it.

    `camera` is the camera's pose in the base when the frame was exposed.
    """
    if marker.pose is None or marker.other_pose is None:
        return False
    seen, other = (geometry.angle_between(camera @ pose, known) for pose in (marker.pose, marker.other_pose))
    return seen > AMBIGUITY_ANGLE and other < seen / 2


def covariance_in_base(
    marker: MarkerDetection, camera: Pose, before: Pose | None, seconds: float
) -> Covariance:
    """Return a detection's covariance along the base's axes, increased by the camera's motion.

    `before` is the camera's pose `seconds` ago, None if unknown.
    """
    turn = np.kron(np.eye(2), camera[:3, :3])
    own = UNKNOWN if marker.covariance is None else marker.covariance
    covariance: Covariance = turn @ own @ turn.T
    if before is None or marker.pose is None or not 0 < seconds < 1:
        return covariance
    moved = geometry.diff(before @ marker.pose, camera @ marker.pose) * (_TIMING_S / seconds)
    return np.asarray(covariance + np.diag(moved**2), np.float64)
