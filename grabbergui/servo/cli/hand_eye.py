"""`grabbergui hand-eye`: where on a robot a camera sits."""

from __future__ import annotations

import argparse
import math
import threading
import time
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

from grabbergui.cli.arguments import count, part
from grabbergui.cli.calibrate import check_writable
from grabbergui.cli.gui import add_theme, importing_window
from grabbergui.cli.process import stop_on_signals
from grabbergui.core.errors import CalibrationError
from grabbergui.core.visible_text import print_line
from grabbergui.servo.cli import servo, servo_robots

if TYPE_CHECKING:
    from grabbergui.servo.config import Config
    from grabbergui.servo.gate import CommandGate
    from grabbergui.servo.hand_eye.hand_eye_file import CameraMount
    from grabbergui.servo.hand_eye.run import Progress
    from grabbergui.servo.hand_eye.solver import HandEyeResult


def add_commands(commands: Any) -> None:
    """Add the parser of the command."""
    parser = commands.add_parser(
        "hand-eye",
        help="find the pose of a robot's camera: the robot moves and looks at a board",
        description="Without --window the robot moves as soon as it is connected; Ctrl-C stops it.",
        example="grabbergui hand-eye --robot sim-teo --target charuco --columns 5 --rows 4 --size 0.03",
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
    from grabbergui.servo.gate import CommandGate
    from grabbergui.servo.hand_eye import hand_eye_file
    from grabbergui.servo.hand_eye.run import HandEyeRun, watched
    from grabbergui.servo.hand_eye.stand import TargetWatch

    options.headless = not options.window
    check_writable(options.out)
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
            options.eye, scene.robot, gate, look, look.calibration, config, report=_ProgressPrinter().add,
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
    scene: servo_robots.RobotScene,
    gate: CommandGate,
    config: Config,
    options: argparse.Namespace,
    stop: threading.Event,
) -> None:
    """Calibrate in a window, which asks where to save. Raises CalibrationError if there is no result."""
    with importing_window("or leave out --window"):
        from grabbergui.servo.ui import windows
        from grabbergui.ui.theme import Theme
    gate.hold("nothing moves before a person agrees")
    stand = servo_robots.hand_eye_stand(scene, gate, config, options, options.out)
    try:
        if windows.hand_eye(stand, theme=Theme(options.theme), stop=stop) is None:
            raise CalibrationError("the window was closed before there was a result")
    finally:
        stand.close()


def _pause(seconds: float, stop: threading.Event, gate: CommandGate) -> None:
    if stop.wait(seconds):
        gate.halt("interrupted")


class _ProgressPrinter:
    """Prints the outcomes of a run."""

    def __init__(self) -> None:
        self._began = time.monotonic()

    def add(self, progress: Progress) -> None:
        """Print one event, unless it is the beginning of a move."""
        from grabbergui.servo.hand_eye.run import Step

        if progress.step is not Step.MOVING:
            print_line(f"{time.monotonic() - self._began:7.2f} s  {progress.text}", flush=True)


def _print_hand_eye(result: HandEyeResult, placement: CameraMount) -> None:
    from grabbergui.servo.hand_eye import hand_eye_file

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
