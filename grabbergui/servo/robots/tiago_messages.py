"""Messages to and from TIAGo's controllers on ROS 2; no I/O, and of ROS only the messages.

Joint velocities become short trajectories (`Stream`), each of which replaces the previous one. A trajectory
starts in the past, at the reference of that time: `joint_trajectory_controller` (ros2_control, Humble and
Jazzy) then interpolates between our points instead of starting from the measured angles, which would slow a
lagging drive down. It ends at rest, so that a robot without further commands stops by itself.

Controllers treat `trajectory_msgs/JointTrajectory` as joint_trajectory_controller does: the newest message
replaces the trajectory in progress, positions alone are joined by straight lines, and the last one holds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grabbergui.calibration.geometry import Pose, Vector, pose, rotation_from_quaternion
from grabbergui.core.errors import RemoteProtocolError
from grabbergui.servo.robots.robot import RobotState
from grabbergui.servo.robots.tiago import ARM_JOINTS, BASE, HEAD_JOINTS, HEAD_SIGNS

PACKAGES = ("geometry_msgs.msg", "sensor_msgs.msg", "trajectory_msgs.msg")
"""The message packages that drive a TIAGo."""


# -- kinds of commands ---------------------------------------------------------------------------
class Kind(Enum):
    """The kind of commands that a part of the robot obeys."""

    TRAJECTORY = "trajectory"
    POSITION = "position"
    TWIST = "twist"


_PHRASE = {
    Kind.TRAJECTORY: "streamed trajectories",
    Kind.POSITION: "positions",
    Kind.TWIST: "twists",
}


@dataclass(frozen=True)
class Drive:
    """The destination of one part's commands."""

    kind: Kind
    topic: str
    controller: str = ""
    "Its name in the controller manager; empty if it is not listed there."

    def __str__(self) -> str:
        return f"{_PHRASE[self.kind]} to {self.topic}"


def message_type(kind: Kind) -> Any:
    """Return the message class of one kind of commands."""
    if kind is Kind.TWIST:
        from geometry_msgs.msg import TwistStamped

        return TwistStamped
    if kind is Kind.POSITION:
        from std_msgs.msg import Float64MultiArray

        return Float64MultiArray
    from trajectory_msgs.msg import JointTrajectory

    return JointTrajectory


# -- trajectories --------------------------------------------------------------------------------
LEAD = 0.15
"Radians by which the reference may be ahead of the measured angles, so that a blocked joint does not jump."


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Angles over time."""

    joints: tuple[str, ...]
    times: tuple[float, ...]
    "Seconds from the start, increasing."
    points: NDArray[np.float64]
    "(len(times), len(joints)), radians."
    start: float | None = None
    "Seconds on the robot's clock; None: now, from the joints' present place."


class Stream:
    """Turns velocities of some joints into references. Times are on any one clock; one thread."""

    def __init__(self, joints: Sequence[str], low: Vector, high: Vector, horizon: float) -> None:
        """`low` and `high` are limits, radians; a velocity lasts for `horizon` seconds."""
        self.joints = tuple(joints)
        self._low, self._high, self._horizon = low, high, horizon
        self._reference: Vector | None = None
        self._velocity = np.zeros(len(low))
        self._time = 0.0

    @property
    def target(self) -> Vector | None:
        """The angles at which the newest trajectory ends; None before the first and after `forget`."""
        if self._reference is None:
            return None
        ahead: Vector = np.clip(self._reference + self._velocity * self._horizon, self._low, self._high)
        return ahead

    def forget(self) -> None:
        """Start again from the measured angles."""
        self._reference = None

    def move(self, velocity: Vector, measured: Vector, now: float) -> Trajectory:
        """Return the trajectory that moves the joints at `velocity` (rad/s) from `now` for the horizon.

        Its `start` is on the clock of `now`. Joints whose velocity is 0 hold their place.
        """
        self._advance(velocity, measured, now)
        assert self._reference is not None and self.target is not None
        return Trajectory(
            self.joints, (0.0, self._horizon), np.vstack((self._reference, self.target)), start=now
        )

    def position(self, velocity: Vector, measured: Vector, now: float, period: float) -> Vector:
        """Return the angles to reach within one `period`, for controllers that take positions alone."""
        self._advance(velocity, measured, now)
        assert self._reference is not None
        ahead: Vector = np.clip(self._reference + velocity * period, self._low, self._high)
        return ahead

    def _advance(self, velocity: Vector, measured: Vector, now: float) -> None:
        elapsed = now - self._time
        if self._reference is None or not 0 <= elapsed <= self._horizon:
            reference = measured
        else:
            reference = self._reference + self._velocity * elapsed
            reference = np.clip(reference, measured - LEAD, measured + LEAD)
        self._reference = np.clip(reference, self._low, self._high)
        self._velocity, self._time = np.array(velocity, np.float64), now


def joint_trajectory(trajectory: Trajectory) -> Any:
    """Encode a trajectory; without a start its stamp is zero, which means now."""
    from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

    message = JointTrajectory(joint_names=list(trajectory.joints))
    if trajectory.start is not None:
        _set_time(message.header.stamp, trajectory.start)
    for seconds, angles in zip(trajectory.times, trajectory.points, strict=True):
        point = JointTrajectoryPoint(positions=[float(angle) for angle in angles])
        _set_time(point.time_from_start, seconds)
        message.points.append(point)
    return message


def read_trajectory(message: Any) -> Trajectory:
    """Decode a trajectory of positions. Raises RemoteProtocolError if its points do not fit its joints."""
    names = tuple(message.joint_names)
    for point in message.points:
        if len(point.positions) != len(names):
            raise RemoteProtocolError(f"{len(names)} joints with {len(point.positions)} positions")
    if message.points and any(message.points[-1].velocities):
        raise RemoteProtocolError("a trajectory that would not end at rest")
    points = np.array([list(point.positions) for point in message.points], np.float64)
    times = tuple(_seconds(point.time_from_start) for point in message.points)
    start = _seconds(message.header.stamp)
    return Trajectory(names, times, points.reshape(len(times), len(names)), start or None)


def stamp_of(seconds: float) -> Any:
    """Return a time on the robot's clock as `builtin_interfaces/Time`."""
    from builtin_interfaces.msg import Time

    stamp = Time()
    _set_time(stamp, seconds)
    return stamp


def _set_time(stamp: Any, seconds: float) -> None:
    stamp.sec, stamp.nanosec = divmod(round(seconds * 1e9), 1_000_000_000)


def _seconds(stamp: Any) -> float:
    return float(stamp.sec + 1e-9 * stamp.nanosec)


# -- arm -----------------------------------------------------------------------------------------
def twist_stamped(twist: Vector, stamp: Any) -> Any:
    """Encode the hand's velocity, m/s and rad/s along the base's axes."""
    from geometry_msgs.msg import TwistStamped

    message = TwistStamped()
    message.header.stamp, message.header.frame_id = stamp, BASE
    linear, angular = message.twist.linear, message.twist.angular
    linear.x, linear.y, linear.z, angular.x, angular.y, angular.z = map(float, twist)
    return message


def read_twist(message: Any) -> Vector:
    """Decode the hand's velocity. Raises RemoteProtocolError if its frame is another or it is not finite."""
    if message.header.frame_id != BASE:
        raise RemoteProtocolError(f"a twist in the frame '{message.header.frame_id}', not '{BASE}'")
    linear, angular = message.twist.linear, message.twist.angular
    twist = np.array([linear.x, linear.y, linear.z, angular.x, angular.y, angular.z])
    if not np.isfinite(twist).all():
        raise RemoteProtocolError("a twist that is not finite")
    return twist


# -- readings ------------------------------------------------------------------------------------
CLOCK_SET_BACK_S = 0.5
"Seconds for which older stamps must advance without a newer one, until the clock counts as set back."


def joint_state(reading: RobotState, stamp: Any) -> Any:
    """Return the `sensor_msgs/JointState` of a reading."""
    from sensor_msgs.msg import JointState

    message = JointState(name=[*HEAD_JOINTS, *ARM_JOINTS])
    message.header.stamp = stamp
    arm = () if reading.arm is None else reading.arm
    message.position = [float(angle) for angle in (*(HEAD_SIGNS * reading.head), *arm)]
    return message


class JointReadings:
    """The newest angles of some joints, out of `sensor_msgs/JointState`. Use from one thread.

    A message may contain a few joints only, and several publishers may take turns. A message whose stamp does
    not advance is ignored.
    """

    def __init__(self, names: Sequence[str]) -> None:
        self._readings: dict[str, tuple[float, float]] = {}
        self._stamps: dict[str, int] = {}
        self._older: dict[str, tuple[float, int]] = {}
        "When older stamps began to arrive, and the newest of them; empty while stamps advance."
        self._wanted = frozenset(names)
        self._newest: tuple[float, float] | None = None

    def take(self, message: Any, now: float) -> None:
        """Note a message that arrived `now`. Raises RemoteProtocolError if it is malformed."""
        if len(message.position) != len(message.name):
            raise RemoteProtocolError(
                f"a joint state of {len(message.name)} joints with {len(message.position)} positions"
            )
        stamp = message.header.stamp.sec * 1_000_000_000 + message.header.stamp.nanosec
        if stamp and self._wanted & set(message.name):
            self._newest = now, 1e-9 * stamp
        for name, angle in zip(message.name, message.position, strict=True):
            if name not in self._wanted:
                continue
            if not np.isfinite(angle):
                raise RemoteProtocolError(f"a joint state in which {name} is at {angle}")
            if stamp == 0 or stamp > self._stamps.get(name, 0) or self._set_back(name, stamp, now):
                self._stamps[name] = stamp
                self._readings[name] = now, float(angle)
                self._older.pop(name, None)

    def _set_back(self, name: str, stamp: int, now: float) -> bool:
        """Return whether an older stamp shows that the clock was set back."""
        if stamp == self._stamps.get(name):
            return False  # sent again
        begun, newest = self._older.setdefault(name, (now, stamp))
        self._older[name] = begun, max(stamp, newest)
        return stamp > newest and now - begun >= CLOCK_SET_BACK_S

    def robot_time(self, now: float) -> float | None:
        """Return the robot's clock, estimated `now`, seconds; None before a message with a stamp.

        It is late by the age of a message at its arrival, never early: a controller must not wait for a start
        in the future.
        """
        if self._newest is None:
            return None
        arrival, stamp = self._newest
        return stamp + now - arrival

    def missing(self) -> list[str]:
        """Return the joints without a reading."""
        return sorted(self._wanted - self._readings.keys())

    def angles(self, names: Sequence[str]) -> tuple[float, Vector] | None:
        """Return the arrival of the oldest reading, and all angles, radians; None if one is missing."""
        found = [self._readings.get(name) for name in names]
        known = [reading for reading in found if reading is not None]
        if len(known) < len(found):
            return None
        return min(time for time, _ in known), np.array([angle for _, angle in known])


# -- tf ------------------------------------------------------------------------------------------
class StaticFrames:
    """Fixed transforms between frames, from `tf2_msgs/TFMessage` on `/tf_static`."""

    def __init__(self) -> None:
        self._parents: dict[str, tuple[str, Pose]] = {}

    def take(self, message: Any) -> None:
        """Note a message's transforms."""
        for entry in message.transforms:
            place, turn = entry.transform.translation, entry.transform.rotation
            placed = pose(
                rotation_from_quaternion(turn.x, turn.y, turn.z, turn.w), (place.x, place.y, place.z)
            )
            if np.isfinite(placed).all():
                self._parents[entry.child_frame_id.lstrip("/")] = entry.header.frame_id.lstrip("/"), placed

    def of(self, child: str, ancestor: str) -> Pose | None:
        """Return the pose of a frame in one above it; None if it is not known."""
        placed, frame = pose(), child
        for _ in range(len(self._parents) + 1):
            if frame == ancestor:
                return placed
            if frame not in self._parents:
                return None
            frame, step = self._parents[frame]
            placed = step @ placed
        return None
