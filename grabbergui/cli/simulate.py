"""Commands that stand in for what is missing: cameras on the wire, robots on networks, a name server."""

from __future__ import annotations

import argparse
import functools
import logging
import socket
import tempfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from grabbergui.cli import servo_robots
from grabbergui.cli.arguments import count_or_none, ipv4, not_negative, part, port, seconds
from grabbergui.cli.process import stop_on_signals
from grabbergui.config.allowed_addresses import EVERYBODY, AllowedAddresses
from grabbergui.core.environment import find_file
from grabbergui.core.errors import GrabberError, UsageError
from grabbergui.core.uri import SourceUri
from grabbergui.core.visible_text import print_line
from grabbergui.servo.robots.fault_list import DEFAULT_AFTER, FAULTS, Fault

if TYPE_CHECKING:
    from grabbergui.core.grabber import FrameGrabber
    from grabbergui.net.yarp.os.contact import Contact
    from grabbergui.net.yarp.os.name_client import NameClient
    from grabbergui.net.yarp.os.name_server import NameServer
    from grabbergui.servo.robots.robot import KinematicModel
    from grabbergui.servo.robots.simulated import SimRobot

log = logging.getLogger(__name__)


def add_commands(commands: Any) -> None:
    """Add the parsers of this family."""
    _add_camera(commands)
    _add_teo(commands)
    _add_tiago(commands)
    _add_yarp_server(commands)


# -- cameras -------------------------------------------------------------------------------------
def _add_camera(commands: Any) -> None:
    parser = commands.add_parser(
        "simulate",
        help="serve the simulated camera to any GenICam software",
        example="grabbergui simulate --gige --loss 1% --delay 5ms",
    )
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument(
        "--gige",
        nargs="*",
        type=ipv4,
        metavar="ADDRESS",
        help="as a GigE Vision device at each address (127.0.0.1)",
    )
    what.add_argument("--u3v", action="store_true", help="as a USB3 Vision device")
    parser.add_argument(
        "--camera",
        default="sim:",
        metavar="SOURCE",
        help="the camera and its power-on values: sim:colour?width=640&fps=60 …",
    )
    parser.add_argument(
        "--twin",
        type=Path,
        metavar="FILE.zip",
        help="with --gige: the camera of a report that `grabbergui report` made, instead of --camera",
    )
    parser.add_argument(
        "--serial",
        default="",
        help="the serial number (made from the address); further cameras get the next numbers",
    )

    parser.add_argument(
        "--bandwidth",
        type=_bandwidth,
        default=125e6,
        metavar="BYTES/S",
        help="speed of the link, to which --gige paces its packets; 0 is unlimited (125e6: 1 GbE)",
    )
    parser.add_argument(
        "--segmentation",
        action="store_true",
        help="let the kernel cut --gige's packets out of large sends: faster, but packet sockets and "
        "captures on this machine see the large ones",
    )

    faults = parser.add_argument_group("faults on the network (--gige)")
    faults.add_argument("--loss", type=part, default=0.0, metavar="1%", help="share of the packets to drop")
    faults.add_argument("--reorder", action="store_true", help="send some packets out of order")
    faults.add_argument("--duplicate", action="store_true", help="send some packets twice")
    faults.add_argument("--delay", type=seconds, default=0.0, metavar="5ms", help="delay every datagram")
    faults.add_argument(
        "--stall-after", type=count_or_none, default=0, metavar="N", help="stop answering after N frames"
    )
    faults.add_argument(
        "--reboot-after", type=seconds, default=0.0, metavar="S", help="restart after S seconds"
    )

    usb = parser.add_argument_group("the USB (--u3v)")
    usb.add_argument(
        "--via",
        choices=("vhci", "tcp", "gadget"),
        default="vhci",
        help="vhci: this machine (default), tcp: USB/IP, gadget: FunctionFS",
    )
    usb.add_argument("--host", default="127.0.0.1", help="address for --via tcp")
    usb.add_argument("--port", type=port, default=3240, help="port for --via tcp")
    usb.add_argument("--udc", default="", help="device controller for --via gadget (the first)")
    usb.add_argument(
        "--unplug-after", type=count_or_none, default=0, metavar="N", help="unplug after N frames"
    )
    parser.set_defaults(run=_simulate_camera)


_FASTEST_LINK = 1e12
"""Bytes per second; the camera has its speed in a register of 32 bits, in Mbit/s."""


def _bandwidth(text: str) -> float:
    """Parse bytes per second; 0 is unlimited."""
    value = not_negative(text)
    if value > _FASTEST_LINK:
        raise argparse.ArgumentTypeError(f"'{text}' is more than {_FASTEST_LINK:g}; 0 is unlimited")
    return value


def _simulate_camera(options: argparse.Namespace) -> int:
    if options.twin is not None and (options.u3v or options.serial or options.camera != "sim:"):
        raise UsageError("--twin needs --gige, and has a serial number and settings of its own")
    camera = SourceUri.parse(options.camera)
    if camera.scheme != "sim":
        raise UsageError(f"--camera {options.camera}: only the simulated camera can be simulated (sim:?…)")
    serve = _serve_u3v if options.u3v else _serve_gige
    with stop_on_signals() as stop:
        serve(options, camera)(stop=stop, ready=functools.partial(print, flush=True))
    return 0


def _serve_gige(options: argparse.Namespace, camera: SourceUri) -> Callable[..., None]:
    addresses = options.gige or ("127.0.0.1",)
    from grabbergui.driver.sim.device import power_on_at_address, scene_of
    from grabbergui.driver.sim.gige.server import serve
    from grabbergui.driver.sim.gige.stream import Faults

    faults = Faults(
        loss=options.loss,
        reorder=options.reorder,
        duplicate=options.duplicate,
        delay=options.delay,
        stall_after=options.stall_after,
        reboot_after=options.reboot_after,
    )
    if options.twin is not None:
        from grabbergui.driver.twin import device, gige

        report = device.load(find_file(options.twin, "camera report"))
        return functools.partial(gige.serve, addresses, report, faults=faults, bandwidth=options.bandwidth)
    return functools.partial(
        serve,
        addresses,
        serial=options.serial,
        power_on=power_on_at_address(camera),
        scene=scene_of(camera),
        faults=faults,
        bandwidth=options.bandwidth,
        segmentation=options.segmentation,
    )


def _serve_u3v(options: argparse.Namespace, camera: SourceUri) -> Callable[..., None]:
    from grabbergui.driver.sim.device import create_device, served_at
    from grabbergui.driver.sim.u3v.device import U3vFaults
    from grabbergui.driver.sim.u3v.serve import place_of, serve

    if options.serial:
        camera = replace(camera, options={**camera.options, "serial": options.serial})
    elif "serial" not in camera.options:
        camera = served_at(camera, place_of(options.via, options.host, options.port, options.udc))
    return functools.partial(
        serve,
        options.via,
        model=create_device(camera).model,
        faults=U3vFaults(unplug_after_frames=options.unplug_after),
        host=options.host,
        port=options.port,
        udc=options.udc,
    )


# -- robots --------------------------------------------------------------------------------------
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
        if robot.faults:
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
    from grabbergui.servo.robots.tiago_messages import Drive, Kind
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
        if robot.faults:
            kind = Kind.TRAJECTORY if options.stock else Kind.TWIST
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


# -- name servers --------------------------------------------------------------------------------
def _add_yarp_server(commands: Any) -> None:
    parser = commands.add_parser(
        "yarp-server", help="run a small YARP name server", example="grabbergui yarp-server --host 0.0.0.0"
    )
    parser.add_argument(
        "--host",
        default="127.0.0.1",
        help="the address to listen on; 0.0.0.0 for the whole network (127.0.0.1)",
    )
    parser.add_argument(
        "--port", type=port, default=10000, help="the TCP port to listen on; 0 takes a free one (10000)"
    )
    parser.add_argument("--namespace", default="/root", help="the server's own name (/root)")
    parser.add_argument(
        "--allow",
        action="append",
        default=[],
        metavar="ADDRESS",
        help="serve only this address or network, such as 10.0.0.0/24; repeatable",
    )
    parser.set_defaults(run=_serve_names)


def _serve_names(options: argparse.Namespace) -> int:
    from grabbergui.net.yarp.os.name_server import NameServer

    server = NameServer(
        options.host,
        options.port,
        namespace=options.namespace,
        allowed=AllowedAddresses.parse(options.allow),
    )
    with stop_on_signals() as stop, _running(server):
        stop.wait()
    return 0


_NAME_SERVER = "127.0.0.1:10000"
"""The default address of our name server."""


def add_name_server_options(parser: argparse.ArgumentParser | argparse._ArgumentGroup) -> None:
    """Add `--with-name-server` and `--nameserver`."""
    parser.add_argument(
        "--with-name-server", action="store_true", help=f"also run a YARP name server, at {_NAME_SERVER}"
    )
    parser.add_argument(
        "--nameserver",
        metavar="HOST:PORT",
        help="the name server (YARP's configuration), or the address of the one to run",
    )


@contextmanager
def named_server(address: str, *, ours: bool, allowed: AllowedAddresses = EVERYBODY) -> Iterator[NameClient]:
    """The name server at `HOST:PORT`, else the configured one.

    With `ours` one that runs within the block and answers the `allowed` addresses.

    Raises UsageError for an address that is none, SourceUnavailableError and TransportError.
    """
    from grabbergui.net.yarp.os.name_client import NameClient
    from grabbergui.net.yarp.os.name_server import NameServer

    if not ours:
        yield NameClient.find(address)
        return
    host, _, port = (address or _NAME_SERVER).rpartition(":")
    if not host or not (port.isascii() and port.isdigit()) or int(port) > 0xFFFF:
        raise UsageError(f"--nameserver {address}: write HOST:PORT")
    with _running(NameServer(host, int(port), allowed=allowed)) as contact:
        yield NameClient.find(f"{contact.host}:{contact.port}")


@contextmanager
def _running(server: NameServer) -> Iterator[Contact]:
    """Run a name server within the block; print and yield where it is."""
    server.open()
    try:
        contact = server.contact
        print_line(f"YARP name server {contact.name} is at {contact.host}:{contact.port}", flush=True)
        _warn_of_another(contact)
        yield contact
    finally:
        server.close()


def _warn_of_another(ours: Contact) -> None:
    """Warn if YARP's configuration names another name server, where all other programs look for ports."""
    from grabbergui.net.yarp.os import sockets
    from grabbergui.net.yarp.os.configuration import name_server

    with suppress(GrabberError, OSError):
        configured = name_server()
        if configured is None:
            return
        local = ("127.0.0.1", *sockets.local_addresses())
        if configured.port != ours.port or socket.gethostbyname(configured.host) not in local:
            log.warning(
                "YARP's configuration names %s:%d, so other programs do not see this name server's ports; "
                "`yarp conf %s %d` names it",
                *configured.address,
                *ours.address,
            )
