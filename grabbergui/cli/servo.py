"""`grabbergui servo`: a robot's head follows what the camera sees, its arm reaches for a marker."""

from __future__ import annotations

import argparse
import math
import select
import statistics
import sys
import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from grabbergui.cli import calibrate, simulate_teo
from grabbergui.core.calibration import NOMINAL_FIELD_OF_VIEW, Calibration
from grabbergui.core.errors import SourceUnavailableError, UsageError

if TYPE_CHECKING:
    from grabbergui.core.frame import Frame
    from grabbergui.core.grabber import FrameGrabber
    from grabbergui.servo.config import Config
    from grabbergui.servo.loop import Turn
    from grabbergui.servo.pilot import Pilot
    from grabbergui.servo.report import Recorder
    from grabbergui.servo.robots.robot import Robot

CalibrationFor = Callable[[int, int], Calibration]
"Width and height of pictures to their calibration."

_BOARD_SHOWN_S = 4.0
"Seconds after which the simulated person shows the marker, so that the waiting can be seen."
EXIT_NOT_REACHED = 1


def add_commands(commands: Any) -> None:
    """Add the parsers of this family: servoing, the calibration that it needs, a robot to try it on."""
    calibrate.add_commands(commands)
    simulate_teo.add_commands(commands)
    parser = commands.add_parser(
        "servo",
        help="a robot's head follows what the camera sees, its arm reaches for a marker",
        description="While it runs: Enter is the emergency stop, r resumes, q ends.",
    )
    parser.add_argument(
        "--robot",
        choices=("sim-teo", "teo"),
        default="sim-teo",
        help="sim-teo: simulated in this process (default); teo: on YARP",
    )
    parser.add_argument("--remote", default="/teoSim", metavar="/PREFIX", help="teo's ports (/teoSim)")
    parser.add_argument("--nameserver", default="", metavar="HOST:PORT", help="(YARP's configuration)")
    parser.add_argument("--source", metavar="SOURCE", help="the camera; by default that of a simulated robot")
    parser.add_argument(
        "--publish",
        nargs="?",
        const="/grabbergui/servo",
        metavar="/PREFIX",
        help="on YARP: heads, markers and state, and a stop at PREFIX/rpc:s",
    )
    parser.add_argument("--headless", action="store_true", help="no window: the state goes to the terminal")
    parser.add_argument("--seconds", type=float, metavar="S", help="end after so long")
    parser.add_argument("--report", type=Path, metavar="FOLDER", help="write report.json, plots and a video")
    parser.add_argument("--config", type=Path, metavar="FILE", help="rates, gains and limits (.ini)")
    parser.add_argument("--marker", type=int, metavar="ID", help="the marker's id (20)")
    parser.add_argument("--dictionary", metavar="NAME", help="the marker's dictionary (4X4_50)")
    parser.add_argument("--size", type=float, metavar="M", help="edge of the marker's black square (0.10)")
    parser.add_argument("--steps", action="store_true", help="move the head by relative steps")
    _add_calibration(parser)
    parser.set_defaults(run=_run)


def _add_calibration(parser: argparse.ArgumentParser) -> None:
    group = parser.add_mutually_exclusive_group()
    group.add_argument("--calibration", type=Path, metavar="FILE", help="camera_info YAML of the camera")
    group.add_argument(
        "--field-of-view",
        type=float,
        metavar="DEGREES",
        help="do without a calibration: what the picture's width sees; distances are then rough",
    )


def _config(options: argparse.Namespace) -> Config:
    from grabbergui.servo.config import Config

    config = Config.load(options.config) if options.config else Config()
    given = {"id": options.marker, "dictionary": options.dictionary, "size": options.size}
    marker = replace(config.marker, **{key: value for key, value in given.items() if value is not None})
    head = replace(config.head, mode="steps") if options.steps else config.head
    return replace(config, marker=marker, head=head)


def _run(options: argparse.Namespace) -> int:
    from grabbergui.servo import desk
    from grabbergui.servo.detection import Detector
    from grabbergui.servo.pilot import Pilot

    if options.seconds is not None and not (math.isfinite(options.seconds) and options.seconds > 0):
        raise UsageError(f"--seconds {options.seconds:g}: it must be more than 0")
    config = _config(options)
    with ExitStack() as stack:
        robot, grabber, calibration, truth = _parts(options, config, stack)

        def detector(frame: Frame) -> Detector:
            return desk.detector(config, calibration(frame.width, frame.height))

        pilot = Pilot(grabber, robot, detector, config)
        if options.publish:
            _publish(pilot, options, stack)
        return _follow(pilot, options, calibration, truth)


def _parts(
    options: argparse.Namespace, config: Config, stack: ExitStack
) -> tuple[Robot, FrameGrabber, CalibrationFor, Any]:
    """Robot and camera, opened, the camera's calibration, and what is true where all is simulated."""
    from grabbergui.cli.opening import opened
    from grabbergui.driver.sim.rendered import scene as rendered_scene
    from grabbergui.driver.sim.rendered.scene import Things
    from grabbergui.servo import desk, geometry
    from grabbergui.servo.control import ArmController
    from grabbergui.servo.robots import teo
    from grabbergui.servo.robots.simulated import SimRobot

    if options.robot == "teo":
        return *_on_yarp(options, stack), None
    robot = SimRobot(teo.BODY)
    robot.open()
    stack.callback(robot.close)
    if options.source:
        grabber = stack.enter_context(opened(options.source))
        return robot, grabber, _calibration(options), None
    board = rendered_scene.board_pose()
    things = desk.things_for(
        config.marker, Things(board=lambda seconds: board if seconds >= _BOARD_SHOWN_S else None)
    )
    grabber = desk.mounted_camera(robot, things)
    grabber.open()
    stack.callback(grabber.close)
    given = options.calibration is not None or options.field_of_view is not None
    goal = ArmController(config.arm, config.marker.standoff).goal(board)

    def truth() -> dict[str, float]:
        hand = robot.state().hand
        return {
            "true_error_mm": 1e3 * geometry.distance(hand, goal),
            "true_error_degrees": math.degrees(geometry.angle_between(hand, goal)),
            "limit_violations": robot.limit_violations,
        }

    return robot, grabber, _calibration(options) if given else desk.calibration().scaled_to, truth


def _on_yarp(options: argparse.Namespace, stack: ExitStack) -> tuple[Robot, FrameGrabber, CalibrationFor]:
    """TEO on a YARP network and its camera, both opened."""
    from grabbergui.cli.opening import opened
    from grabbergui.net.yarp.os.name_client import NameClient
    from grabbergui.servo.robots.teo_yarp import TeoOverYarp

    server = f"?nameserver={options.nameserver}" if options.nameserver else ""
    options.source = options.source or f"yarp:{options.remote}/camera{server}"
    calibration = _calibration(options)
    robot = TeoOverYarp(NameClient.find(options.nameserver), options.remote)
    robot.open()
    stack.callback(robot.close)
    return robot, stack.enter_context(opened(options.source)), calibration


def _publish(pilot: Pilot, options: argparse.Namespace, stack: ExitStack) -> None:
    from grabbergui.net.yarp.os.name_client import NameClient
    from grabbergui.net.yarp.os.names import check_port_name
    from grabbergui.servo.publisher_yarp import YarpPublisher

    names = NameClient.find(options.nameserver)
    publisher = YarpPublisher(pilot, names, check_port_name(options.publish))
    publisher.open()
    stack.callback(publisher.close)


def _calibration(options: argparse.Namespace) -> CalibrationFor:
    """The one given, for pictures of any size that fits it. Raises UsageError with the ways out of none."""
    if options.calibration is not None:
        return Calibration.load(options.calibration).scaled_to
    if options.field_of_view is not None:
        return partial(Calibration.from_field_of_view, degrees=options.field_of_view)
    raise UsageError(
        f"{options.source} is not calibrated: run `grabbergui calibrate {options.source}` and pass its file "
        f"as --calibration FILE, or do roughly with --field-of-view {NOMINAL_FIELD_OF_VIEW:g}"
    )


def _follow(
    pilot: Pilot, options: argparse.Namespace, calibration: CalibrationFor, truth: Any
) -> int:
    """Run to the end: of the time, of the loop, or by the user's wish."""
    from grabbergui.servo.report import Recorder

    recorder: Recorder | None = Recorder(options.report, calibration) if options.report else None
    outcome = _Outcome()

    def turned(turn: Turn, frame: Frame | None) -> None:
        outcome.note(turn)
        if recorder is not None:
            recorder.add(turn, frame, pilot.loop.sighting)

    window = None if options.headless else _window()
    pilot.turned.connect(turned)
    pilot.failed.connect(outcome.fail)
    pilot.start()
    began = time.monotonic()
    try:
        if window is not None:
            window(pilot, calibration, options.seconds)
        while (
            options.headless
            and pilot.running
            and (options.seconds is None or time.monotonic() - began < options.seconds)
        ):
            if _typed(0.1, pilot) == "q":
                break
    except KeyboardInterrupt:
        pilot.emergency_stop("interrupted")
    facts = {**_timing(pilot), **(truth() if truth else {})}
    pilot.stop()
    if recorder is not None:
        report = recorder.finish(facts)
        print(f"report in {options.report}: {'reached' if report['reached'] else 'not reached'}")
    for name, value in facts.items():
        if value is not None:
            print(f"{name.replace('_', ' ')}: {value:.4g}")
    if outcome.failure:
        print(f"grabbergui: {outcome.failure}", file=sys.stderr)
    return 0 if outcome.reached and not outcome.failure else EXIT_NOT_REACHED


def _window() -> Any:
    try:
        from grabbergui.ui.views import servo_run
    except ImportError as error:
        raise SourceUnavailableError(f"the window needs PyQt5, or add --headless: {error}") from error
    return servo_run.run


class _Outcome:
    """What happened, told as it happens."""

    def __init__(self) -> None:
        self.reached = False
        self.failure = ""
        self._state: Any = None
        self._start: float | None = None

    def note(self, turn: Turn) -> None:
        """Print a change of state."""
        self._start = turn.time if self._start is None else self._start
        if turn.state is not self._state:
            self._state = turn.state
            self.reached |= turn.state.name == "REACHED"
            print(f"{turn.time - self._start:7.2f} s  {turn.state.value}: {turn.reason}", flush=True)

    def fail(self, reason: str) -> None:
        """Remember why the loop ended."""
        self.failure = reason


def _typed(seconds: float, pilot: Pilot) -> str:
    """Wait a moment for a line from the keyboard, and act on it."""
    if not sys.stdin or not sys.stdin.isatty():
        time.sleep(seconds)
        return ""
    if not select.select([sys.stdin], [], [], seconds)[0]:
        return ""
    line = sys.stdin.readline().strip().lower()
    if line == "":
        pilot.emergency_stop("stopped from the keyboard")
    elif line == "r":
        pilot.resume()
    return line


def _timing(pilot: Pilot) -> dict[str, float | None]:
    return {
        "pictures": len(pilot.detection_ms),
        "detection_ms_median": statistics.median(pilot.detection_ms) if pilot.detection_ms else None,
        "photon_to_command_ms_median": statistics.median(pilot.latency_ms) if pilot.latency_ms else None,
        "commands_sent": pilot.gate.sent,
        "commands_refused": pilot.gate.refused,
    }
