"""`grabbergui simulate-tiago`: the simulated TIAGo and its camera on ROS 2, for any client of them."""

from __future__ import annotations

import argparse
import tempfile
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from grabbergui.cli import servo_robots
from grabbergui.cli.stopping import stop_on_signals
from grabbergui.core.errors import UsageError


def add_commands(commands: Any) -> None:
    """Add the parsers of this family."""
    parser = commands.add_parser(
        "simulate-tiago",
        help="serve a simulated TIAGo on ROS 2: controllers of head and arm, and the camera on its head",
        description="Controllers, /joint_states and the camera as nodes, until Ctrl-C.",
    )
    parser.add_argument("--ros2", default="/camera", metavar="/NAME", help="the camera's node (/camera)")
    parser.add_argument("--fps", type=float, default=30.0, help="pictures per second (30)")
    servo_robots.add_tiago(parser)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    from grabbergui.calibration import camera_info
    from grabbergui.calibration.fitted import FittedCalibration
    from grabbergui.net.ros2.server import Ros2GrabberServer
    from grabbergui.servo import desk
    from grabbergui.servo.config import MarkerConfig
    from grabbergui.servo.robots.simulated import SimRobot
    from grabbergui.servo.robots.tiago_topics import TiagoTopics

    if not 1 <= options.fps <= 100:
        raise UsageError(f"--fps {options.fps:g}: allowed is 1 to 100")
    with ExitStack() as stack, stop_on_signals() as stop:
        robot = SimRobot(servo_robots.tiago_body(options))
        stack.callback(robot.close)
        camera = desk.mounted_camera(robot, desk.things_for(MarkerConfig()), options.fps)
        camera.open()
        stack.callback(camera.close)
        topics = servo_robots.tiago_topics(options)
        # A file of its own: whoever calls set_camera_info writes to it.
        calibration = Path(stack.enter_context(tempfile.TemporaryDirectory())) / "camera_info.yaml"
        camera_info.save(desk.calibration(), calibration)
        pictures = Ros2GrabberServer(
            camera,
            options.ros2,
            frame_id=topics.camera_frame,
            calibration=FittedCalibration(camera, calibration),
        )
        pictures.start()
        stack.callback(pictures.stop)
        controllers = TiagoTopics(robot, topics)
        controllers.open()
        stack.callback(controllers.close)
        print(f"TIAGo listens to {topics.head} and {topics.arm}; its camera is {options.ros2}", flush=True)
        stop.wait()
    return 0
