"""From detections in single pictures to targets that may be moved for.

A target is usable while it was seen in each of the last few pictures, in one place, by a picture that is
fresh. Anything else (a detection that comes and goes, a second marker of the same id, an ambiguous pose or
one that flipped) interrupts it at once: such a view counts as not seen.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from grabbergui.calibration import geometry
from grabbergui.calibration.geometry import Pose, Vector
from grabbergui.calibration.marker_pose import MarkerDetection
from grabbergui.servo.config import TrackConfig
from grabbergui.servo.detection import Sighting
from grabbergui.servo.marker_filter import Covariance, MarkerFilter, covariance_in_base, is_flip


class JointHistory:
    """Joint angles of the last moments, to know where the head looked when a picture was exposed."""

    SLACK = 0.06
    "Seconds beyond the newest or oldest reading for which it still stands."

    def __init__(self, length: int = 200) -> None:
        self._readings: deque[tuple[float, Vector]] = deque(maxlen=length)

    def add(self, time: float, angles: Vector) -> None:
        """Note a reading; one that is no newer than the last, or not finite, is ignored."""
        if np.isfinite(angles).all() and (not self._readings or time > self._readings[-1][0]):
            self._readings.append((time, np.array(angles, np.float64)))

    def at(self, time: float) -> Vector | None:
        """The angles at a time, between readings in proportion; None where nothing is known."""
        readings = self._readings
        if not readings or not readings[0][0] - self.SLACK <= time <= readings[-1][0] + self.SLACK:
            return None
        later = None
        for reading in reversed(readings):
            if reading[0] <= time:
                if later is None:
                    return reading[1]
                part = (time - reading[0]) / (later[0] - reading[0])
                return reading[1] + part * (later[1] - reading[1])
            later = reading
        return readings[0][1]


class MarkerTrack:
    """The chosen marker, in the robot's base."""

    def __init__(self, marker_id: int, config: TrackConfig) -> None:
        self.problem = "no marker seen yet"
        "Why it is not usable, as display text; empty if it is."
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
        """Whether it may be moved for, as long as its picture is fresh."""
        return self._streak >= self._config.confirm

    @property
    def pose(self) -> Pose | None:
        """The filtered pose; None unless usable."""
        return self._filter.pose if self.usable else None

    @property
    def covariance(self) -> Covariance | None:
        """(6, 6) of the pose, metres along and radians about the base's axes; None unless usable."""
        return self._filter.covariance if self.usable else None

    @property
    def captured(self) -> float:
        """When the newest picture that showed it was exposed."""
        return self._captured

    @property
    def seen(self) -> Pose | None:
        """Its pose in the newest picture alone, unfiltered, so without lag; None unless usable."""
        return self._newest if self.usable else None

    def update(self, sighting: Sighting, camera: Pose | None) -> None:
        """Take in what a picture showed; `camera` is where the camera was then, None if unknown."""
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
        """Whether it is seen in the other of its two poses than before.

        Seen so as often in a row as a marker must be to be believed, it was the earlier pose that was wrong.
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
    """The nearest head, as a point in the robot's base."""

    def __init__(self, config: TrackConfig) -> None:
        self._config = config
        self._streak = 0
        self._point: Vector | None = None

    @property
    def point(self) -> Vector | None:
        """Metres; None unless it was seen often enough in a row."""
        return self._point if self._streak >= self._config.confirm else None

    def update(self, sighting: Sighting, camera: Pose | None) -> None:
        """Take in what a picture showed."""
        head = sighting.nearest_face
        if head is None or camera is None or not np.isfinite(head.position).all() or head.position[2] <= 0:
            self._streak = 0
            return
        seen = camera[:3, :3] @ np.array(head.position) + camera[:3, 3]
        # The distance is estimated from a box whose width flickers, so only the direction is compared.
        if self._point is None or _apart(self._point, seen, camera[:3, 3]) > self._config.jump * 2:
            self._streak, self._point = 0, seen
        self._streak += 1
        self._point = seen if self._streak == 1 else self._point + 0.5 * (seen - self._point)


def _apart(before: Vector, after: Vector, eye: Vector) -> float:
    """Radians between two points' directions."""
    first, second = before - eye, after - eye
    cosine = float(first @ second / (np.linalg.norm(first) * np.linalg.norm(second)))
    return math.acos(min(1.0, max(-1.0, cosine)))
