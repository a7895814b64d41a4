"""Options of `grabbergui servo`: the robot, the camera, and the networks that they are published on."""

from __future__ import annotations

import argparse
import math
import tempfile
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from grabbergui.cli.arguments import opened
from grabbergui.cli.gui import importing_window
from grabbergui.cli.process import stop_on_signals
from grabbergui.core.environment import find_file
from grabbergui.core.errors import UsageError
from grabbergui.core.visible_text import print_line

if TYPE_CHECKING:
    from grabbergui.calibration.calibration_choice import CalibrationFor
    from grabbergui.core.grabber import FrameGrabber
    from grabbergui.servo.config import Config
    from grabbergui.servo.gate import CommandGate
    from grabbergui.servo.guardian_link import GuardianLink
    from grabbergui.servo.hand_eye.hand_eye_file import CameraMount
    from grabbergui.servo.hand_eye.simulated_cameras import SimulatedCameras
    from grabbergui.servo.hand_eye.stand import HandEyeStand
    from grabbergui.servo.robots.robot import KinematicModel, Robot
    from grabbergui.servo.robots.tiago_ros2 import Topics
    from grabbergui.servo.runner import Runner

Truth = Callable[[], dict[str, float]]
"The true state in a simulation, for the report."

BOARD_SHOWN_S = 4.0
"Seconds after which the simulated person shows the marker, so that the waiting can be seen."

YARP_PREFIX = ROS2_PREFIX = "/grabbergui/servo"


@dataclass(frozen=True)
class RobotScene:
    """An opened robot and camera."""

    robot: Robot
    grabber: FrameGrabber
    calibration: CalibrationFor
    truth: Truth | None = None
    real: bool = False
    "Whether something may move in the real world: the window then waits for Start."
    guardian: GuardianLink | None = None
    "The guardian of a robot that would continue to move if this program died; starting."
    cameras: SimulatedCameras | None = None
    "Moves the camera of a simulated robot to the place of a hand–eye calibration; None for other robots."


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the robot and its camera."""
    parser.add_argument(
        "--robot",
        choices=tuple(_ROBOTS),
        default="sim-teo",
        help="sim-teo (default) and sim-tiago are simulated in this process; teo is on YARP, tiago on ROS 2",
    )
    parser.add_argument("--source", metavar="SOURCE", help="the camera (the one on the robot's head)")
    yarp = parser.add_argument_group("YARP")
    yarp.add_argument(
        "--remote", default="/teoSim", metavar="/PREFIX", help="prefix of TEO's ports (/teoSim)"
    )
    yarp.add_argument(
        "--nameserver", default="", metavar="HOST:PORT", help="the YARP name server (YARP's configuration)"
    )
    add_tiago(parser)
    group = parser.add_mutually_exclusive_group()
    group.add_argument("--calibration", type=Path, metavar="FILE", help="camera_info YAML of the camera")
    group.add_argument(
        "--field-of-view",
        type=float,
        metavar="DEGREES",
        help="horizontal field of view instead of a calibration; distances are then rough",
    )


def add_publishing(parser: argparse.ArgumentParser) -> None:
    """Add the options of the networks on which the loop publishes."""
    for option, network, prefix in (
        ("--publish", "YARP", YARP_PREFIX),
        ("--publish-ros2", "ROS 2", ROS2_PREFIX),
    ):
        parser.add_argument(
            option,
            nargs="?",
            const=prefix,
            metavar="/PREFIX",
            help=f"publish heads, markers and state on {network}, and accept a stop ({prefix})",
        )


def add_tiago(parser: argparse.ArgumentParser) -> None:
    """Add the options of a TIAGo, real or simulated: its URDF and frames, and its controllers' topics."""
    group = parser.add_argument_group("TIAGo on ROS 2")
    group.add_argument("--urdf", type=Path, metavar="FILE", help="the robot's URDF (from /robot_description)")
    group.add_argument(
        "--hand-frame", metavar="FRAME", help="frame of the end effector (hand_grasping_frame)"
    )
    group.add_argument("--camera-frame", metavar="FRAME", help="frame of the camera (that of camera_info)")
    group.add_argument(
        "--arm-topic", metavar="/TOPIC", help="topic of the hand's twists (/servo_node/delta_twist_cmds)"
    )
    group.add_argument(
        "--head-topic",
        metavar="/TOPIC",
        help="topic of the head's trajectories (/head_controller/joint_trajectory)",
    )


def assemble(options: argparse.Namespace, config: Config, stack: ExitStack) -> RobotScene:
    """Open robot and camera; `stack` closes them. Raises GrabberError."""
    return _ROBOTS[options.robot](options, config, stack)


def publish(runner: Runner, options: argparse.Namespace, stack: ExitStack) -> None:
    """Publish what the loop sees and does, and take stops from the networks, until `stack` closes."""
    if options.publish:
        from grabbergui.net.yarp.os.name_client import NameClient
        from grabbergui.net.yarp.os.target import check_port_name
        from grabbergui.servo.yarp_publisher import YarpPublisher

        ports = YarpPublisher(runner, NameClient.find(options.nameserver), check_port_name(options.publish))
        ports.open()
        stack.callback(ports.close)
    if options.publish_ros2:
        from grabbergui.servo.ros2_publisher import Ros2Publisher

        topics = Ros2Publisher(runner, options.publish_ros2, options.camera_frame or "camera")
        topics.open()
        stack.callback(topics.close)


def place_camera(robot: Robot, file: Path) -> None:
    """Use the camera's pose from a hand–eye calibration. Raises UsageError, OSError."""
    from grabbergui.servo.hand_eye import hand_eye_file
    from grabbergui.servo.robots.robot import CameraPlace

    result, placement = hand_eye_file.load(file), hand_eye_file.placement(file)
    if placement is not None and placement.eye != "head":
        raise UsageError(
            f"{file} is of a camera that {'is on the hand' if placement.eye == 'hand' else 'stands'}; "
            "servoing needs one on the head"
        )
    if result.camera_offsets.shape != robot.model.head.low.shape:
        raise UsageError(f"{file} is of another robot: it has offsets of {len(result.camera_offsets)} joints")
    robot.placed = CameraPlace(result.camera, result.camera_offsets)


def placement(options: argparse.Namespace) -> CameraMount:
    """Return the mount of the camera, with tf's names as far as they are known."""
    from grabbergui.calibration.geometry import pose
    from grabbergui.servo.hand_eye import hand_eye_file

    eye, turned = options.eye, pose()
    mount = {"head": "head", "hand": "hand", "fixed": "base"}[eye]
    if options.robot.endswith("tiago"):
        from grabbergui.servo.robots import tiago

        mount = {"head": tiago.HEAD, "hand": options.hand_frame or tiago.HAND, "fixed": tiago.BASE}[eye]
        if eye == "hand":
            turned = pose(tiago.HAND_AXES)
    return hand_eye_file.CameraMount(
        eye, options.mount_frame or mount, options.camera_frame or "camera", turned
    )


def hand_eye_stand(
    scene: RobotScene, gate: CommandGate, config: Config, options: argparse.Namespace, file: Path | None
) -> HandEyeStand:
    """Return what the window needs to calibrate hand and eye; `file` is the robot's."""
    from grabbergui.servo.hand_eye.run import VIEWS
    from grabbergui.servo.hand_eye.stand import HandEyeStand

    def place(eye: str) -> CameraMount:
        return placement(argparse.Namespace(**{"mount_frame": None, **vars(options), "eye": eye}))

    cameras = scene.cameras
    return HandEyeStand(
        scene.robot,
        gate,
        config,
        cameras if cameras is not None else lambda eye, marker: scene.grabber,
        scene.calibration,
        place,
        getattr(options, "eye", "head"),
        getattr(options, "views", VIEWS),
        file,
        cameras.close if cameras is not None else lambda: None,
    )


def tiago_model(options: argparse.Namespace) -> KinematicModel:
    """Return a TIAGo with these options. Raises SourceUnavailableError."""
    from grabbergui.servo.robots import tiago

    return tiago.model(options.urdf, options.hand_frame or "", options.camera_frame or "")


def tiago_topics(options: argparse.Namespace) -> Topics:
    """Return the topics of TIAGo's controllers with these options. Raises UsageError."""
    from grabbergui.net.ros2.runtime import full_name
    from grabbergui.servo.robots.tiago_ros2 import Topics

    given = {"arm": options.arm_topic, "head": options.head_topic}
    topics = {key: full_name(topic, f"--{key}-topic {topic}") for key, topic in given.items() if topic}
    frame = {"camera_frame": options.camera_frame} if options.camera_frame else {}
    return Topics(**topics, **frame)


def _sim_teo(options: argparse.Namespace, config: Config, stack: ExitStack) -> RobotScene:
    from grabbergui.servo.robots import teo

    return _simulated(teo.MODEL, options, config, stack)


def _sim_tiago(options: argparse.Namespace, config: Config, stack: ExitStack) -> RobotScene:
    return _simulated(tiago_model(options), options, config, stack)


def _simulated(
    model: KinematicModel, options: argparse.Namespace, config: Config, stack: ExitStack
) -> RobotScene:
    from grabbergui.calibration import geometry
    from grabbergui.driver.sim import rendered_scene
    from grabbergui.driver.sim.rendered_scene import Things
    from grabbergui.servo import closed_loop
    from grabbergui.servo.control import ArmController
    from grabbergui.servo.hand_eye.simulated_cameras import SimulatedCameras
    from grabbergui.servo.robots.simulated import SimRobot

    eye = getattr(options, "eye", "")
    robot = SimRobot(model, head=closed_loop.AT_BOARD if eye == "head" else (0.0, 0.0))
    robot.open()
    stack.callback(robot.close)
    if options.source:
        grabber = stack.enter_context(opened(options.source))
        return RobotScene(robot, grabber, _calibration(options, grabber))
    if eye:
        grabber = closed_loop.hand_eye_camera(robot, config.marker, eye)
        grabber.open()
        stack.callback(grabber.close)
        return RobotScene(
            robot, grabber, closed_loop.calibration().scaled_to, cameras=SimulatedCameras(robot)
        )
    board = rendered_scene.board_pose()
    things = closed_loop.things_for(
        config.marker, Things(board=lambda seconds: board if seconds >= BOARD_SHOWN_S else None)
    )
    grabber = closed_loop.mounted_camera(robot, things)
    grabber.open()
    stack.callback(grabber.close)
    goal = ArmController(config.arm, config.marker.standoff).goal(closed_loop.in_base(robot, board))

    def truth() -> dict[str, float]:
        hand = robot.state().hand
        return {
            "true_error_mm": 1e3 * geometry.distance(hand, goal),
            "true_error_degrees": math.degrees(geometry.angle_between(hand, goal)),
            "limit_violations": robot.limit_violations,
        }

    given = options.calibration is not None or options.field_of_view is not None
    calibration = _calibration(options, grabber) if given else closed_loop.calibration().scaled_to
    return RobotScene(robot, grabber, calibration, truth, cameras=SimulatedCameras(robot))


def _teo(options: argparse.Namespace, config: Config, stack: ExitStack) -> RobotScene:
    from grabbergui.net.yarp.os.name_client import NameClient
    from grabbergui.servo.robots.teo_yarp import TeoOverYarp

    server = f"?nameserver={options.nameserver}" if options.nameserver else ""
    options.source = options.source or f"yarp:{options.remote}/camera{server}"
    grabber = stack.enter_context(opened(options.source))
    calibration = _calibration(options, grabber)
    robot = TeoOverYarp(NameClient.find(options.nameserver), options.remote, listen_only=options.dry_run)
    guardian = None if options.dry_run else _guardian(robot, config, stack)
    robot.open()
    stack.callback(robot.close)
    return RobotScene(robot, grabber, calibration, real=True, guardian=guardian)


def _tiago(options: argparse.Namespace, config: Config, stack: ExitStack) -> RobotScene:
    from grabbergui.calibration.calibration_choice import CalibrationChoice
    from grabbergui.net.ros2.image_messages import receive_camera_info
    from grabbergui.servo.robots import tiago, tiago_ros2

    source = options.source = options.source or "ros2:/camera"
    given = options.calibration is not None or options.field_of_view is not None
    received, frame = None, ""
    if not given and source.startswith("ros2:"):
        # The camera may be starting only now: this waits for it.
        received, frame = receive_camera_info(source.removeprefix("ros2:"))
    urdf = options.urdf or _described_urdf(stack)
    model = tiago.model(urdf, options.hand_frame or "", options.camera_frame or "", seen_in=frame)
    options.camera_frame = options.camera_frame or frame  # also of what is published and calibrated
    topics = tiago_topics(options)
    robot = tiago_ros2.TiagoOverRos2(model, topics, listen_only=options.dry_run)
    robot.connect()
    stack.callback(robot.close)
    print_line(robot.summary, flush=True)
    guardian = None if options.dry_run else _guardian(robot, config, stack)
    robot.open()
    grabber = stack.enter_context(opened(source))
    calibration: CalibrationFor
    if received is None:
        calibration = _calibration(options, grabber)
    else:
        calibration = CalibrationChoice.reported(grabber, received)
    return RobotScene(robot, grabber, calibration, real=True, guardian=guardian)


def _described_urdf(stack: ExitStack) -> Path | None:
    """Write the robot's `/robot_description` to a file, and return that; None if none is published."""
    from grabbergui.net.ros2.requirements import require_packages
    from grabbergui.servo.robots.tiago_messages import PACKAGES
    from grabbergui.servo.robots.tiago_nodes import receive_description

    require_packages(*PACKAGES)
    description = receive_description()
    if not description:
        return None
    path = Path(stack.enter_context(tempfile.TemporaryDirectory())) / "robot_description.urdf"
    path.write_text(description, "utf-8")
    return path


def _guardian(robot: Robot, config: Config, stack: ExitStack) -> GuardianLink:
    """Return a guardian for a robot that is not open yet: both start together, and it is closed last."""
    from grabbergui.servo.guardian_link import GuardianLink

    guardian = GuardianLink(robot.stop_channels(), config.safety.guardian_timeout, config.safety.lag)
    guardian.open()
    stack.callback(guardian.close)
    return guardian


_ROBOTS = {"sim-teo": _sim_teo, "sim-tiago": _sim_tiago, "teo": _teo, "tiago": _tiago}


def _calibration(options: argparse.Namespace, grabber: FrameGrabber) -> CalibrationFor:
    """Return the given calibration, for images of any size that fits it; with a window, the one chosen there.

    Raises UsageError with the ways out of none.
    """
    from grabbergui.calibration.calibration_choice import CalibrationChoice
    from grabbergui.core.calibration import NOMINAL_FIELD_OF_VIEW

    if options.calibration is not None:
        return CalibrationChoice.file(find_file(options.calibration, "calibration", "servo"), grabber)
    if options.field_of_view is not None:
        return CalibrationChoice.nominal(options.field_of_view)
    if not options.headless:
        with importing_window("or add --headless"):
            from grabbergui.ui.run import standalone
        grabber.start()
        with stop_on_signals() as stop:
            choice = standalone.choose_calibration(grabber, stop=stop)
            stop.check()
        if choice is not None:
            return choice
    raise UsageError(
        f"{options.source} is not calibrated: run `grabbergui calibrate {options.source}` and pass its file "
        f"as --calibration FILE, or do roughly with --field-of-view {NOMINAL_FIELD_OF_VIEW:g}"
    )
