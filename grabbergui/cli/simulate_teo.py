"""`grabbergui simulate-teo`: the simulated TEO and its camera on a YARP network, for any client of them."""

from __future__ import annotations

import argparse
from contextlib import ExitStack
from typing import Any

from grabbergui.cli import name_server
from grabbergui.cli.stopping import stop_on_signals
from grabbergui.core.errors import UsageError


def add_commands(commands: Any) -> None:
    """Add the parsers of this family."""
    parser = commands.add_parser(
        "simulate-teo",
        help="serve a simulated TEO on YARP: head, right arm and the camera on its head",
        description="Ports NAME/head, NAME/rightArm/CartesianControl and NAME/camera, until Ctrl-C.",
    )
    parser.add_argument("--name", default="/teoSim", metavar="/PREFIX", help="what its ports begin with")
    name_server.add_options(parser)
    parser.add_argument("--fps", type=float, default=30.0, help="pictures per second (30)")
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    from grabbergui.net.yarp.os.names import check_port_name
    from grabbergui.net.yarp.server import YarpGrabberServer
    from grabbergui.servo import desk
    from grabbergui.servo.config import MarkerConfig
    from grabbergui.servo.robots import teo
    from grabbergui.servo.robots.simulated import SimRobot
    from grabbergui.servo.robots.teo_ports import TeoPorts

    check_port_name(options.name)
    if not 1 <= options.fps <= 100:
        raise UsageError(f"--fps {options.fps:g}: allowed is 1 to 100")
    with ExitStack() as stack, stop_on_signals() as stop:
        names = stack.enter_context(
            name_server.named(options.nameserver or "", ours=options.with_name_server)
        )
        robot = SimRobot(teo.BODY)
        stack.callback(robot.close)
        camera = desk.mounted_camera(robot, desk.things_for(MarkerConfig()), options.fps)
        camera.open()
        stack.callback(camera.close)
        ports = TeoPorts(robot, names, options.name)
        ports.open()
        stack.callback(ports.close)
        pictures = YarpGrabberServer(camera, f"{options.name}/camera", names=names)
        pictures.start()
        stack.callback(pictures.stop)
        print(f"{options.name} is on the name server at {names.server.host}:{names.server.port}", flush=True)
        stop.wait()
    return 0
