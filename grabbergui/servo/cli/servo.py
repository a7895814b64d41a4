"""`grabbergui servo`: let a robot look at people and reach for a marker, guided by its camera."""

from __future__ import annotations

import argparse
import logging
import os
import select
import statistics
import sys
import threading
import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from grabbergui.cli.arguments import part, positive, wait_time
from grabbergui.cli.gui import add_theme, importing_window
from grabbergui.cli.process import stop_on_signals
from grabbergui.core.environment import find_file
from grabbergui.core.errors import UsageError
from grabbergui.core.visible_text import print_line
from grabbergui.servo.cli import servo_robots

if TYPE_CHECKING:
    from grabbergui.calibration.calibration_choice import CalibrationFor
    from grabbergui.core.frame import Frame
    from grabbergui.servo.config import Config, MarkerConfig
    from grabbergui.servo.loop import ControlCycle
    from grabbergui.servo.report import RunRecorder
    from grabbergui.servo.runner import Runner

log = logging.getLogger(__name__)

EXIT_NOT_REACHED = 1
KEYBOARD_PERIOD = 0.1
"Seconds between checks of the keyboard, and of a request to end."
_KEYS = "Enter stops the robot, r resumes, q ends"
_NO_KEYS = "the keyboard does not stop the robot: standard input is not used, or no terminal"


def add_commands(commands: Any) -> None:
    """Add the parsers of this family."""
    parser = commands.add_parser(
        "servo",
        help="let a robot look at people and reach for a marker, guided by its camera",
        description="During the run, Enter is the emergency stop, r resumes, and q ends the program. With "
        "--headless or --seconds, the exit code is 1 if the marker was not reached.",
        example="grabbergui servo --robot sim-teo --headless --seconds 40 --report out",
    )
    servo_robots.add_arguments(parser)
    servo_robots.add_publishing(parser)
    parser.add_argument(
        "--hand-eye",
        type=Path,
        metavar="FILE",
        help="the camera's pose on the robot, as written by `hand-eye`",
    )
    parser.add_argument("--headless", action="store_true", help="no window; print the states in the terminal")
    parser.add_argument("--seconds", type=wait_time, metavar="S", help="end after this many seconds")
    parser.add_argument(
        "--until-reached", action="store_true", help="with --headless: end when the marker is reached"
    )
    parser.add_argument(
        "--screenshot", type=Path, metavar="FILE", help="save a screenshot of the window after --seconds"
    )
    add_theme(parser)
    parser.add_argument(
        "--no-keyboard",
        action="store_true",
        help="with --headless: run without the emergency stop on the keyboard, as in a pipe or a service",
    )
    parser.add_argument("--report", type=Path, metavar="FOLDER", help="write report.json, plots and a video")
    parser.add_argument("--config", type=Path, metavar="FILE", help="rates, gains and limits (.ini)")
    add_target(parser)
    parser.add_argument(
        "--faces", metavar="DETECTOR", help="auto, cascade, or the path of a YuNet model, .onnx (auto)"
    )
    parser.add_argument(
        "--steps",
        action="store_true",
        help="move the head by relative steps and the arm by poses just ahead, which end by themselves",
    )
    parser.add_argument(
        "--speed",
        type=part,
        metavar="0.3",
        help="slow all motion down, 0.01 to 1; can be changed in the window",
    )
    parser.add_argument(
        "--follow",
        type=positive,
        metavar="M/S",
        help="follow a moving marker at up to this speed in m/s, instead of waiting until it rests",
    )
    parser.add_argument(
        "--dry-run", action="store_true", help="compute and show everything, but send the robot nothing"
    )
    parser.set_defaults(run=_run)


def add_target(parser: argparse.ArgumentParser) -> None:
    """Add the options of the marker or the board."""
    group = parser.add_argument_group("the arm's goal")
    group.add_argument(
        "--target", choices=("single", "grid", "charuco"), help="one marker, or a board of markers (single)"
    )
    group.add_argument(
        "--marker", type=int, metavar="ID", help="id of the marker (20), or first id of the board (0)"
    )
    group.add_argument(
        "--dictionary",
        metavar="NAME",
        help="dictionary of the markers (4X4_50); AprilTags: tag36h11, tag25h9, tag16h5",
    )
    group.add_argument("--size", type=float, metavar="M", help="edge of a marker's black square (0.10)")
    group.add_argument(
        "--columns", type=int, help="number of markers of a grid, or squares of a ChArUco board, in a row (4)"
    )
    group.add_argument("--rows", type=int, help="number of rows (3)")
    group.add_argument(
        "--pitch",
        type=float,
        metavar="M",
        help="distance between markers, or edge of a square (1.25 times the size)",
    )


def _marker(options: argparse.Namespace, marker: MarkerConfig) -> MarkerConfig:
    given = {"kind": options.target, "dictionary": options.dictionary, "size": options.size}
    given |= {"columns": options.columns, "rows": options.rows, "pitch": options.pitch}
    kind = options.target or marker.kind
    given["id" if kind == "single" else "first"] = options.marker
    return replace(marker, **{key: value for key, value in given.items() if value is not None})


def configuration(options: argparse.Namespace) -> Config:
    """Return the settings of a file, overridden by options. Raises UsageError."""
    from grabbergui.servo.config import Config

    config = Config.load(find_file(options.config, "configuration")) if options.config else Config()
    marker = _marker(options, config.marker)
    head = replace(config.head, mode="steps") if options.steps else config.head
    arm = replace(config.arm, mode="direct") if options.steps else config.arm
    faces = replace(config.faces, detector=options.faces) if options.faces else config.faces
    loop = config.loop if options.speed is None else replace(config.loop, speed=options.speed)
    arm = arm if options.follow is None else replace(arm, follow=options.follow)
    return replace(config, loop=loop, marker=marker, head=head, arm=arm, faces=faces)


def _run(options: argparse.Namespace) -> int:
    from grabbergui.core.scheduling import single_threaded
    from grabbergui.servo import closed_loop
    from grabbergui.servo.detection import Detector
    from grabbergui.servo.runner import Runner

    if options.screenshot is not None and (options.seconds is None or options.headless):
        raise UsageError("--screenshot needs the window and --seconds, after which it is taken")
    _check_stop(options)
    config = configuration(options)
    single_threaded()
    with ExitStack() as stack:
        scene = servo_robots.assemble(options, config, stack)
        if options.hand_eye is not None:
            servo_robots.place_camera(scene.robot, find_file(options.hand_eye, "hand–eye calibration"))

        def detector(frame: Frame) -> Detector:
            return closed_loop.detector(config, scene.calibration(frame.width, frame.height), real_time=True)

        if scene.guardian is not None:
            scene.guardian.await_ready()
        runner = Runner(scene.grabber, scene.robot, detector, config, scene.guardian, dry_run=options.dry_run)
        servo_robots.publish(runner, options, stack)
        with stop_on_signals() as stop:
            return _follow(runner, options, scene, stop)


def _follow(
    runner: Runner, options: argparse.Namespace, scene: servo_robots.RobotScene, stop: threading.Event
) -> int:
    """Run until the time is up, the loop ends, or the user ends it."""
    from grabbergui.servo.motion import limits_text
    from grabbergui.servo.report import RunRecorder
    from grabbergui.servo.runner import HELD

    recorder: RunRecorder | None = RunRecorder(options.report, scene.calibration) if options.report else None
    outcome = _Outcome()

    def turned(cycle: ControlCycle, frame: Frame | None) -> None:
        outcome.note(cycle)
        if recorder is not None:
            recorder.add(cycle, frame, runner.loop.sighting)

    window = None if options.headless else _window(options, stop, scene, runner)
    runner.cycle_done.connect(turned)
    runner.failed.connect(outcome.fail)
    try:
        # Without a window, the command itself lets the robot move.
        runner.start(held=HELD if window is not None and scene.real else "")
        began = time.monotonic()
        print_line(limits_text(scene.robot.model, runner.config), flush=True)
        if options.headless:
            print_line(_NO_KEYS if options.no_keyboard or not _at_terminal() else _KEYS, flush=True)

        def over() -> bool:
            timed_out = options.seconds is not None and time.monotonic() - began >= options.seconds
            done = outcome.unread or (options.until_reached and outcome.reached)
            return not runner.running or timed_out or done

        if window is not None:
            outcome.failure = window(runner, scene.calibration) or outcome.failure
        while options.headless and not over():
            if stop.is_set():
                runner.emergency_stop("interrupted")
                break
            if options.no_keyboard:
                stop.wait(KEYBOARD_PERIOD)
            elif _typed(KEYBOARD_PERIOD, runner, stop) == "q":
                break
        facts = {**_timing(runner), **(scene.truth() if scene.truth else {})}
    finally:
        runner.stop()  # whatever happens, before the robot and its guardian are closed
    if recorder is not None:
        report = recorder.finish(facts)
        print_line(f"report in {options.report}: {'reached' if report['reached'] else 'not reached'}")
    for name, value in facts.items():
        if value is not None:
            print_line(f"{name.replace('_', ' ')}: {value:.4g}")
    if outcome.failure:
        print_line(f"grabbergui: {outcome.failure}", error=True)
    # A window that was watched for as long as its user wanted has done all that it was for.
    wanted = outcome.reached or (window is not None and options.seconds is None)
    return 0 if wanted and not outcome.failure else EXIT_NOT_REACHED


def _window(
    options: argparse.Namespace, stop: threading.Event, scene: servo_robots.RobotScene, runner: Runner
) -> Callable[[Runner, CalibrationFor], str]:
    with importing_window("or add --headless"):
        from grabbergui.servo.ui.servo_process import servo_in_own_process
        from grabbergui.ui.theme import Theme
    return partial(
        servo_in_own_process,
        seconds=options.seconds,
        screenshot=options.screenshot,
        theme=Theme(options.theme),
        stop=stop,
        stand=servo_robots.hand_eye_stand(scene, runner.gate, runner.config, options, options.hand_eye),
    )


class _Outcome:
    """Print the events of a run as they happen."""

    def __init__(self) -> None:
        self.reached = self.unread = False
        "Whether the marker was reached, and whether the reader of our output is gone."
        self.failure = ""
        self._state: Any = None

    def note(self, cycle: ControlCycle) -> None:
        """Print a change of state."""
        if cycle.state is not self._state:
            self._state = cycle.state
            self.reached |= cycle.state.name == "REACHED"
            self._print(f"{cycle.elapsed:7.2f} s  {cycle.state.value}: {cycle.reason}")
        if cycle.state.name != "STOPPED":
            self.failure = ""  # of an earlier loop: the user has started another

    def _print(self, text: str) -> None:
        try:
            print_line(text, flush=True)
        except BrokenPipeError:
            self.unread = True
        except OSError as error:  # a full disk, for instance, must not end the run
            log.debug("not printed: %s", error)

    def fail(self, reason: str) -> None:
        """Remember why the loop ended, or did not let the robot move."""
        self.failure = reason


def _check_stop(options: argparse.Namespace) -> None:
    """Raise UsageError if a real robot would move without a window, a keyboard or a network to stop it."""
    real = options.robot in ("teo", "tiago") and not options.dry_run
    other = options.no_keyboard or options.publish or options.publish_ros2
    if real and options.headless and not other and not _at_terminal():
        raise UsageError(
            "standard input is no terminal, so Enter could not stop the robot: run this in a terminal, add "
            "--publish or --publish-ros2 to stop it over a network, or --no-keyboard to go without"
        )


def _at_terminal() -> bool:
    """Return whether the keyboard is ours: a background job that reads it is frozen (SIGTTIN)."""
    if not sys.stdin or not sys.stdin.isatty():
        return False
    return sys.platform == "win32" or os.tcgetpgrp(sys.stdin.fileno()) == os.getpgrp()


def _typed(seconds: float, runner: Runner, stop: threading.Event) -> str:
    """Wait a moment for a line from the keyboard, and act on it."""
    if not _at_terminal():
        stop.wait(seconds)
        return ""
    if not select.select([sys.stdin], [], [], seconds)[0]:
        return ""
    line = sys.stdin.readline().strip().lower()
    if line == "":
        runner.emergency_stop("stopped from the keyboard")
    elif line == "r":
        # On a thread of its own, as a guardian that must start again would hold up the next stop.
        threading.Thread(target=_resume, args=(runner, runner.gate.stops), daemon=True).start()
    return line


def _resume(runner: Runner, stops: int) -> None:
    if why_not := runner.resume(stops):
        print_line(f"still stopped: {why_not}", flush=True)


def _timing(runner: Runner) -> dict[str, float | None]:
    return {
        "images": runner.images,
        "detection_ms_median": statistics.median(runner.detection_ms) if runner.detection_ms else None,
        "photon_to_command_ms_median": statistics.median(runner.latency_ms) if runner.latency_ms else None,
        "commands_sent": runner.gate.sent,
        "commands_refused": runner.gate.refused,
    }
