"""`grabbergui experiment`: one GigE camera on both networks and in the window, and both robots with it."""

from __future__ import annotations

import argparse
import math
import re
import socket
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from grabbergui.cli.arguments import ipv4, wait_time
from grabbergui.cli.gui import add_theme
from grabbergui.cli.name_servers import named_server
from grabbergui.cli.process import EndRequest, stop_on_signals
from grabbergui.core.errors import GrabberError, UsageError
from grabbergui.core.visible_text import print_line
from grabbergui.servo.cli.child_command import ChildCommand

if TYPE_CHECKING:
    from grabbergui.net.yarp.os.name_client import NameClient
    from grabbergui.servo.robots.teo_ports import TeoPorts
    from grabbergui.servo.robots.tiago_topics import TiagoTopics

_ROBOTS = ("teo", "tiago")
_YARP, _ROS2, _TEO = "/grabber", "/camera", "/teoSim"
_READY_S = 30.0
"Seconds that a command has to become ready."
_REACH_S = 90.0
"Seconds that a robot has to reach the marker, unless --seconds says otherwise."
_WAIT_S = 0.05
_TRIES = 3
"A computer that is busy makes a robot stop by itself: its images come too late, or its joints."
_FPS = 20.0
"The camera's frame rate in Hz: it, its readers and the robots are on one computer."
_REACHED = re.compile(r" *([\d.]+) s  reached")
"The line of `servo` when the marker is reached."
_STOPPED = re.compile(r" *([\d.]+) s  stopped: (.*)")
"Its line when something stopped the robot, which nobody is there to let move again."


def add_commands(commands: Any) -> None:
    """Add the parser."""
    parser = commands.add_parser(
        "experiment",
        help="the original's demonstration in one command: a camera, two networks, two robots",
        description="Simulates a GigE Vision camera and the robots, serves the camera on YARP and ROS 2, "
        "shows the window that tunes it, and lets each robot in turn, with the camera on its head, look at a "
        "person and reach for a marker. Closing the window or Ctrl-C ends everything; with --headless the "
        "command ends when all robots have reached the marker, with exit code 1 if one has not.",
        example="grabbergui experiment --headless",
    )
    parser.add_argument(
        "--robots",
        type=_robots,
        default=_ROBOTS,
        metavar="teo,tiago",
        help="the robots that get the camera, in this order (teo,tiago)",
    )
    parser.add_argument("--headless", action="store_true", help="no window")
    parser.add_argument(
        "--seconds",
        type=wait_time,
        default=_REACH_S,
        metavar="S",
        help=f"seconds for each robot ({_REACH_S:g})",
    )
    parser.add_argument(
        "--address", type=ipv4, default="127.0.0.1", help="where the GigE camera answers (127.0.0.1)"
    )
    parser.add_argument(
        "--nameserver",
        default="127.0.0.1:10000",
        metavar="HOST:PORT",
        help="the YARP name server, which is run if none answers there (127.0.0.1:10000)",
    )
    add_theme(parser)
    parser.set_defaults(run=_run)


def _robots(text: str) -> tuple[str, ...]:
    names = tuple(text.split(","))
    if not set(names) <= set(_ROBOTS) or len(set(names)) < len(names):
        raise argparse.ArgumentTypeError(f"'{text}' names no robots; write teo, tiago or both with a comma")
    return names


def _run(options: argparse.Namespace) -> int:
    from grabbergui.net.ros2.requirements import require_packages
    from grabbergui.servo.robots.tiago_messages import PACKAGES

    require_packages(*PACKAGES)  # before a window opens
    with stop_on_signals() as stop, ExitStack() as stack:
        names = stack.enter_context(
            named_server(options.nameserver, ours=not _somebody_answers(options.nameserver))
        )
        laboratory = _Laboratory(options, names, stack)
        camera = _served(options, names, stack)
        if not _until(lambda: camera.printed("serving "), _READY_S, stop, "the camera's server"):
            return 0
        ends = _Ends(stop, camera)
        reached = [
            _reach(name, laboratory, partial(_servo, name, options, names), ends) for name in options.robots
        ]
        if not options.headless and not ends:
            print_line("the camera stays on both networks until its window is closed", flush=True)
            while not ends.wait():
                pass
        if camera.code:
            return camera.code
    return 0 if all(reached) or not options.headless or stop.is_set() else 1


@dataclass
class _Ends:
    """Whether the user wants to end: by a signal, or by closing the camera's window."""

    stop: EndRequest
    camera: ChildCommand

    def __bool__(self) -> bool:
        return self.stop.is_set() or self.camera.code is not None

    def wait(self) -> bool:
        """Return the same after a moment."""
        self.stop.wait(_WAIT_S)
        return bool(self)


def _reach(
    name: str, laboratory: _Laboratory, servo: Callable[[ExitStack], ChildCommand], ends: _Ends
) -> bool:
    """Let a robot reach the marker; return whether it has. Does nothing once the user wants to end."""
    for _ in range(_TRIES):
        with laboratory.robot_with_camera(name), ExitStack() as stack:
            if ends:
                return False
            command = servo(stack)
            while command.code is None and not ends.wait():
                if any(map(_STOPPED.match, command.lines)):
                    break
            command.end()
            if ends or laboratory.report(name, command.lines):
                return not ends
    return False


class _Laboratory:
    """The simulated robots, and one GigE camera, which is on the head of the one that is on its network."""

    def __init__(self, options: argparse.Namespace, names: NameClient, stack: ExitStack) -> None:
        """Everything ends with the stack. Raises GrabberError if something cannot be simulated."""
        from grabbergui.core.scheduling import single_threaded
        from grabbergui.servo import closed_loop
        from grabbergui.servo.config import Config
        from grabbergui.servo.robots.simulated import SimRobot

        single_threaded()
        self._config = Config()
        models = {name: _model(name) for name in options.robots}
        self._robots = {name: SimRobot(model) for name, model in models.items()}
        for robot in self._robots.values():
            stack.callback(robot.close)
        self._carrier = self._robots[options.robots[0]]
        things = closed_loop.things_for(self._config.marker)
        camera = closed_loop.gige_camera(
            options.address, things, lambda now: self._carrier.camera_at(now), _FPS
        )
        stack.callback(camera.close)
        self._names = names

    @contextmanager
    def robot_with_camera(self, name: str) -> Iterator[None]:
        """Put the camera on a robot's head, and the robot on its network within the block."""
        self._carrier = robot = self._robots[name]
        ports: TeoPorts | TiagoTopics
        if name == "teo":
            from grabbergui.net.yarp.os.values import Dialect
            from grabbergui.servo.robots.teo_ports import TeoPorts

            ports = TeoPorts(robot, self._names, _TEO, Dialect("3.x"))
        else:
            from grabbergui.servo.robots.tiago_topics import TiagoTopics

            ports = TiagoTopics(robot)
        ports.open()
        with closing(ports):
            yield

    def report(self, name: str, lines: Sequence[str]) -> bool:
        """Print what a robot's run came to by the lines of `servo`; return whether it reached the marker."""
        from grabbergui.calibration import geometry
        from grabbergui.driver.sim.rendered_scene import board_pose
        from grabbergui.servo import closed_loop
        from grabbergui.servo.control import ArmController

        found = next(filter(None, map(_REACHED.match, lines)), None)
        if found is None:
            stopped = next(filter(None, map(_STOPPED.match, lines)), None)
            reason = f"; it was stopped: {stopped[2]}" if stopped else ""
            print_line(f"{name} has not reached the marker{reason}", flush=True)
            return False
        robot, config = self._robots[name], self._config
        goal = ArmController(config.arm, config.marker.standoff).goal(
            closed_loop.in_base(robot, board_pose())
        )
        hand = robot.truth().hand
        degrees = math.degrees(geometry.angle_between(hand, goal))
        print_line(
            f"{name} has reached the marker after {float(found[1]):.1f} s, "
            f"{1e3 * geometry.distance(hand, goal):.1f} mm and {degrees:.1f}° from the goal",
            flush=True,
        )
        return True


def _model(name: str) -> Any:
    if name == "teo":
        from grabbergui.servo.robots import teo

        return teo.MODEL
    from grabbergui.servo.robots import tiago

    return tiago.model(None)


def _served(options: argparse.Namespace, names: NameClient, stack: ExitStack) -> ChildCommand:
    """Return the command that serves and shows the camera."""
    from grabbergui.calibration import camera_info
    from grabbergui.servo import closed_loop
    from grabbergui.servo.robots.tiago_ros2 import Topics

    # A copy: set_camera_info writes to it.
    calibration = Path(stack.enter_context(tempfile.TemporaryDirectory())) / "camera_info.yaml"
    camera_info.save(closed_loop.calibration(), calibration)
    shown = [] if options.headless else ["--window"]
    arguments = [
        *("serve", f"gige:{options.address}", "--yarp", _YARP, "--nameserver", _place(names), *shown),
        *("--ros2", _ROS2, "--frame-id", Topics().camera_frame, "--calibration", str(calibration)),
    ]
    command = ChildCommand("camera", arguments)
    stack.callback(command.end)
    return command


def _servo(name: str, options: argparse.Namespace, names: NameClient, stack: ExitStack) -> ChildCommand:
    """Return the command that lets a robot follow and reach, until the stack ends."""
    ends = ["--headless", "--no-keyboard", "--until-reached", "--seconds", f"{options.seconds:g}"]
    if name == "teo":
        server = _place(names)
        place = ["--remote", _TEO, "--source", f"yarp:{_YARP}?nameserver={server}", "--nameserver", server]
        place += ["--calibration", "teo-sim-camera.yaml", "--publish"]
    else:
        place = ["--source", f"ros2:{_ROS2}", "--publish-ros2"]
    command = ChildCommand(name, ["servo", "--robot", name, *place, *ends])
    stack.callback(command.end)
    return command


def _place(names: NameClient) -> str:
    return f"{names.server.host}:{names.server.port}"


def _somebody_answers(address: str) -> bool:
    host, _, port = address.rpartition(":")
    if not host or not port.isdecimal() or int(port) > 0xFFFF:
        raise UsageError(f"--nameserver {address}: write HOST:PORT")
    try:
        with socket.create_connection((host, int(port)), 1.0):
            return True
    except OSError:
        return False


def _until(condition: Callable[[], bool], seconds: float, stop: EndRequest, what: str) -> bool:
    """Wait; return False if the user wants to end. Raises GrabberError after `seconds`."""
    deadline = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > deadline:
            raise GrabberError(f"{what} was not ready within {seconds:g} s")
        if stop.wait(_WAIT_S):
            return False
    return True
