"""`grabbergui calibrate` and `grabbergui hand-eye`: where a camera looks, and where on a robot it sits."""

from __future__ import annotations

import argparse
import math
import os
import threading
import time
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

from grabbergui.cli import servo, servo_robots
from grabbergui.cli.arguments import count, opened, part, wait_time
from grabbergui.cli.gui import add_theme, importing_window
from grabbergui.cli.process import stop_on_signals
from grabbergui.core.environment import check_folder_of
from grabbergui.core.errors import CalibrationError, FrameTimeoutError, GrabberError, UsageError
from grabbergui.core.visible_text import print_line

if TYPE_CHECKING:
    from grabbergui.calibration.boards import BoardSettings
    from grabbergui.calibration.collector import Collector
    from grabbergui.calibration.hand_eye import HandEyeResult
    from grabbergui.calibration.hand_eye_file import CameraMount
    from grabbergui.core.identity import DeviceInfo
    from grabbergui.servo.config import Config
    from grabbergui.servo.gate import CommandGate
    from grabbergui.servo.hand_eye_run import Progress

REMIND = 5.0
"Seconds without a new view after which the reason is printed."


def add_commands(commands: Any) -> None:
    """Add the parsers of this family."""
    _add_calibrate(commands)
    _add_hand_eye(commands)


def _add_calibrate(commands: Any) -> None:
    parser = commands.add_parser(
        "calibrate",
        help="calibrate a camera with a printed board; writes a camera_info file",
        description="Hold the board still in many places: near, far, in every corner of the image, tilted.",
        example="grabbergui calibrate gige: --window --out camera.yaml",
    )
    parser.add_argument("source", metavar="SOURCE", nargs="?", help="the camera; sim:board to try it")
    parser.add_argument(
        "--window", action="store_true", help="open a window that shows the views still missing"
    )
    parser.add_argument(
        "--screenshot", type=Path, metavar="FILE", help="save a screenshot of the window after --seconds"
    )
    add_theme(parser)
    parser.add_argument(
        "--print", type=Path, metavar="FILE", dest="sheet", help="only save the board, as .pdf or .png"
    )
    parser.add_argument(
        "--board", choices=("charuco", "chessboard"), default="charuco", help="pattern on the board (charuco)"
    )
    parser.add_argument("--columns", type=int, default=8, help="squares in a row (8)")
    parser.add_argument("--rows", type=int, default=6, help="rows of squares (6)")
    parser.add_argument(
        "--square", type=float, default=0.03, metavar="M", help="edge of a square in metres (0.03)"
    )
    parser.add_argument(
        "--marker", type=float, default=0.022, metavar="M", help="edge of a marker in metres (0.022)"
    )
    parser.add_argument(
        "--dictionary", default="5X5_100", metavar="NAME", help="dictionary of the markers (5X5_100)"
    )
    parser.add_argument("--views", type=count, default=20, help="number of different views (20)")
    parser.add_argument(
        "--seconds", type=wait_time, default=180.0, metavar="S", help="give up after S seconds (180)"
    )
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("camera.yaml"),
        metavar="FILE",
        help="the file to write (camera.yaml)",
    )
    parser.add_argument("--name", default="camera", help="the camera's name in the file (camera)")
    parser.set_defaults(run=_calibrate)


def settings(options: argparse.Namespace) -> BoardSettings:
    """Return the board that was chosen."""
    from grabbergui.calibration.boards import BoardSettings

    return BoardSettings(
        options.board, options.columns, options.rows, options.square, options.marker, options.dictionary
    )


def _calibrate(options: argparse.Namespace) -> int:
    from grabbergui.calibration import camera_info, printed_sheet
    from grabbergui.calibration.collector import Collector

    board = settings(options).board()
    if options.sheet is not None:
        try:
            sheet = printed_sheet.save(board, options.sheet)
        except OSError as fault:
            raise GrabberError(f"{options.sheet} could not be written: {fault.strerror or fault}") from fault
        print_line(f"saved as {options.sheet}; print it on {sheet.paper} at 100 %, and measure the rule")
        return 0
    if not options.source:
        raise UsageError("calibrate which camera? Name a SOURCE, or --print FILE to print the board only")
    if options.window or options.screenshot:
        return _calibrate_in_window(options)
    _check_writable(options.out)
    collector = Collector(board, options.views, still=True)
    camera = _collect(collector, options)
    result = collector.solve(options.name)
    for number, error in enumerate(result.errors, 1):
        print_line(f"view {number:3}: {'left out' if math.isnan(error) else f'{error:.3f} px'}")
    matrix, spread = result.calibration.matrix, result.uncertainty
    print_line(f"focal lengths {matrix[0, 0]:.1f} ± {spread[0]:.1f}, {matrix[1, 1]:.1f} ± {spread[1]:.1f} px")
    print_line(f"centre {matrix[0, 2]:.1f} ± {spread[2]:.1f}, {matrix[1, 2]:.1f} ± {spread[3]:.1f} px")
    print_line(f"error {result.rms:.3f} px, coverage {100 * collector.coverage.part:.0f} %")
    camera_info.save(result.calibration.made_with(camera), options.out)
    print_line(f"saved as {options.out}")
    return 0


def _check_writable(path: Path) -> None:
    """Raise UsageError if the result could not be written, before minutes are spent on it."""
    check_folder_of(path)
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        raise UsageError(f"{path} could not be written; choose another --out")


def _calibrate_in_window(options: argparse.Namespace) -> int:
    """Calibrate in a window, which asks where to save. Raises CalibrationError if nothing was saved."""
    with importing_window("or leave out --window"):
        from grabbergui.ui.run import standalone
        from grabbergui.ui.theme import Theme
    seconds = options.seconds if options.screenshot else None
    theme = Theme(options.theme)
    with opened(options.source) as grabber, stop_on_signals() as stop:
        grabber.start()
        saved = standalone.calibrate(grabber, settings(options), options.screenshot, seconds, theme, stop)
    if saved is not None:
        print_line(f"saved as {saved}")
    elif seconds is None and not stop.is_set():
        raise CalibrationError("the window was closed, and no calibration saved")
    return 0


def _collect(collector: Collector, options: argparse.Namespace) -> DeviceInfo:
    """Collect views from the source until there are enough, or the time is up; return the camera."""
    from grabbergui.calibration.collector import ViewVerdict
    from grabbergui.calibration.frame_geometry import GeometryReader

    wrong = "--columns, --rows" + (" and --dictionary" if options.board == "charuco" else "")
    waiting = {
        ViewVerdict.NOT_SEEN: "no board is seen: bring all of it into the image, lit and in focus, "
        f"and check {wrong}",
        ViewVerdict.MOVING: "the board moves: hold it still for a moment",
        ViewVerdict.KNOWN: "this view is known: hold the board elsewhere, nearer, farther or tilted",
    }
    with opened(options.source) as grabber:
        queue = grabber.open_queue(1)
        geometries = GeometryReader(grabber)
        grabber.start()
        print_line(
            f"show the {options.board} board ({options.columns}×{options.rows} squares of "
            f"{options.square:g} m) to {grabber.info.title} and hold it still; "
            f"different views wanted: {collector.wanted}, within {options.seconds:g} s",
            flush=True,
        )
        said = time.monotonic()
        deadline = said + options.seconds
        seen = False
        try:
            while not collector.complete and time.monotonic() < deadline:
                frame = queue.get(min(5.0, max(0.1, deadline - time.monotonic())))
                if not frame.complete:
                    continue
                verdict, now = collector.look(frame.mono(), geometry=geometries.of(frame)), time.monotonic()
                seen |= verdict is not ViewVerdict.NOT_SEEN
                if verdict is ViewVerdict.KEPT:
                    hint = collector.coverage.missing()
                    said = now
                    print_line(
                        f"view {len(collector.views)} of {collector.wanted}, "
                        f"coverage {100 * collector.coverage.part:.0f} %"
                        f"{f'; next, hold it {hint}' if hint else ''}",
                        flush=True,
                    )
                elif now - said > REMIND:
                    said = now
                    print_line(f"{waiting[verdict]}; {max(0, deadline - now):.0f} s are left", flush=True)
        except FrameTimeoutError:
            if time.monotonic() < deadline:
                raise
        finally:
            queue.close()
            geometries.close()
            grabber.stop()
    if not seen:
        raise CalibrationError(
            f"no {options.board} board of {options.columns}×{options.rows} squares was seen; "
            f"check {wrong}, and the image in the window"
        )
    return grabber.info


def _add_hand_eye(commands: Any) -> None:
    parser = commands.add_parser(
        "hand-eye",
        help="find the pose of a robot's camera: the robot moves and looks at a board",
        description="Without --window the robot moves as soon as it is connected; Ctrl-C stops it.",
        example="grabbergui hand-eye --robot sim-teo --eye head --target charuco --out teo.hand-eye.yaml",
    )
    parser.add_argument(
        "--eye",
        choices=("head", "hand", "fixed"),
        default="head",
        help="the camera is on the head or the hand and the board is fixed, or the camera is fixed and the "
        "hand holds the board (head)",
    )
    parser.add_argument("--views", type=count, default=20, help="number of poses (20)")
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("robot.hand-eye.yaml"),
        metavar="FILE",
        help="the file to write, for `servo --hand-eye` (robot.hand-eye.yaml)",
    )
    parser.add_argument(
        "--mount-frame", metavar="FRAME", help="frame in tf of the part that the camera is mounted on"
    )
    parser.add_argument(
        "--publish-ros2",
        action="store_true",
        help="publish the result on /tf_static until Ctrl-C",
    )
    parser.add_argument("--window", action="store_true", help="open a window; nothing moves before you agree")
    add_theme(parser)
    parser.add_argument("--config", type=Path, metavar="FILE", help="limits, workspace and obstacles (.ini)")
    parser.add_argument("--speed", type=part, metavar="0.3", help="slow all motion down, 0.01 to 1")
    servo.add_target(parser)
    servo_robots.add_arguments(parser)
    parser.set_defaults(run=_hand_eye, headless=True, dry_run=False, steps=False, faces=None, follow=None)


def _hand_eye(options: argparse.Namespace) -> int:
    from grabbergui.calibration import hand_eye_file
    from grabbergui.servo.gate import CommandGate
    from grabbergui.servo.hand_eye_run import HandEyeRun, watched
    from grabbergui.servo.hand_eye_stand import TargetWatch

    options.headless = not options.window
    _check_writable(options.out)
    config = servo.configuration(options)
    with ExitStack() as stack, stop_on_signals() as stop:
        scene = servo_robots.assemble(options, config, stack)
        if scene.guardian is not None:
            scene.guardian.await_ready()
        gate = CommandGate(scene.robot, config, scene.guardian)
        if options.window:
            _hand_eye_in_window(scene, gate, config, options, stop)
            return 0
        look = TargetWatch(scene.grabber, config.marker, scene.calibration)
        stack.callback(look.close)
        stack.enter_context(watched(gate))
        run = HandEyeRun(
            options.eye, scene.robot, gate, look, look.calibration, config, report=_Report().add,
            pause=lambda seconds: _pause(seconds, stop, gate),
        )  # fmt: skip
        result = run.run(options.views)
        placement = servo_robots.placement(options)
        _print_hand_eye(result, placement)  # first: saving may fail, on a full disk for instance
        hand_eye_file.save(result, options.out, placement)
        print_line(f"saved as {options.out}", flush=True)
        if options.publish_ros2:
            _publish(result, placement, stop)
    return 0


def _hand_eye_in_window(
    scene: servo_robots.Scene,
    gate: CommandGate,
    config: Config,
    options: argparse.Namespace,
    stop: threading.Event,
) -> None:
    """Calibrate in a window, which asks where to save. Raises CalibrationError if there is no result."""
    with importing_window("or leave out --window"):
        from grabbergui.ui.run import standalone
        from grabbergui.ui.theme import Theme
    gate.hold("nothing moves before a person agrees")
    stand = servo_robots.hand_eye_stand(scene, gate, config, options, options.out)
    try:
        if standalone.hand_eye(stand, theme=Theme(options.theme), stop=stop) is None:
            raise CalibrationError("the window was closed before there was a result")
    finally:
        stand.close()


def _pause(seconds: float, stop: threading.Event, gate: CommandGate) -> None:
    if stop.wait(seconds):
        gate.halt("interrupted")


class _Report:
    """Prints the outcomes of a run."""

    def __init__(self) -> None:
        self._began = time.monotonic()

    def add(self, progress: Progress) -> None:
        """Print one event, unless it is the beginning of a move."""
        from grabbergui.servo.hand_eye_run import Step

        if progress.step is not Step.MOVING:
            print_line(f"{time.monotonic() - self._began:7.2f} s  {progress.text}", flush=True)


def _print_hand_eye(result: HandEyeResult, placement: CameraMount) -> None:
    from grabbergui.calibration import hand_eye_file

    used = sum(not math.isnan(error) for error in result.errors)
    metres, radians = result.uncertainty
    x, y, z = 1e3 * result.camera[:3, 3]
    print_line(f"{used} of {len(result.errors)} views used, error {result.rms:.3f} px")
    print_line(f"camera on {placement.mount}: {x:.1f} {y:.1f} {z:.1f} mm")
    print_line(f"known to {1e3 * metres:.2f} mm and {math.degrees(radians):.3f}° (standard deviations)")
    for name, offsets in (("camera", result.camera_offsets), ("target", result.target_offsets)):
        if offsets.any():
            degrees = " ".join(f"{math.degrees(offset):+.2f}" for offset in offsets)
            print_line(f"offsets of the joints that carry the {name}: {degrees}°")
    print_line(hand_eye_file.static_transform_command(result, placement), flush=True)


def _publish(result: HandEyeResult, placement: CameraMount, stop: threading.Event) -> None:
    from grabbergui.net.ros2.camera_pose import StaticFrame

    frame = StaticFrame(placement.mount, placement.frame, placement.on_mount(result.camera))
    frame.open()
    try:
        print_line("on /tf_static until Ctrl-C", flush=True)
        stop.wait()
    finally:
        frame.close()
