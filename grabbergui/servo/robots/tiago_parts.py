"""One part of TIAGo, head or arm, as it is commanded through its controller.

A `DrivenPart` publishes the commands of one part, in the form that the chosen controller takes.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from grabbergui.calibration.geometry import Vector
from grabbergui.core.errors import TransportError
from grabbergui.servo.robots import tiago_messages as messages
from grabbergui.servo.robots.joint_trajectory import JointStream, Trajectory, joint_trajectory
from grabbergui.servo.robots.robot import Robot
from grabbergui.servo.robots.tiago_messages import CommandKind, Drive

HOLD_S = 0.05
"Duration of a trajectory that holds a part in its place, seconds."
_POSITION_PERIOD = 0.02
"Seconds by which a position controller's commands are ahead."


class DrivenPart:
    """Publishes the commands of one part. Angles and velocities have the robot's signs, in its joints' order.

    One thread at a time. No method waits.
    """

    def __init__(self, node: Any, drive: Drive, joints: Sequence[str], low: Vector, high: Vector) -> None:
        """`low` and `high` are limits, radians."""
        self.drive = drive
        self.target: Vector | None = None
        "Angles at which its joints come to rest without another command; None before the first."
        self._stream = JointStream(joints, low, high, Robot.COMMAND_TIMEOUT)
        self._publisher = node.create_publisher(messages.message_type(drive.kind), drive.topic, 1)

    @property
    def heard(self) -> bool:
        """Whether the topic has a subscriber."""
        return bool(self._publisher.get_subscription_count())

    def move(self, velocity: Vector, measured: Vector, now: float, start: float | None) -> None:
        """Move the joints at `velocity`, rad/s, until `Robot.COMMAND_TIMEOUT` from `now`.

        `start` is `now` on the robot's clock, None if that is not known. Raises TransportError without a
        subscriber.
        """
        self._require_listener()
        if self.drive.kind is CommandKind.POSITION:
            self.target = self._stream.position(velocity, measured, now, _POSITION_PERIOD)
            self._publish_positions(self.target)
            return
        made = self._stream.move(velocity, measured, now)
        self.target = made.points[-1]
        whole = Trajectory(made.joints, made.times, made.points, start)
        # Without the robot's clock it can only start now, from the joints' present place.
        self._publish(whole if start is not None else _straight(made.joints, made.points[-1], made.times[-1]))

    def go_to(self, target: Vector, seconds: float) -> None:
        """Go to angles within some time and stay there. Raises TransportError without a subscriber."""
        self._require_listener()
        self._stream.forget()
        self._hold(target, seconds)

    def move_hand(self, twist: Vector, stamp: Any) -> None:
        """Move the hand by a twist along the base's axes. Raises TransportError without a subscriber."""
        self._require_listener()
        self._publisher.publish(messages.twist_stamped(twist, stamp))

    def stop(self, angles: Vector | None, stamp: Any) -> None:
        """Come to rest at `angles`, or if None where the newest command ends; needs no subscriber."""
        if self.drive.kind is CommandKind.TWIST:
            self._publisher.publish(messages.twist_stamped(np.zeros(6), stamp))
            return
        target = self.target if angles is None else angles
        self._stream.forget()
        if target is not None:
            self._hold(target, HOLD_S)

    def _hold(self, target: Vector, seconds: float) -> None:
        self.target = target
        if self.drive.kind is CommandKind.POSITION:
            self._publish_positions(target)
        else:
            self._publish(_straight(self._stream.joints, target, seconds))

    def _publish(self, trajectory: Trajectory) -> None:
        self._publisher.publish(joint_trajectory(trajectory))

    def _publish_positions(self, angles: Vector) -> None:
        from std_msgs.msg import Float64MultiArray

        self._publisher.publish(Float64MultiArray(data=[float(angle) for angle in angles]))

    def _require_listener(self) -> None:
        if not self.heard:
            raise TransportError(f"no controller subscribes to {self.drive.topic}; does it run?")


def _straight(joints: tuple[str, ...], target: Vector, seconds: float) -> Trajectory:
    return Trajectory(joints, (seconds,), np.array([target]))
