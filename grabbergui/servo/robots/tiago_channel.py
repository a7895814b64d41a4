"""The guardian's channel to TIAGo on ROS 2: it holds head and arm where they are."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from typing_extensions import override

from grabbergui.core.errors import (
    RemoteProtocolError,
    TransportError,
)
from grabbergui.net.ros2.requirements import require_packages
from grabbergui.net.ros2.runtime import Ros2Node
from grabbergui.servo.robots import tiago
from grabbergui.servo.robots import tiago_messages as messages
from grabbergui.servo.robots.joint_readings import JointReadings
from grabbergui.servo.robots.joint_trajectory import stamp_of
from grabbergui.servo.robots.robot import ARM, HEAD
from grabbergui.servo.robots.tiago_messages import CommandKind, Drive
from grabbergui.servo.robots.tiago_nodes import GUARDIAN
from grabbergui.servo.robots.tiago_parts import DrivenPart
from grabbergui.servo.robots.tiago_ros2 import GUARDIAN_FRESH_S, JOINTS
from grabbergui.servo.stop_channel import Channel


class TiagoChannel(Channel):
    """Stops a TIAGo for the guardian: sends each part to its present place, through the part's controller.

    For that it has a node of its own, which reads joint states, too.
    """

    def __init__(
        self,
        joint_states: str,
        head: str = "",
        head_kind: str = CommandKind.TRAJECTORY.value,
        arm: str = "",
        arm_kind: str = CommandKind.TWIST.value,
    ) -> None:
        """Topics of the joint states and of each driven part, with the kind of its messages."""
        # The arm first.
        given = {ARM: (arm, arm_kind), HEAD: (head, head_kind)}
        self._drives = {
            name: Drive(CommandKind(kind), topic) for name, (topic, kind) in given.items() if topic
        }
        self.name = " and ".join(drive.topic for drive in self._drives.values())
        self._joint_states = joint_states
        self._ros: Ros2Node | None = None
        self._parts: dict[str, DrivenPart] = {}
        self._readings = JointReadings((*tiago.HEAD_JOINTS, *tiago.ARM_JOINTS))

    @override
    def prepare(self) -> None:
        if self._ros is None:
            self._join()
        silent = [part.drive.topic for part in self._parts.values() if not part.heard]
        if silent:
            raise TransportError(f"no controller subscribes to {' and '.join(silent)}")
        for name, drive in self._drives.items():
            if drive.kind is not CommandKind.TWIST and self._readings.angles(JOINTS[name]) is None:
                raise TransportError(f"{self._joint_states} has not reported where the {name} is")

    def stop(self) -> None:
        """Send every part to its present place. A part without a recent reading comes to rest by itself."""
        ros, now = self._ros or self._join(), time.monotonic()
        robot_time = self._readings.robot_time(now)
        stamp = stamp_of(robot_time) if robot_time else ros.node.get_clock().now().to_msg()
        for name, part in self._parts.items():
            reading = self._readings.angles(JOINTS[name])
            # With an old reading, the part would move back to where it was.
            part.stop(
                reading[1] if reading is not None and now - reading[0] < GUARDIAN_FRESH_S else None, stamp
            )

    @override
    def close(self) -> None:
        if self._ros is not None:
            self._ros.close()
            self._ros = None

    def reset(self) -> None:
        """Stay on the network, which is slow to join: DDS finds subscribers again by itself."""

    def _join(self) -> Ros2Node:
        require_packages(*messages.PACKAGES)
        from sensor_msgs.msg import JointState

        # Without shared memory: a frozen servo program may hold its locks.
        ros = Ros2Node(f"{GUARDIAN}{time.time_ns() % 10**9}", shared_memory=False)
        for name, drive in self._drives.items():
            limit = np.full(len(JOINTS[name]), np.inf)
            self._parts[name] = DrivenPart(ros.node, drive, JOINTS[name], -limit, limit)
        ros.node.create_subscription(JointState, self._joint_states, self._on_joint_state, 1)
        ros.start()
        self._ros = ros
        return ros

    def _on_joint_state(self, message: Any) -> None:
        try:
            self._readings.take(message, time.monotonic())
        except RemoteProtocolError:
            return  # the servo program logs it
