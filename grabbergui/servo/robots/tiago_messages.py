"""Kinds of commands to TIAGo's controllers on ROS 2, and the twists among them; of ROS only the messages."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np

from grabbergui.calibration.geometry import Vector
from grabbergui.core.errors import RemoteProtocolError
from grabbergui.servo.robots.tiago import BASE

PACKAGES = ("geometry_msgs.msg", "sensor_msgs.msg", "trajectory_msgs.msg")
"""The message packages that drive a TIAGo."""


class CommandKind(Enum):
    """The kind of commands that a part of the robot obeys."""

    TRAJECTORY = "trajectory"
    POSITION = "position"
    TWIST = "twist"


_PHRASE = {
    CommandKind.TRAJECTORY: "streamed trajectories",
    CommandKind.POSITION: "positions",
    CommandKind.TWIST: "twists",
}


@dataclass(frozen=True)
class Drive:
    """The destination of one part's commands."""

    kind: CommandKind
    topic: str
    controller: str = ""
    "Its name in the controller manager; empty if it is not listed there."

    def __str__(self) -> str:
        return f"{_PHRASE[self.kind]} to {self.topic}"


def message_type(kind: CommandKind) -> Any:
    """Return the message class of one kind of commands."""
    if kind is CommandKind.TWIST:
        from geometry_msgs.msg import TwistStamped

        return TwistStamped
    if kind is CommandKind.POSITION:
        from std_msgs.msg import Float64MultiArray

        return Float64MultiArray
    from trajectory_msgs.msg import JointTrajectory

    return JointTrajectory


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
