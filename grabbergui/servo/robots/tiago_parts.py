"""One part of a TIAGo on ROS 2, its head or its arm, behind whatever controller drives it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from grabbergui.calibration.geometry import Vector
from grabbergui.core.errors import TransportError
from grabbergui.servo.robots import tiago_messages as messages
from grabbergui.servo.robots.robot import Robot
from grabbergui.servo.robots.tiago_controllers import Drive, Kind
from grabbergui.servo.robots.trajectories import Stream, Trajectory

HOLD_S = 0.05
"Seconds in which a part that is to hold its place settles there."
PERIOD = 0.02
"Seconds ahead of which a position controller is commanded."


class Part:
    """Publishes the commands of one part. Angles and velocities have the robot's signs, in its joints' order.

    One thread at a time. Nothing waits.
    """

    def __init__(self, node: Any, drive: Drive, joints: Sequence[str], low: Vector, high: Vector) -> None:
        """`low` and `high` are limits, radians."""
        self.drive = drive
        self.target: Vector | None = None
        "Where its joints come to rest if nothing else is said; None before the first command."
        self._stream = Stream(joints, low, high, Robot.COMMAND_TIMEOUT)
        self._publisher = node.create_publisher(_message_type(drive.kind), drive.topic, 1)

    @property
    def heard(self) -> bool:
        """Whether anybody listens."""
        return bool(self._publisher.get_subscription_count())

    def move(self, velocity: Vector, measured: Vector, now: float, start: float | None) -> None:
        """Move the joints at `velocity`, rad/s, until `Robot.COMMAND_TIMEOUT` from `now`.

        `start` is `now` on the robot's clock, if that is known. Raises TransportError where nobody listens.
        """
        self._require_listener()
        if self.drive.kind is Kind.POSITION:
            self.target = self._stream.position(velocity, measured, now, PERIOD)
            self._publish_positions(self.target)
            return
        made = self._stream.move(velocity, measured, now)
        self.target = made.points[-1]
        whole = Trajectory(made.joints, made.times, made.points, start)
        # Without the robot's clock it can only begin at once, from wherever the joints are.
        self._publish(whole if start is not None else _straight(made.joints, made.points[-1], made.times[-1]))

    def go_to(self, target: Vector, seconds: float) -> None:
        """Go to angles within some time and stay there. Raises TransportError where nobody listens."""
        self._require_listener()
        self._stream.forget()
        self._hold(target, seconds)

    def move_hand(self, twist: Vector, stamp: Any) -> None:
        """Move the hand by a twist along the base's axes. Raises TransportError where nobody listens."""
        self._require_listener()
        self._publisher.publish(messages.twist_stamped(twist, stamp))

    def stop(self, angles: Vector | None, stamp: Any) -> None:
        """Come to rest at `angles`, or without any where the newest command ends; nobody need listen."""
        if self.drive.kind is Kind.TWIST:
            self._publisher.publish(messages.twist_stamped(np.zeros(6), stamp))
            return
        target = self.target if angles is None else angles
        self._stream.forget()
        if target is not None:
            self._hold(target, HOLD_S)

    def _hold(self, target: Vector, seconds: float) -> None:
        self.target = target
        if self.drive.kind is Kind.POSITION:
            self._publish_positions(target)
        else:
            self._publish(_straight(self._stream.joints, target, seconds))

    def _publish(self, trajectory: Trajectory) -> None:
        self._publisher.publish(messages.joint_trajectory(trajectory))

    def _publish_positions(self, angles: Vector) -> None:
        from std_msgs.msg import Float64MultiArray

        self._publisher.publish(Float64MultiArray(data=[float(angle) for angle in angles]))

    def _require_listener(self) -> None:
        if not self.heard:
            raise TransportError(f"nobody listens to {self.drive.topic}; is the controller running?")


def _straight(joints: tuple[str, ...], target: Vector, seconds: float) -> Trajectory:
    return Trajectory(joints, (seconds,), np.array([target]))


def _message_type(kind: Kind) -> Any:
    if kind is Kind.TWIST:
        from geometry_msgs.msg import TwistStamped

        return TwistStamped
    if kind is Kind.POSITION:
        from std_msgs.msg import Float64MultiArray

        return Float64MultiArray
    from trajectory_msgs.msg import JointTrajectory

    return JointTrajectory
