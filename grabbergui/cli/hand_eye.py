"""`grabbergui hand-eye`: a robot moves by itself and finds where its camera sits."""

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
from grabbergui.cli.gui import add_theme, importing_window
from grabbergui.cli.parsing import count, part
from grabbergui.cli.process import stop_on_signals
from grabbergui.core.errors import UsageError

if TYPE_CHECKING:
    from grabbergui.calibration.hand_eye import HandEyeResult
    from grabbergui.calibration.hand_eye_file import Placement
    from grabbergui.servo.config import Config
    from grabbergui.servo.gate import CommandGate
    from grabbergui.servo.hand_eye_progress import Progress
    from grabbergui.servo.hand_eye_run import HandEyeRun


def add_commands(commands: Any) -> None:
    """Add the parsers of this family."""
    parser = commands.add_parser(
        "hand-eye",
        help="find where a robot's camera sits: the robot moves and looks at a board",
        description="Without --window the robot moves as soon as it is there; Ctrl-C stops it.",
        example="grabbergui hand-eye --robot sim-teo --eye head --target charuco --out teo.hand-eye.yaml",
    )
    parser.add_argument(
        "--eye",
        choices=("head", "hand", "fixed"),
        default="head",
        help="the camera is on the head or the hand and the board is fixed, or the camera is fixed and the "
        "hand holds the board (head)",
    )
    parser.add_argument("--views", type=count, default=20, help="from how many poses (20)")
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("robot.hand-eye.yaml"),
        metavar="FILE",
        help="the result, for `servo --hand-eye` (robot.hand-eye.yaml)",
    )
    parser.add_argument("--mount-frame", metavar="FRAME", help="tf's name of what the camera is mounted on")
    parser.add_argument(
        "--publish-ros2",
        action="store_true",
        help="then publish it on /tf_static until Ctrl-C",
    )
    parser.add_argument(
        "--window", action="store_true", help="with a window: nothing moves before a person agrees"
    )
    add_theme(parser)
    parser.add_argument("--config", type=Path, metavar="FILE", help="limits, workspace and obstacles (.ini)")
    parser.add_argument("--speed", type=part, metavar="0.3", help="slow all motion down, 0.01 to 1")
    servo.add_target(parser)
    servo_robots.add_arguments(parser)
    parser.set_defaults(run=_run, headless=True, dry_run=False, steps=False, faces=None, follow=None)


def _run(options: argparse.Namespace) -> int:
    from grabbergui.calibration import hand_eye_file
    from grabbergui.servo.gate import CommandGate
    from grabbergui.servo.hand_eye_run import HandEyeRun, watched
    from grabbergui.servo.hand_eye_stand import TargetWatch

    options.headless = not options.window
    folder = options.out.resolve().parent
    if not folder.is_dir() or not os.access(options.out if options.out.exists() else folder, os.W_OK):
        raise UsageError(f"the result could not be written to {options.out}; choose another --out")
    config = servo.configuration(options)
    with ExitStack() as stack, stop_on_signals() as stop:
        scene = servo_robots.assemble(options, config, stack)
        if scene.guardian is not None:
            scene.guardian.await_ready()
        gate = CommandGate(scene.robot, config, scene.guardian)
        if options.window:
            return _show(scene, gate, config, options, stop)
        look = TargetWatch(scene.grabber, config.marker, scene.calibration)
        stack.callback(look.close)
        stack.enter_context(watched(gate))
        run = HandEyeRun(
            options.eye, scene.robot, gate, look, look.calibration, config, report=_Report().add,
            pause=lambda seconds: _pause(seconds, stop, run),
        )  # fmt: skip
        result = run.run(options.views)
        placement = servo_robots.placement(options)
        _print(result, placement)  # first: the file may be refused, by a full disk for instance
        hand_eye_file.save(result, options.out, placement)
        print(f"saved as {options.out}", flush=True)
        if options.publish_ros2:
            _publish(result, placement, stop)
    return 0


def _show(
    scene: servo_robots.Scene,
    gate: CommandGate,
    config: Config,
    options: argparse.Namespace,
    stop: threading.Event,
) -> int:
    """Calibrate in a window; return the exit code, 1 without a result."""
    with importing_window("or leave out --window"):
        from grabbergui.ui.run import standalone
        from grabbergui.ui.theme import Theme
    gate.halt("nothing moves before a person agrees")
    stand = servo_robots.hand_eye_stand(scene, gate, config, options, options.out)
    try:
        return int(standalone.hand_eye(stand, theme=Theme(options.theme), stop=stop) is None)
    finally:
        stand.close()


def _pause(seconds: float, stop: threading.Event, run: HandEyeRun) -> None:
    if stop.wait(seconds):
        run.cancel()


class _Report:
    """Prints the outcomes of a run."""

    def __init__(self) -> None:
        self._began = time.monotonic()

    def add(self, progress: Progress) -> None:
        """Print one event, unless it is the beginning of a move."""
        from grabbergui.servo.hand_eye_progress import Step

        if progress.step is not Step.MOVING:
            print(f"{time.monotonic() - self._began:7.2f} s  {progress.text}", flush=True)


def _print(result: HandEyeResult, placement: Placement) -> None:
    from grabbergui.calibration import hand_eye_file

    used = sum(not math.isnan(error) for error in result.errors)
    metres, radians = result.uncertainty
    x, y, z = 1e3 * result.camera[:3, 3]
    print(f"{used} of {len(result.errors)} views used, error {result.rms:.3f} px")
    print(f"camera on {placement.mount}: {x:.1f} {y:.1f} {z:.1f} mm")
    print(f"known to {1e3 * metres:.2f} mm and {math.degrees(radians):.3f}° (standard deviations)")
    for name, offsets in (("camera", result.camera_offsets), ("target", result.target_offsets)):
        if offsets.any():
            degrees = " ".join(f"{math.degrees(offset):+.2f}" for offset in offsets)
            print(f"offsets of the joints that carry the {name}: {degrees}°")
    print(hand_eye_file.static_transform_command(result, placement), flush=True)


def _publish(result: HandEyeResult, placement: Placement, stop: threading.Event) -> None:
    from grabbergui.servo.ros2 import StaticFrame

    frame = StaticFrame(placement.mount, placement.frame, placement.on_mount(result.camera))
    frame.open()
    try:
        print("on /tf_static until Ctrl-C", flush=True)
        stop.wait()
    finally:
        frame.close()
