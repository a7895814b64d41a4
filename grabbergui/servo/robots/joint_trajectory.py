"""Joint velocities as short trajectories for TIAGo's controllers; no I/O, and of ROS only the messages.

A trajectory of `JointStream` replaces the previous one. It starts in the past, at the reference of that time:
`joint_trajectory_controller` (ros2_control, Humble and Jazzy) then interpolates between our points instead of
starting from the measured angles, which would slow a lagging drive down. It ends at rest, so that a robot
without further commands stops by itself.

Controllers treat `trajectory_msgs/JointTrajectory` as joint_trajectory_controller does: the newest message
replaces the trajectory in progress, positions alone are joined by straight lines, and the last one holds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grabbergui.calibration.geometry import Vector
from grabbergui.core.errors import RemoteProtocolError

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


class JointStream:
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
