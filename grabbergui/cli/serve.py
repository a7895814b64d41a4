"""`grabbergui serve`: one camera on YARP and ROS 2 at once, with or without the window."""

from __future__ import annotations

import argparse
import logging
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from grabbergui import sources
from grabbergui.cli import name_server
from grabbergui.cli.metrics import MetricsServer, parse_address
from grabbergui.cli.opening import add_monitor, opened
from grabbergui.cli.stopping import stop_on_signals
from grabbergui.config import ini, resource_finder
from grabbergui.config.serve_options import ServeOptions
from grabbergui.core.errors import SourceNotFoundError, UsageError
from grabbergui.core.features import Feature, format_value
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.uri import SIMULATED, SourceUri

if TYPE_CHECKING:
    from grabbergui.net.ros2.server import Ros2GrabberServer
    from grabbergui.net.yarp.server import YarpGrabberServer

log = logging.getLogger(__name__)

_NETWORKS = {
    "yarp": ("bind", "capabilities", "raw", "period", "normalised"),
    "ros2": ("frame_id", "calibration", "qos", "ros_args"),
}
"""Options that mean nothing without the network."""


def add_commands(commands: Any) -> None:
    """Add the parsers of this family."""
    parser = commands.add_parser(
        "serve",
        help="share a camera on YARP and ROS 2",
        # What is not given is not set, so that a file can say it.
        argument_default=argparse.SUPPRESS,
    )
    parser.add_argument("source", metavar="SOURCE", nargs="?", help="the camera; any source, remote ones too")
    parser.add_argument("--from", dest="file", metavar="FILE", help="read options from a .ini file")
    parser.add_argument("--context", metavar="NAME", help="the context that YARP's search for FILE begins in")
    parser.add_argument("--fake", action="store_true", help="the simulated camera")
    parser.add_argument(
        "--index", type=int, metavar="N", help="which camera found, where no SOURCE is named (0)"
    )
    add_monitor(parser)
    parser.add_argument("--pixel-format", metavar="NAME", help="set PixelFormat before streaming")
    parser.add_argument("--introspection", action="store_true", help="log every feature of the camera")
    parser.add_argument("--terminal", action="store_true", help="take commands from the keyboard")
    parser.add_argument("--window", action="store_true", help="open the window on it too")
    parser.add_argument(
        "--metrics",
        metavar="[HOST:]PORT",
        help="counters for Prometheus at http://HOST:PORT/metrics (127.0.0.1)",
    )

    yarp = parser.add_argument_group("YARP")
    yarp.add_argument("--yarp", metavar="/PORT", help="images here, requests at /PORT/rpc")
    name_server.add_options(yarp)
    yarp.add_argument("--bind", metavar="ADDRESS", help="the address our ports listen on")
    yarp.add_argument("--capabilities", choices=("COLOR", "RAW"), help="what the image port sends (COLOR)")
    yarp.add_argument("--raw", action="store_true", help="raw images as well, at /PORT/raw")
    yarp.add_argument("--period", type=float, metavar="S", help="seconds between images at least (0)")
    yarp.add_argument("--normalised", action="store_true", help="feature values as 0…1, not in their units")

    ros2 = parser.add_argument_group("ROS 2")
    ros2.add_argument("--ros2", metavar="/NAME", help="the node and prefix of its topics")
    ros2.add_argument("--frame-id", metavar="FRAME", help="of the pictures' headers (camera)")
    ros2.add_argument("--calibration", metavar="FILE", help="camera_info's YAML; set_camera_info writes it")
    ros2.add_argument("--qos", choices=("sensor_data", "reliable"), help="of the pictures (sensor_data)")
    ros2.add_argument(
        "--ros-args",
        nargs=argparse.REMAINDER,
        metavar="ARG",
        help="last: what every ROS program takes, as --params-file FILE, -p NAME:=VALUE, -r FROM:=TO",
    )
    parser.set_defaults(run=_run)


def _run(arguments: argparse.Namespace) -> int:
    options = _options(arguments)
    if options.metrics:
        parse_address(options.metrics)
    if options.yarp:
        from grabbergui.net.yarp.os.names import check_port_name

        check_port_name(options.yarp)
    with stop_on_signals() as stop, ExitStack() as stack:
        uri = options.uri or _nth_camera(options.index)
        grabber = stack.enter_context(opened(uri, monitor=options.monitor))
        if options.pixel_format:
            grabber.write_feature("PixelFormat", options.pixel_format)
        if options.introspection:
            for feature in grabber.features():
                log.warning("%s", _introspected(feature))
        grabber.start()
        published: dict[str, Callable[[], int]] = {}
        if options.yarp or options.with_name_server:
            yarp = stack.enter_context(_on_yarp(grabber, options))
            if yarp is not None:
                published["yarp"] = lambda: yarp.published
        if options.ros2:
            ros2 = stack.enter_context(_on_ros2(grabber, options, getattr(arguments, "ros_args", ())))
            published["ros2"] = lambda: ros2.published
        if options.metrics:
            metrics = stack.enter_context(MetricsServer(grabber, options.metrics, published))
            print(f"counters are at {metrics.url}", flush=True)
        print(f"serving {grabber.info.title} ({uri}); Ctrl-C ends it", flush=True)
        if options.window:
            return _show_window(grabber, stop)
        if options.terminal:
            from grabbergui.terminal import console

            console.run(grabber, finished=stop.is_set)
        else:
            stop.wait()
    return 0


def _options(arguments: argparse.Namespace) -> ServeOptions:
    known = {field.name for field in fields(ServeOptions)}
    given = {name: value for name, value in vars(arguments).items() if name in known and value is not None}
    options = ServeOptions(**given)
    name = getattr(arguments, "file", None)
    if name is not None:
        path = resource_finder.find(name, getattr(arguments, "context", ""))
        sections = ini.parse(path.read_text("utf-8", errors="replace"), str(path))
        options = options.with_file(sections[""], frozenset(given), str(path))
    if not (options.yarp or options.ros2 or options.window or options.terminal or options.with_name_server):
        raise UsageError("serve on what? Add --yarp /grabber, --ros2 /camera, --window or --terminal")
    for network, names in _NETWORKS.items():
        idle = [name for name in names if hasattr(arguments, name) and not getattr(options, network)]
        if idle:
            raise UsageError(f"--{idle[0].replace('_', '-')} says nothing without --{network} /NAME")
    return options


def _nth_camera(index: int) -> str:
    """The camera of that number among those found, the simulated one left out, in order of their URIs."""
    found = sorted(info.uri for info in sources.discover() if not info.uri.startswith(SIMULATED))
    if not 0 <= index < len(found):
        raise SourceNotFoundError(
            f"there is no camera {index}: {len(found)} found; "
            "name a SOURCE, or say --fake for the simulated camera"
        )
    return found[index]


def _introspected(feature: Feature) -> str:
    return f"{feature.name} = {format_value(feature.value)} {feature.unit} ({feature.range_text()})"


@contextmanager
def _on_yarp(grabber: FrameGrabber, options: ServeOptions) -> Iterator[YarpGrabberServer | None]:
    from grabbergui.net.yarp.dev.grabber_pictures import Capability
    from grabbergui.net.yarp.server import YarpGrabberServer
    from grabbergui.terminal.interpreter import remote_terminal

    with name_server.named(options.nameserver, ours=options.with_name_server) as names:
        if not options.yarp:
            yield None
            return
        server = YarpGrabberServer(
            grabber,
            options.yarp,
            names=names,
            capabilities=Capability(options.capabilities),
            also_raw=options.raw,
            period=options.period,
            normalised=options.normalised,
            bind=options.bind,
            terminal=remote_terminal(grabber),
        )
        server.start()
        try:
            yield server
        finally:
            server.stop()


@contextmanager
def _on_ros2(
    grabber: FrameGrabber, options: ServeOptions, ros_args: Sequence[str]
) -> Iterator[Ros2GrabberServer]:
    from grabbergui.net.ros2.server import Ros2GrabberServer
    from grabbergui.terminal.interpreter import remote_terminal

    server = Ros2GrabberServer(
        grabber,
        options.ros2,
        frame_id=options.frame_id,
        calibration=Path(options.calibration) if options.calibration else None,
        qos=options.qos,
        ros_args=ros_args,
        terminal=remote_terminal(grabber),
    )
    server.start()
    try:
        yield server
    finally:
        server.stop()


def _show_window(grabber: FrameGrabber, stop: threading.Event) -> int:
    from grabbergui.core.shared import SharedGrabber
    from grabbergui.ui import app

    def create(uri: SourceUri) -> FrameGrabber:
        """The camera that is served, or another that is picked in the list."""
        return SharedGrabber(grabber) if str(uri) == grabber.info.uri else sources.create(uri)

    return app.run(grabber.info.uri, create=create, stop=stop)
