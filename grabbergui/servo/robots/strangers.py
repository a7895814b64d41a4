"""Programs of strangers that disturb a simulated robot over its network: see `faults`.

Their first message comes when their fault begins, as from a program that somebody starts during a run.
"""

from __future__ import annotations

import logging
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any

from typing_extensions import override

from grabbergui.calibration.geometry import Vector
from grabbergui.core.errors import GrabberError
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.ports import OutputPort
from grabbergui.net.yarp.os.target import Target
from grabbergui.net.yarp.os.values import Dialect
from grabbergui.servo.robots import cartesian_messages, tiago, tiago_messages
from grabbergui.servo.robots.cartesian_messages import NOT_CONTROLLING
from grabbergui.servo.robots.faults import STRANGER_PERIOD
from grabbergui.servo.robots.joint_readings import joint_state
from grabbergui.servo.robots.robot import RobotState
from grabbergui.servo.robots.simulated import SimRobot
from grabbergui.servo.robots.tiago_messages import Drive

log = logging.getLogger(__name__)

YARP_READER = "/grabbergui/servo"
"Beginning of the names of the servo program's ports, to one of which a stranger connects."


class Stranger(ABC):
    """Sends the false readings and commands of a robot's faults, on a thread of its own while it runs."""

    def __init__(self, robot: SimRobot) -> None:
        self._robot = robot
        self._running = threading.Event()
        self._thread = threading.Thread(target=self._run, name="stranger", daemon=True)

    def start(self) -> None:
        """Begin to wait for the faults."""
        self._running.set()
        self._thread.start()

    def close(self) -> None:
        """Leave the network."""
        if self._running.is_set():
            self._running.clear()
            self._thread.join()
        self._leave()

    def _run(self) -> None:
        while self._running.is_set():
            time.sleep(STRANGER_PERIOD)
            faults, now = self._robot.faults, self._robot.truth().time
            twist, reading = faults.master_twist(now), faults.false_reading(now)
            try:
                if twist is not None:
                    self._command(twist)
                if reading is not None:
                    self._pretend(reading)
            except GrabberError as error:
                log.error("the stranger gives up: %s", error)
                return

    @abstractmethod
    def _command(self, twist: Vector) -> None:
        """Send the arm a twist in the base, m/s and rad/s. Raises GrabberError."""

    @abstractmethod
    def _pretend(self, reading: RobotState) -> None:
        """Send a reading as if it were the robot's. Raises GrabberError."""

    @abstractmethod
    def _leave(self) -> None:
        """Leave the network if it was joined."""


class YarpStranger(Stranger):
    """Ports `/stranger/command:o` and `/stranger/state:o` that connect to those of controller and program."""

    def __init__(self, robot: SimRobot, names: NameClient, controller: str, dialect: Dialect) -> None:
        """`controller` is the beginning of the names of the Cartesian controller's ports."""
        super().__init__(robot)
        self._names, self._dialect = names, dialect
        self._controller = controller
        part = controller.removeprefix("/").partition("/")[2]
        self._targets = {"command": f"{controller}/command:i", "state": f"{YARP_READER}/{part}/state:i"}
        self._ports: dict[str, OutputPort] = {}

    @override
    def _command(self, twist: Vector) -> None:
        self._port("command").write(cartesian_messages.twist(twist).encode(self._dialect))

    @override
    def _pretend(self, reading: RobotState) -> None:
        status = cartesian_messages.status(NOT_CONTROLLING, reading.hand, time.time())
        self._port("state").write(status.encode(self._dialect))

    def _port(self, kind: str) -> OutputPort:
        if kind not in self._ports:
            port = OutputPort(f"/stranger/{kind}:o", self._names)
            port.open()
            self._ports[kind] = port
            port.add(Target.parse(self._targets[kind], "fast_tcp"))
        return self._ports[kind]

    @override
    def _leave(self) -> None:
        for port in self._ports.values():
            port.close()


class Ros2Stranger(Stranger):
    """A node `stranger` that publishes joint states, and the commands that the arm's controller takes."""

    def __init__(self, robot: SimRobot, drive: Drive, joint_states: str) -> None:
        """`drive` is the arm's."""
        super().__init__(robot)
        self._drive, self._joint_states = drive, joint_states
        self._publishers: dict[str, Any] = {}
        self._ros: Any = None

    @override
    def start(self) -> None:
        """Join the network, too: it holds Python's lock for 0.3 s, in which the robot stands still."""
        from grabbergui.net.ros2.runtime import Ros2Node

        self._ros = Ros2Node("stranger")
        self._ros.start()
        super().start()

    @override
    def _command(self, twist: Vector) -> None:
        from grabbergui.servo.robots.tiago_parts import DrivenPart

        arm, angles = self._robot.model.arm, self._robot.truth().arm
        assert angles is not None
        part = self._publisher(
            "command", lambda node: DrivenPart(node, self._drive, tiago.ARM_JOINTS, arm.low, arm.high)
        )
        if not part.heard:
            return
        if self._drive.kind is tiago_messages.CommandKind.TWIST:
            part.move_hand(twist, self._ros.node.get_clock().now().to_msg())
        else:
            part.move(arm.velocities_for(angles, twist), angles, time.monotonic(), None)

    @override
    def _pretend(self, reading: RobotState) -> None:
        from sensor_msgs.msg import JointState

        publisher = self._publisher(
            "state", lambda node: node.create_publisher(JointState, self._joint_states, 5)
        )
        publisher.publish(joint_state(reading, self._ros.node.get_clock().now().to_msg()))

    def _publisher(self, kind: str, make: Callable[[Any], Any]) -> Any:
        if kind not in self._publishers:
            self._publishers[kind] = make(self._ros.node)
        return self._publishers[kind]

    @override
    def _leave(self) -> None:
        if self._ros is not None:
            self._ros.close()
            self._ros = None
