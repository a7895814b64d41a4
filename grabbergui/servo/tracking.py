"""From detections in single images to targets that the robot may move for, and their present place. No clock.

A target is usable while each of the last few images showed it in one place and the newest image is fresh.
Anything else (a flickering detection, a second marker of the same id, an ambiguous or flipped pose)
interrupts it: such a view counts as not seen. `marker_filter` smooths its pose; `target_motion` predicts it.
"""

from __future__ import annotations

import math

import numpy as np

from grabbergui.calibration import geometry
from grabbergui.calibration.geometry import Pose, Vector
from grabbergui.calibration.marker_pose import MarkerDetection
from grabbergui.servo.config import TrackConfig
from grabbergui.servo.detection import Sighting
from grabbergui.servo.marker_filter import MarkerFilter, covariance_in_base, is_flip


class MarkerTrack:
    """The chosen marker, in the robot's base."""

    def __init__(self, marker_id: int, config: TrackConfig) -> None:
        self.problem = "no marker seen yet"
        "Why the marker is not usable, as display text; empty if it is."
        self._id = marker_id
        self._config = config
        self._streak = 0
        self._newest: Pose | None = None
        self._filter = MarkerFilter(config.smoothing)
        self._flips = 0
        self._camera: Pose | None = None
        self._captured = -math.inf

    @property
    def usable(self) -> bool:
        """Whether the robot may move for it, as long as its image is fresh."""
        return self._streak >= self._config.confirm

    @property
    def pose(self) -> Pose | None:
        """The filtered pose; None unless usable."""
        return self._filter.pose if self.usable else None

    @property
    def seen(self) -> Pose | None:
        """Its pose in the newest image alone, without the filter's lag; None unless usable."""
        return self._newest if self.usable else None

    def update(self, sighting: Sighting, camera: Pose | None) -> None:
        """Add an image's detections; `camera` is the camera's pose at its exposure, None if unknown."""
        self.problem = ""
        marker = sighting.only(self._id)
        if marker is None:
            twice = sighting.duplicates(self._id)
            self._interrupt(
                f"several markers {self._id} are seen" if twice else f"no marker {self._id} is seen"
            )
        elif marker.pose is None or not geometry.is_pose(marker.pose):
            self._interrupt(f"marker {self._id}: {marker.problem or 'its pose is no pose'}")
        elif marker.pose[2, 3] <= 0:
            self._interrupt(f"marker {self._id} would be behind the camera")
        elif camera is None or not geometry.is_pose(camera):
            self._interrupt("it is not known where the head looked")
        elif self._flipped(marker, camera):
            self._interrupt(f"marker {self._id}: its pose has flipped")
        else:
            self._take(marker, camera @ marker.pose, camera, sighting.captured)

    def _take(self, marker: MarkerDetection, seen: Pose, camera: Pose, captured: float) -> None:
        if self._newest is not None and self._streak and self._jumped(self._newest, seen):
            self._streak = 0
        covariance = covariance_in_base(marker, camera, self._camera, captured - self._captured)
        self._newest, self._camera, self._captured = seen, camera, captured
        self._streak += 1
        if self._streak == 1:
            self._filter.restart()
        self._filter.update(seen, covariance)
        if not self.usable:
            self.problem = f"marker {self._id} is not sure yet"

    def _flipped(self, marker: MarkerDetection, camera: Pose) -> bool:
        """Return whether the view shows the other of the marker's two poses than before.

        After more than `confirm` such views in a row, the earlier pose was the wrong one.
        """
        known = self._filter.pose
        flip = known is not None and is_flip(marker, camera, known)
        self._flips = self._flips + 1 if flip else 0
        if self._flips > self._config.confirm:
            self._filter.restart()
            return False
        return flip

    def _jumped(self, before: Pose, after: Pose) -> bool:
        return (
            geometry.distance(before, after) > self._config.jump
            or math.degrees(geometry.angle_between(before, after)) > self._config.jump_angle
        )

    def _interrupt(self, problem: str) -> None:
        self._streak, self.problem = 0, problem


class FaceTrack:
    """The nearest face, as a point in the robot's base."""

    def __init__(self, config: TrackConfig) -> None:
        self._config = config
        self._streak = 0
        self._point: Vector | None = None

    @property
    def point(self) -> Vector | None:
        """The point, metres; None unless enough images in a row showed it."""
        return self._point if self._streak >= self._config.confirm else None

    def update(self, sighting: Sighting, camera: Pose | None) -> None:
        """Add an image's detections."""
        face = sighting.nearest_face
        if face is None or camera is None or not np.isfinite(face.position).all() or face.position[2] <= 0:
            self._streak = 0
            return
        seen = camera[:3, :3] @ np.array(face.position) + camera[:3, 3]
        # The box's width, from which the distance is estimated, flickers: compare only directions.
        if self._point is None or _apart(self._point, seen, camera[:3, 3]) > self._config.jump * 2:
            self._streak, self._point = 0, seen
        self._streak += 1
        self._point = seen if self._streak == 1 else self._point + 0.5 * (seen - self._point)


def _apart(before: Vector, after: Vector, eye: Vector) -> float:
    """Return the angle between two points' directions, radians."""
    first, second = before - eye, after - eye
    cosine = float(first @ second / (np.linalg.norm(first) * np.linalg.norm(second)))
    return math.acos(min(1.0, max(-1.0, cosine)))
