"""Simulated robots on networks: `simulate-teo` and `simulate-tiago`."""

from __future__ import annotations

import argparse
import tempfile
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

from grabbergui.cli.name_servers import add_name_server_options, named_server
from grabbergui.cli.process import stop_on_signals
from grabbergui.core.errors import UsageError
from grabbergui.core.visible_text import print_line
from grabbergui.servo.cli import servo_robots
from grabbergui.servo.robots.fault_list import DEFAULT_AFTER, FAULTS, Fault

if TYPE_CHECKING:
    from grabbergui.core.grabber import FrameGrabber
    from grabbergui.servo.robots.robot import KinematicModel
    from grabbergui.servo.robots.simulated import SimRobot


def add_commands(commands: Any) -> None:
    """Add the parsers of this family."""
    _add_teo(commands)
    _add_tiago(commands)


def _add_teo(commands: Any) -> None:
    parser = commands.add_parser(
        "simulate-teo",
        help="serve a simulated TEO on YARP: head, right arm and the camera on its head",
        description="Opens /PREFIX/head, /PREFIX/rightArm/CartesianControl and /PREFIX/camera until Ctrl-C.",
        example="grabbergui simulate-teo --with-name-server",
    )
    parser.add_argument("--name", default="/teoSim", metavar="/PREFIX", help="prefix of the ports (/teoSim)")
    add_name_server_options(parser)
    _add_scene(parser)
    parser.add_argument(
        "--yarp", choices=("3.x", "4.0"), default="3.x", help="the version of YARP to imitate (3.x)"
    )
    parser.add_argument(
        "--solver",
        choices=("tolerant", "kdl"),
        default="tolerant",
        help="how the arm follows a twist that a joint cannot follow: tolerant moves the others, which is "
        "harder for a program that keeps limits; kdl stops the arm, as BasicCartesianControl (tolerant)",
    )
    parser.set_defaults(run=_simulate_teo)


def _simulate_teo(options: argparse.Namespace) -> int:
    from grabbergui.net.yarp.os.target import check_port_name
    from grabbergui.net.yarp.os.values import Dialect
    from grabbergui.net.yarp.server import YarpGrabberServer
    from grabbergui.servo.robots import teo
    from grabbergui.servo.robots.strangers import YarpStranger
    from grabbergui.servo.robots.teo_ports import TeoPorts
    from grabbergui.servo.robots.teo_yarp import ARM

    check_port_name(options.name)
    with ExitStack() as stack, stop_on_signals() as stop:
        robot, camera = _robot_with_camera(teo.MODEL, options, stack)
        names = stack.enter_context(named_server(options.nameserver or "", ours=options.with_name_server))
        ports = TeoPorts(robot, names, options.name, Dialect(options.yarp), kdl=options.solver == "kdl")
        ports.open()
        stack.callback(ports.close)
        images = YarpGrabberServer(camera, f"{options.name}/camera", names=names)
        images.start()
        stack.callback(images.stop)
        if robot.faults.of_strangers:
            stranger = YarpStranger(robot, names, f"{options.name}{ARM}", Dialect(options.yarp))
            stranger.start()
            stack.callback(stranger.close)
        print_line(
            f"{options.name} is on the name server at {names.server.host}:{names.server.port}", flush=True
        )
        stop.wait()
    return 0


def _add_tiago(commands: Any) -> None:
    parser = commands.add_parser(
        "simulate-tiago",
        help="serve a simulated TIAGo on ROS 2: controllers of head and arm, and the camera on its head",
        description="Runs the controllers, /joint_states and the camera as nodes until Ctrl-C.",
        example="grabbergui simulate-tiago --ros2 /camera",
    )
    parser.add_argument("--ros2", default="/camera", metavar="/NAME", help="the camera's node (/camera)")
    _add_scene(parser)
    parser.add_argument(
        "--stock",
        action="store_true",
        help="give the arm a joint trajectory controller, as PAL's stock robot has, instead of twists",
    )
    servo_robots.add_tiago(parser)
    parser.set_defaults(run=_simulate_tiago)


def _simulate_tiago(options: argparse.Namespace) -> int:
    from grabbergui.calibration import camera_info
    from grabbergui.calibration.fitting import FittedCalibration
    from grabbergui.net.ros2.server import Ros2GrabberServer
    from grabbergui.servo import closed_loop
    from grabbergui.servo.robots.strangers import Ros2Stranger
    from grabbergui.servo.robots.tiago_messages import CommandKind, Drive
    from grabbergui.servo.robots.tiago_topics import TiagoTopics

    with ExitStack() as stack, stop_on_signals() as stop:
        model = servo_robots.tiago_model(options)
        robot, camera = _robot_with_camera(model, options, stack, reports_hand=False)
        topics = servo_robots.tiago_topics(options)
        # A copy: set_camera_info writes to it.
        calibration = Path(stack.enter_context(tempfile.TemporaryDirectory())) / "camera_info.yaml"
        camera_info.save(closed_loop.calibration(), calibration)
        images = Ros2GrabberServer(
            camera,
            options.ros2,
            frame_id=topics.camera_frame,
            calibration=FittedCalibration(camera, calibration),
        )
        images.start()
        stack.callback(images.stop)
        controllers = TiagoTopics(robot, topics, stock=options.stock)
        controllers.open()
        stack.callback(controllers.close)
        if robot.faults.of_strangers:
            kind = CommandKind.TRAJECTORY if options.stock else CommandKind.TWIST
            stranger = Ros2Stranger(robot, Drive(kind, controllers.arm_topic), topics.joint_states)
            stranger.start()
            stack.callback(stranger.close)
        print_line(
            f"TIAGo listens to {topics.head} and {controllers.arm_topic}; its camera is {options.ros2}",
            flush=True,
        )
        stop.wait()
    return 0


def _add_scene(parser: argparse.ArgumentParser) -> None:
    """Add the options of a simulated robot's camera, of what it sees, and of what goes wrong."""
    parser.add_argument("--fps", type=float, default=30.0, help="images per second (30)")
    parser.add_argument(
        "--marker",
        type=_marker_pose,
        metavar="X,Y,Z,YAW,PITCH,ROLL",
        help="pose of the marker in the robot's base, metres and degrees; with three zeros it is upright and "
        "faces the robot. Turned about the vertical, then tipped about its own x, then turned on the spot. "
        "The robot looks at it from the beginning",
    )
    parser.add_argument(
        "--fault",
        action="append",
        default=[],
        metavar="NAME[@SECONDS]",
        help=f"something that goes wrong SECONDS ({DEFAULT_AFTER:g}) after the arm first moves; repeatable. "
        f"NAME: {', '.join(FAULTS)}",
    )
    parser.add_argument(
        "--truth",
        type=Path,
        metavar="FILE",
        help="record where hand and joints truly are, 100 times a second, and the faults (.csv)",
    )


def _marker_pose(text: str) -> tuple[float, ...]:
    """Parse six numbers with commas between them."""
    try:
        values = tuple(float(word) for word in text.split(","))
    except ValueError:
        values = ()
    if len(values) != 6 or not all(abs(value) <= 360 for value in values):
        raise argparse.ArgumentTypeError(
            f"'{text}' is no pose: write x,y,z in metres and yaw,pitch,roll in degrees, 0.7,-0.3,0.4,0,0,0"
        )
    return values


def _robot_with_camera(
    model: KinematicModel, options: argparse.Namespace, stack: ExitStack, *, reports_hand: bool = True
) -> tuple[SimRobot, FrameGrabber]:
    """Return a simulated robot and the open camera on its head, both until the stack ends.

    `reports_hand` says whether it reports the hand's pose, not only its joints.
    """
    from grabbergui.core.scheduling import single_threaded
    from grabbergui.driver.sim.rendered_scene import Things, at
    from grabbergui.servo import closed_loop
    from grabbergui.servo.config import MarkerConfig
    from grabbergui.servo.robots.faults import Faults
    from grabbergui.servo.robots.faulty_camera import FaultyCamera, TruthRecorder
    from grabbergui.servo.robots.simulated import SimRobot

    if not 1 <= options.fps <= 100:
        raise UsageError(f"--fps {options.fps:g}: out of range; allowed: 1 to 100")
    faults = Faults([Fault.parse(text) for text in options.fault], reports_hand=reports_hand)
    things, head = Things(), (0.0, 0.0)
    if options.marker is not None:
        board = at(*options.marker)
        things.board, head = lambda seconds: model.stands @ board, closed_loop.looking_at(model, board)
    single_threaded()
    robot = SimRobot(model, head=head, faults=faults)
    stack.callback(robot.close)
    camera = closed_loop.mounted_camera(robot, closed_loop.things_for(MarkerConfig(), things), options.fps)
    camera.open()
    stack.callback(camera.close)
    if options.truth is not None:
        recorder = TruthRecorder(robot, options.truth)
        recorder.start()
        stack.callback(recorder.close)
    if not faults:
        return robot, camera
    faulty = FaultyCamera(camera, robot)
    faulty.open()
    stack.callback(faulty.close)
    return robot, faulty
