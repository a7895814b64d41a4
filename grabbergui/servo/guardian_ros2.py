"""How the guardian stops a TIAGo over ROS 2: each part holds its place, by the controller that drives it."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from typing_extensions import override

from grabbergui.core.errors import RemoteProtocolError, TransportError
from grabbergui.net.ros2.runtime import Ros2Node, require_packages
from grabbergui.servo.guardian import Channel
from grabbergui.servo.robots import tiago_messages as messages
from grabbergui.servo.robots.robot import ARM, HEAD
from grabbergui.servo.robots.tiago import ARM_JOINTS, HEAD_JOINTS
from grabbergui.servo.robots.tiago_parts import Drive, Kind, Part

JOINTS = {ARM: ARM_JOINTS, HEAD: HEAD_JOINTS}
"The hand first: the head's trajectories end by themselves soon, and so do the arm's."


class TiagoChannel(Channel):
    """A node of its own, which reads joint states too: a part is held by sending it where it is."""

    def __init__(
        self,
        joint_states: str,
        head: str = "",
        head_kind: str = Kind.TRAJECTORY.value,
        arm: str = "",
        arm_kind: str = Kind.TWIST.value,
    ) -> None:
        """Topics of the joints' readings and of each part that is driven, with the kind of its messages."""
        given = {ARM: (arm, arm_kind), HEAD: (head, head_kind)}
        self._drives = {name: Drive(Kind(kind), topic) for name, (topic, kind) in given.items() if topic}
        self.name = " and ".join(drive.topic for drive in self._drives.values())
        self._joint_states = joint_states
        self._ros: Ros2Node | None = None
        self._parts: dict[str, Part] = {}
        self._readings = messages.JointReadings((*HEAD_JOINTS, *ARM_JOINTS))

    @override
    def prepare(self) -> None:
        if self._ros is None:
            self._join()
        deaf = [part.drive.topic for part in self._parts.values() if not part.heard]
        if deaf:
            raise TransportError(f"nobody listens to {' and '.join(deaf)}")
        for name, drive in self._drives.items():
            if drive.kind is not Kind.TWIST and self._readings.angles(JOINTS[name]) is None:
                raise TransportError(f"{self._joint_states} has not said where the {name} is")

    def stop(self) -> None:
        """Send every part where it is. Parts whose place is not known come to rest by themselves."""
        ros = self._ros or self._join()
        robot_time = self._readings.robot_time(time.monotonic())
        stamp = messages.stamp_of(robot_time) if robot_time else ros.node.get_clock().now().to_msg()
        for name, part in self._parts.items():
            reading = self._readings.angles(JOINTS[name])
            part.stop(None if reading is None else reading[1], stamp)

    @override
    def close(self) -> None:
        if self._ros is not None:
            self._ros.close()
            self._ros = None

    def reset(self) -> None:
        """Stay on the network, which is slow to join: whoever listens is found again by itself."""

    def _join(self) -> Ros2Node:
        require_packages(*messages.PACKAGES)
        from sensor_msgs.msg import JointState

        # No lock that the servo program, frozen, may hold stands between the guardian and the robot.
        ros = Ros2Node(f"grabbergui_guardian_{time.time_ns() % 10**9}", shared_memory=False)
        for name, drive in self._drives.items():
            limit = np.full(len(JOINTS[name]), np.inf)
            self._parts[name] = Part(ros.node, drive, JOINTS[name], -limit, limit)
        ros.node.create_subscription(JointState, self._joint_states, self._on_joint_state, 1)
        ros.start()
        self._ros = ros
        return ros

    def _on_joint_state(self, message: Any) -> None:
        try:
            self._readings.take(message, time.monotonic())
        except RemoteProtocolError:
            return  # the servo program reports it
