"""Simulated robots on YARP and ROS 2 whose encoders can fail during motion.

The process that owns one simulates the robot and acts as an operator on its network.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Any

from typing_extensions import override

from benchmarks._network_runs import on_this_machine_only
from benchmarks.servo.servo_guardian import Tireless, undisturbed
from grabbergui.calibration.geometry import Vector
from grabbergui.net.yarp.os.bottle import Bottle
from grabbergui.net.yarp.os.name_client import NameClient
from grabbergui.net.yarp.os.name_server import NameServer
from grabbergui.net.yarp.os.rpc_client import RpcClient
from grabbergui.net.yarp.os.values import Vocab
from grabbergui.servo.cli.servo_robots import ROS2_PREFIX, YARP_PREFIX
from grabbergui.servo.robots import teo, tiago
from grabbergui.servo.robots.robot import RobotState
from grabbergui.servo.robots.teo_ports import TeoPorts

TEO_CAMERA, TIAGO_CAMERA, NAME_SERVER = "127.19.3.1", "127.19.3.2", "127.19.3.3"
PATIENCE = 60.0
"Seconds that the program has for an answer."


class FallibleRobot(Tireless):
    """A robot that keeps moving when its encoders fail."""

    silent = False
    "Whether no readings are sent."
    repeated: RobotState | None = None
    "The reading that is sent from now on, wherever the joints are."

    @override
    def state(self) -> RobotState:
        return self.repeated or super().state()

    def place(self) -> Vector:
        """Return the true position of the hand, metres."""
        return super().state().hand[:3, 3]

    def repair(self) -> None:
        """Send true readings again."""
        self.silent, self.repeated = False, None


class FallibleTeo(TeoPorts):
    """A TEO that sends no readings while its robot is silent."""

    def __init__(self, robot: FallibleRobot, names: NameClient) -> None:
        super().__init__(robot, names)
        self._fallible = robot

    @override
    def _step(self) -> None:
        if not self._fallible.silent:
            super()._step()


@dataclass(frozen=True)
class Stand:
    """A robot on its network."""

    robot: FallibleRobot
    options: list[str]
    "Command-line options with which the program finds the robot."
    camera: str
    "Address for the robot's camera."
    ask_to_stop: Callable[[], None]
    "Asks the program over the robot's network to stop, and awaits its answer."


@contextmanager
def teo_on_yarp() -> Iterator[Stand]:
    with ExitStack() as stack:
        server = NameServer(NAME_SERVER, 0)
        server.open()
        stack.callback(server.close)
        names, robot = NameClient(server.contact), FallibleRobot(teo.MODEL)
        client = stack.enter_context(RpcClient(f"{YARP_PREFIX}/rpc:s", names))
        stack.enter_context(undisturbed())
        ports = FallibleTeo(robot, names)
        ports.open()
        stack.callback(ports.close)
        place = f"{server.contact.host}:{server.contact.port}"

        def ask_to_stop() -> None:
            if client.call(Bottle(["stop"]), PATIENCE) != [Vocab("ok")]:
                raise RuntimeError(f"{client.target} does not stop")

        yield Stand(
            robot,
            ["--robot", "teo", "--nameserver", place, "--publish", YARP_PREFIX],
            TEO_CAMERA,
            ask_to_stop,
        )


@contextmanager
def tiago_on_ros2(*, stock: bool = False) -> Iterator[Stand]:
    on_this_machine_only()
    from std_srvs.srv import Trigger

    from grabbergui.net.ros2.runtime import Ros2Node
    from grabbergui.servo.robots.tiago_topics import TiagoTopics

    robot = FallibleRobot(tiago.model())

    class FallibleTiago(TiagoTopics):
        @override
        def _publish_state(self) -> None:
            if not robot.silent:
                super()._publish_state()

    with ExitStack() as stack:
        stack.enter_context(undisturbed())
        topics = FallibleTiago(robot, stock=stock)
        stack.callback(topics.close)
        topics.open()
        operator = Ros2Node("operator")
        stack.callback(operator.close)
        client: Any = operator.node.create_client(Trigger, f"{ROS2_PREFIX}/stop")
        operator.start()

        def ask_to_stop() -> None:
            answered = threading.Event()
            if not client.wait_for_service(PATIENCE):
                raise TimeoutError(f"nobody serves {ROS2_PREFIX}/stop")
            client.call_async(Trigger.Request()).add_done_callback(lambda _: answered.set())
            if not answered.wait(PATIENCE):
                raise TimeoutError(f"{ROS2_PREFIX}/stop does not answer")

        yield Stand(robot, ["--robot", "tiago", "--publish-ros2", ROS2_PREFIX], TIAGO_CAMERA, ask_to_stop)
