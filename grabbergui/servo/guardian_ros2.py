"""How the guardian stops a TIAGo over ROS 2: a twist of zeros, and a head that holds its place."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from grabbergui.core.errors import RemoteProtocolError, TransportError
from grabbergui.net.ros2.runtime import Ros2Node
from grabbergui.servo.guardian import Channel
from grabbergui.servo.robots import tiago_messages as messages
from grabbergui.servo.robots.tiago import HEAD_JOINTS, HEAD_SIGNS
from grabbergui.servo.ros2_packages import ROBOT, require_packages

HOLD_S = 0.05
"Seconds in which the head settles where it is."


class TiagoChannel(Channel):
    """A node of its own, which reads joint states too: a head is held by sending it where it is."""

    def __init__(self, head: str, arm: str, joint_states: str) -> None:
        """Topics of a trajectory controller, of one for twists, and of the joints' readings."""
        self.name = f"{arm} and {head}"
        self._topics = head, arm, joint_states
        self._ros: Ros2Node | None = None
        self._head: Any = None
        self._arm: Any = None
        self._readings = messages.JointReadings(HEAD_JOINTS)

    def prepare(self) -> None:
        """See Channel."""
        if self._ros is None:
            self._join()
        deaf = [end.topic_name for end in (self._arm, self._head) if not end.get_subscription_count()]
        if deaf:
            raise TransportError(f"nobody listens to {' and '.join(deaf)}")
        if self._readings.angles(HEAD_JOINTS) is None:
            raise TransportError(f"{self._topics[2]} has not said where the head is")

    def stop(self) -> None:
        """See Channel. The hand first; the head's trajectories end by themselves soon."""
        ros = self._ros or self._join()
        now = ros.node.get_clock().now().to_msg()
        self._arm.publish(messages.twist_stamped(np.zeros(6), now))
        head = self._readings.angles(HEAD_JOINTS)
        if head is not None:
            self._head.publish(messages.head_trajectory(HEAD_SIGNS * head[1], HOLD_S))

    def close(self) -> None:
        """See Channel."""
        if self._ros is not None:
            self._ros.close()
            self._ros = None

    def reset(self) -> None:
        """Stay on the network, which is slow to join: whoever listens is found again by itself."""

    def _join(self) -> Ros2Node:
        require_packages(*ROBOT)
        from geometry_msgs.msg import TwistStamped
        from sensor_msgs.msg import JointState
        from trajectory_msgs.msg import JointTrajectory

        head, arm, joint_states = self._topics
        # No lock that the servo program, frozen, may hold stands between the guardian and the robot.
        ros = Ros2Node(f"grabbergui_guardian_{time.time_ns() % 10**9}", shared_memory=False)
        self._head = ros.node.create_publisher(JointTrajectory, head, 1)
        self._arm = ros.node.create_publisher(TwistStamped, arm, 1)
        ros.node.create_subscription(JointState, joint_states, self._on_joint_state, 1)
        ros.start()
        self._ros = ros
        return ros

    def _on_joint_state(self, message: Any) -> None:
        try:
            self._readings.take(message, time.monotonic())
        except RemoteProtocolError:
            return  # the servo program says so
