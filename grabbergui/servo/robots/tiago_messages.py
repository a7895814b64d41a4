"""What is said to TIAGo's controllers on ROS 2, and what they tell; no I/O, and no ROS but its messages.

The head takes `trajectory_msgs/JointTrajectory` as joint_trajectory_controller does: the newest message
replaces what was under way, positions alone are gone to in a straight line, and are held.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from grabbergui.calibration.geometry import Pose, Vector, pose, rotation_from_quaternion
from grabbergui.core.errors import RemoteProtocolError
from grabbergui.servo.robots.tiago import BASE, HEAD_JOINTS, HEAD_SIGNS


# -- head ----------------------------------------------------------------------------------------
def head_trajectory(target: Vector, seconds: float) -> Any:
    """Go to pan and tilt (radians, ours) within some time. The stamp is zero: at once."""
    from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

    point = JointTrajectoryPoint(positions=[float(angle) for angle in HEAD_SIGNS * target])
    whole, part = divmod(round(seconds * 1e9), 1_000_000_000)
    point.time_from_start.sec, point.time_from_start.nanosec = whole, part
    return JointTrajectory(joint_names=list(HEAD_JOINTS), points=[point])


def read_head_trajectory(message: Any) -> tuple[Vector, float]:
    """Where such a message ends (ours, radians), and when. Raises RemoteProtocolError, with the reason."""
    if sorted(message.joint_names) != sorted(HEAD_JOINTS):
        raise RemoteProtocolError(f"a trajectory of {list(message.joint_names)}, not {list(HEAD_JOINTS)}")
    if not message.points:
        raise RemoteProtocolError("an empty trajectory")
    last = message.points[-1]
    if len(last.positions) != len(HEAD_JOINTS) or not np.isfinite(last.positions).all():
        raise RemoteProtocolError(f"a trajectory to {list(last.positions)}")
    if any(last.velocities):
        raise RemoteProtocolError("a trajectory that would not end at rest")
    seconds = last.time_from_start.sec + 1e-9 * last.time_from_start.nanosec
    if seconds <= 0:
        raise RemoteProtocolError("a trajectory that takes no time")
    order = [list(message.joint_names).index(name) for name in HEAD_JOINTS]
    return HEAD_SIGNS * np.array(last.positions)[order], seconds


# -- arm -----------------------------------------------------------------------------------------
def twist_stamped(twist: Vector, stamp: Any) -> Any:
    """The hand's velocity, m/s and rad/s along the axes of our base."""
    from geometry_msgs.msg import TwistStamped

    message = TwistStamped()
    message.header.stamp, message.header.frame_id = stamp, BASE
    linear, angular = message.twist.linear, message.twist.angular
    linear.x, linear.y, linear.z, angular.x, angular.y, angular.z = map(float, twist)
    return message


def read_twist(message: Any) -> Vector:
    """Of such a message. Raises RemoteProtocolError where it is along other axes or not finite."""
    if message.header.frame_id != BASE:
        raise RemoteProtocolError(f"a twist in the frame '{message.header.frame_id}', not '{BASE}'")
    linear, angular = message.twist.linear, message.twist.angular
    twist = np.array([linear.x, linear.y, linear.z, angular.x, angular.y, angular.z])
    if not np.isfinite(twist).all():
        raise RemoteProtocolError("a twist that is not finite")
    return twist


# -- readings ------------------------------------------------------------------------------------
class JointReadings:
    """The newest angles of some joints, out of `sensor_msgs/JointState`. Use from one thread.

    A message may tell of a few joints only, several publishers may take turns, and one whose stamp does not
    advance says nothing new.
    """

    def __init__(self, names: Sequence[str]) -> None:
        self._readings: dict[str, tuple[float, float]] = {}
        self._stamps: dict[str, int] = {}
        self._wanted = frozenset(names)

    def take(self, message: Any, now: float) -> None:
        """Note a message that arrived `now`. Raises RemoteProtocolError where it cannot be believed."""
        if len(message.position) != len(message.name):
            raise RemoteProtocolError(
                f"a joint state of {len(message.name)} joints with {len(message.position)} positions"
            )
        stamp = message.header.stamp.sec * 1_000_000_000 + message.header.stamp.nanosec
        for name, angle in zip(message.name, message.position, strict=True):
            if name not in self._wanted:
                continue
            if not np.isfinite(angle):
                raise RemoteProtocolError(f"a joint state in which {name} is at {angle}")
            if stamp == 0 or stamp > self._stamps.get(name, 0):
                self._stamps[name] = stamp
                self._readings[name] = now, float(angle)

    def missing(self) -> list[str]:
        """Joints of which nothing was heard."""
        return sorted(self._wanted - self._readings.keys())

    def angles(self, names: Sequence[str]) -> tuple[float, Vector] | None:
        """When the oldest of them arrived, and all angles, radians; None while one is missing."""
        found = [self._readings.get(name) for name in names]
        known = [reading for reading in found if reading is not None]
        if len(known) < len(found):
            return None
        return min(time for time, _ in known), np.array([angle for _, angle in known])


# -- tf ------------------------------------------------------------------------------------------
class StaticFrames:
    """Where frames sit that never move against each other, out of `tf2_msgs/TFMessage` on `/tf_static`."""

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
        """The pose of one frame in another above it; None while that is not known."""
        placed, frame = pose(), child
        for _ in range(len(self._parents) + 1):
            if frame == ancestor:
                return placed
            if frame not in self._parents:
                return None
            frame, step = self._parents[frame]
            placed = step @ placed
        return None
