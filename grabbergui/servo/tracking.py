"""From detections in single images to targets that the robot may move for, and their present place. No clock.

A target is usable while each of the last few images showed it in one place and the newest image is fresh.
Anything else (a flickering detection, a second marker of the same id, an ambiguous or flipped pose)
interrupts it: such a view counts as not seen.

A marker's pose in the robot's base is filtered, where a moving head does not move a marker. Views are
weighted by their covariances, as in a Kalman filter with fading memory: at rest the newest view gets the
weight `smoothing`, and while the marker moves it gets nearly all. A view whose pose is the other of a plane's
two solutions (a flip) is recognised and ignored.

An image shows where the target was when it was exposed, tens of milliseconds ago. `TargetMotion` fits a
motion to the last positions, which gives place and velocity at a later time. Unlike a smoothed position, it
does not lag behind a target that speeds up or turns, but it is noisier, so a resting target is not predicted.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from grabbergui.calibration import geometry
from grabbergui.calibration.geometry import Pose, Vector
from grabbergui.calibration.marker_pose import AMBIGUITY_ANGLE, MarkerDetection
from grabbergui.servo.config import TrackConfig
from grabbergui.servo.detection import Sighting


# -- targets -------------------------------------------------------------------------------------
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
        covariance = _covariance_in_base(marker, camera, self._camera, captured - self._captured)
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
        flip = known is not None and _is_flip(marker, camera, known)
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


# -- the filter of a marker's pose ---------------------------------------------------------------
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


def _is_flip(marker: MarkerDetection, camera: Pose, known: Pose) -> bool:
    """Return whether a view contradicts the `known` pose, while its other solution agrees with it.

    `camera` is the camera's pose in the base when the frame was exposed.
    """
    if marker.pose is None or marker.other_pose is None:
        return False
    seen, other = (geometry.angle_between(camera @ pose, known) for pose in (marker.pose, marker.other_pose))
    return seen > AMBIGUITY_ANGLE and other < seen / 2


def _covariance_in_base(
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


# -- the motion of a target ----------------------------------------------------------------------
_Matrix = NDArray[np.float64]

_WINDOW_S = 0.6
"Seconds of positions to which the motions are fitted."
_RECENT_S = 0.35
"Seconds of the newest positions, which decide whether the target moves."
_FEWEST_SEEN = 6
"Fewest positions in that time for a prediction."
_RATES = (0.0, 1.0, 2.0, 3.0, 4.0)
"Rad/s at which the motions turn; rates in between are mixtures."
_TURNS = np.array(_RATES[1:])[:, None]
"The rates of the motions that turn, in a column; the first is the parabola's."
_NOISE_M = 0.002
"Expected error of a position: standard deviation of each coordinate, metres."
AHEAD_S = 0.25
"Longest prediction beyond the newest position, seconds."
_MOVING_SPEED = 0.03
"Metres per second, over the recent positions, from which a target counts as moving."
RESTS_S = 0.6
"Seconds below that speed after which it counts as resting: a target that turns back rests for a moment."


class TargetMotion:
    """Positions of one target in the robot's base, and the motions fitted to them.

    Hands move to and fro and in circles. A parabola fits that only for a third of a second, which has too few
    images to average the noise. So motions that turn at several rates are fitted over a longer time, each by
    least squares, and weighted by how well they explain the positions. At rate 0 the motion is a parabola.
    """

    def __init__(self) -> None:
        self.moving = False
        "Whether the target moves."
        self.speed = 0.0
        "Metres per second at the newest position, 0 for a target that rests."
        self._seen: deque[tuple[float, Vector]] = deque()
        self._moved = -np.inf
        self._starts: _Matrix = np.zeros((len(_RATES), 3, 3))
        "Each motion's metres, m/s and m/s², in rows, at the newest position's time."
        self._weights = np.zeros(len(_RATES))
        "Each motion's weight; their sum is 1."

    def restart(self) -> None:
        """Forget the target, which was lost or is another one."""
        self._seen.clear()
        self.moving, self.speed = False, 0.0

    def add(self, time: float, position: Vector) -> None:
        """Add its position, metres in the base, at a time; ignore a time that is not later than the last."""
        if self._seen and time <= self._seen[-1][0]:
            return
        self._seen.append((time, np.array(position, np.float64)))
        while self._seen[0][0] < time - _WINDOW_S:
            self._seen.popleft()
        times = np.array([seen[0] for seen in self._seen]) - time
        places = np.array([seen[1] for seen in self._seen])
        recent = times >= -_RECENT_S
        if recent.sum() < _FEWEST_SEEN or times[recent][0] > -_RECENT_S / 2:
            self.moving, self.speed = False, 0.0
            return
        if _speed(times[recent], places[recent]) >= _MOVING_SPEED:
            self._moved = time
        self.moving = time - self._moved < RESTS_S
        if self.moving:  # a resting target is not predicted
            self._fit(times, places)
        self.speed = float(np.linalg.norm(self.velocity(time)))

    def position(self, time: float) -> Vector | None:
        """Return where a moving target is at a time; None if it rests or is not known."""
        return self._mixed(_places, time) if self.moving else None

    def velocity(self, time: float) -> Vector:
        """Return its velocity at a time, m/s; zero for a target at rest."""
        return self._mixed(_velocities, time) if self.moving else np.zeros(3)

    def _fit(self, times: Vector, places: _Matrix) -> None:
        factors = _places(times)
        across = factors.transpose(0, 2, 1)
        self._starts = np.asarray(np.linalg.solve(across @ factors, across @ places), np.float64)
        misfits = ((places - factors @ self._starts) ** 2).sum(axis=(1, 2))
        likely = np.exp((misfits.min() - misfits) / (2 * _NOISE_M**2))
        self._weights = likely / likely.sum()

    def _mixed(self, factors: Callable[[Vector], _Matrix], time: float) -> Vector:
        ahead = np.array([min(max(time - self._seen[-1][0], 0.0), AHEAD_S)])
        mixed: Vector = self._weights @ (factors(ahead) @ self._starts)[:, 0]
        return mixed


def _speed(times: Vector, places: _Matrix) -> float:
    """Return the speed along the straight line through the places, m/s."""
    mean = times.mean()
    return float(np.linalg.norm((times - mean) @ places / ((times - mean) ** 2).sum()))


def _places(times: Vector) -> _Matrix:
    """Return (motions, n, 3) factors of a motion's first place, velocity and acceleration in its places."""
    turned = _TURNS * times
    factors = np.ones((len(_RATES), len(times), 3))
    factors[0, :, 1], factors[0, :, 2] = times, times**2 / 2
    factors[1:, :, 1], factors[1:, :, 2] = np.sin(turned) / _TURNS, (1 - np.cos(turned)) / _TURNS**2
    return factors


def _velocities(times: Vector) -> _Matrix:
    """Return (motions, n, 3): the same for its velocities."""
    turned = _TURNS * times
    factors = np.zeros((len(_RATES), len(times), 3))
    factors[0, :, 1], factors[0, :, 2] = 1.0, times
    factors[1:, :, 1], factors[1:, :, 2] = np.cos(turned), np.sin(turned) / _TURNS
    return factors
