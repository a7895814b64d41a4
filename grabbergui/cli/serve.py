"""`grabbergui serve`: one camera on YARP and ROS 2 at once, with or without the window."""

from __future__ import annotations

import argparse
import logging
import os
import re
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager, suppress
from dataclasses import Field, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from grabbergui import sources
from grabbergui.cli.arguments import Outage, add_lost_timeout, add_monitor, opened
from grabbergui.cli.name_servers import add_name_server_options, named_server
from grabbergui.cli.process import stop_on_signals, supervised
from grabbergui.config.allowed_addresses import AllowedAddresses
from grabbergui.config.ini_files import find_ini, parse_ini, read_ini
from grabbergui.config.serve_options import ServeOptions
from grabbergui.core.environment import find_file
from grabbergui.core.errors import GrabberError, MissingFileError, SourceNotFoundError, UsageError
from grabbergui.core.features import Feature
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.uri import SIMULATED, SourceUri
from grabbergui.core.visible_text import print_line

if TYPE_CHECKING:
    from grabbergui.calibration.fitting import FittedCalibration
    from grabbergui.cli.metrics import MetricsServer
    from grabbergui.net.ros2.server import Ros2GrabberServer
    from grabbergui.net.yarp.server import YarpGrabberServer

log = logging.getLogger(__name__)

_RENAMED = re.compile(r"__(ns|node|name):=")
"""ROS arguments that would override the name given by --ros2."""


def add_commands(commands: Any) -> None:
    """Add the parsers of this family."""
    parser = commands.add_parser(
        "serve",
        help="share a camera on YARP and ROS 2",
        example="grabbergui serve gige: --yarp /grabber --ros2 /camera",
        # Options that are not given stay unset, so that a file can set them.
        argument_default=argparse.SUPPRESS,
    )
    parser.add_argument(
        "source", metavar="SOURCE", nargs="?", help="the camera: any source, also a remote one"
    )
    parser.add_argument("--from", dest="file", metavar="FILE", help="read options from a .ini file")
    parser.add_argument(
        "--context", metavar="NAME", help="the YARP context in which to search for FILE first"
    )
    yarp, ros2 = parser.add_argument_group("YARP"), parser.add_argument_group("ROS 2")
    groups = {"yarp": yarp, "ros2": ros2}
    for option in fields(ServeOptions):
        if option.name in _SHARED:
            _SHARED[option.name](yarp if option.name == "with_name_server" else parser)
        elif option.metadata:
            _add_option(groups.get(option.metadata["needs"] or option.name, parser), option)
    ros2.add_argument(
        "--ros-args",
        nargs=argparse.REMAINDER,
        metavar="ARG",
        help="ROS arguments, as the last option: --params-file FILE, -p NAME:=VALUE, -r FROM:=TO",
    )
    parser.set_defaults(run=_run)


def _add_allow(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--allow",
        action="append",
        metavar="ADDRESS",
        help="serve YARP and the counters only to this address or network, such as 10.0.0.0/24; repeatable",
    )


_SHARED: Mapping[str, Callable[[Any], None]] = {
    "monitor": add_monitor,
    "lost_timeout": add_lost_timeout,
    "allow": _add_allow,
    "with_name_server": add_name_server_options,
}
"""Options that other commands have too, or that can be repeated; each adds those that belong to it."""


def _add_option(parser: argparse._ActionsContainer, option: Field[Any]) -> None:
    """Add an option as its field describes it."""
    name, described, default = f"--{option.name.replace('_', '-')}", option.metadata, option.default
    if isinstance(default, bool):
        parser.add_argument(name, action="store_true", help=described["meaning"])
        return
    meaning, semicolon, rest = described["meaning"].partition(";")
    if default != "":
        meaning = f"{meaning} ({default:g})" if isinstance(default, float) else f"{meaning} ({default})"
    parser.add_argument(
        name,
        type=type(default),
        metavar=described["form"] or None,
        choices=described["choices"] or None,
        help=meaning + semicolon + rest,
    )


def _run(arguments: argparse.Namespace) -> int:
    options = _options(arguments)
    allowed = options.allowed
    if options.metrics:
        from grabbergui.cli.metrics import parse_address

        parse_address(options.metrics)
    if options.yarp:
        from grabbergui.net.yarp.os.target import check_port_name

        check_port_name(options.yarp)
    with stop_on_signals() as stop, ExitStack() as stack:
        ros_args = getattr(arguments, "ros_args", ())
        place = " ".join((options.yarp or options.ros2, *filter(_RENAMED.match, ros_args)))
        uri = _with_own_serial(options.uri or _nth_camera(options.index), place)
        grabber = stack.enter_context(opened(uri, monitor=options.monitor))
        outage = Outage(grabber, options.lost_timeout or None, on_exceeded=stop.set)
        stack.callback(outage.close)
        if options.pixel_format:
            grabber.write_feature("PixelFormat", options.pixel_format)
        if options.introspection:
            for feature in grabber.features():
                log.warning("%s", _introspected(feature))
        if not options.lifecycle:
            grabber.start()
        shared = stack.enter_context(_read_only(grabber)) if options.read_only else grabber
        calibration = served_calibration(shared, options)
        published: dict[str, Callable[[], int]] = {}
        servers: list[YarpGrabberServer | Ros2GrabberServer] = []
        if options.yarp or options.with_name_server:
            yarp = stack.enter_context(_on_yarp(shared, options, calibration))
            if yarp is not None:
                published["yarp"] = lambda: yarp.published
                servers.append(yarp)
        if options.ros2:
            ros2 = stack.enter_context(_on_ros2(shared, options, calibration, ros_args))
            published["ros2"] = lambda: ros2.published
            servers.append(ros2)
        if options.metrics:
            metrics = stack.enter_context(_metrics(grabber, options, published, allowed))
            print_line(f"counters are at {metrics.url}", flush=True)
        stack.enter_context(supervised(grabber.statistics))
        code = 0
        print_line(f"serving {grabber.info.title} ({uri}); Ctrl-C ends it", flush=True)
        if options.window:
            code = _show_window(grabber, stop, options, servers)
        elif options.terminal:
            from grabbergui.terminal import console

            # Without input, as in a service, nobody can type `exit`.
            if not console.run(grabber, finished=stop.is_set).left:
                stop.wait()
        else:
            stop.wait()
        outage.check()
    return code


def _options(arguments: argparse.Namespace) -> ServeOptions:
    known = {field.name for field in fields(ServeOptions)}
    given = {name: value for name, value in vars(arguments).items() if name in known and value is not None}
    if "allow" in given:
        given["allow"] = " ".join(given["allow"])
    options = ServeOptions(**given)
    name = getattr(arguments, "file", None)
    if name is not None:
        path = find_ini(name, getattr(arguments, "context", ""))
        sections = parse_ini(read_ini(path), str(path))
        options = options.with_file(sections[""], frozenset(given), str(path))
    if not (options.yarp or options.ros2 or options.window or options.terminal or options.with_name_server):
        raise UsageError("serve on what? Add --yarp /grabber, --ros2 /camera, --window or --terminal")
    needs = {option.name: option.metadata.get("needs") for option in fields(ServeOptions)}
    for name, network in {**needs, "ros_args": "ros2"}.items():
        if network and hasattr(arguments, name) and not getattr(options, network):
            raise UsageError(f"--{name.replace('_', '-')} has no effect without --{network} /NAME")
    if options.calibration and not (options.yarp or options.ros2):
        raise UsageError("--calibration has no effect without --yarp /NAME or --ros2 /NAME")
    return options


@contextmanager
def _read_only(grabber: FrameGrabber) -> Iterator[FrameGrabber]:
    """Yield the grabber for networks that may only read; users of this machine may still write."""
    from grabbergui.core.shared import ReadOnlyGrabber

    shown = ReadOnlyGrabber(grabber)
    shown.open()
    with closing(shown):
        yield shown


def _nth_camera(index: int) -> str:
    """Return the camera of that number among those found, sorted by URI, without the simulated one."""
    found = sorted(info.uri for info in sources.discover() if not info.uri.startswith(SIMULATED))
    if not 0 <= index < len(found):
        raise SourceNotFoundError(
            f"there is no camera {index}: {len(found)} found; "
            "name a SOURCE, or say --fake for the simulated camera"
        )
    return found[index]


def _with_own_serial(uri: str, place: str) -> str:
    """Give a simulated camera a serial number that no other server's has, unless it was given one."""
    from grabbergui.driver.sim.device import served_at

    source = SourceUri.parse(uri)
    return str(served_at(source, place)) if source.scheme == "sim" and place else uri


def _introspected(feature: Feature) -> str:
    return f"{feature.name} = {feature.text} {feature.unit} ({feature.range_text()})"


def _metrics(
    grabber: FrameGrabber,
    options: ServeOptions,
    published: dict[str, Callable[[], int]],
    allowed: AllowedAddresses,
) -> MetricsServer:
    from grabbergui.cli.metrics import MetricsServer, read_token

    token = read_token(options.metrics_token) if options.metrics_token else ""
    return MetricsServer(grabber, options.metrics, published, token=token, allowed=allowed)


def served_calibration(grabber: FrameGrabber, options: ServeOptions) -> FittedCalibration:
    """Return the calibration that all networks share. Raises UsageError if its file cannot be used."""
    from grabbergui.calibration.fitting import FittedCalibration

    file = Path(options.calibration) if options.calibration else None
    # With ROS 2 it may be a new file for set_camera_info to write, but never one of the program's own.
    if file is not None and not options.ros2:
        with suppress(MissingFileError):
            file = find_file(file, "calibration", "servo")
        if not file.is_file():
            raise UsageError(f"--calibration {file}: there is no such file; `grabbergui calibrate` makes one")
    calibration = FittedCalibration(grabber, file)
    if calibration.calibration is not None:
        try:
            calibration.now()
        except GrabberError as error:  # of images of another size, which may be set later
            log.warning("--calibration %s is not used for the images as they are set: %s", file, error)
    return calibration


@contextmanager
def _on_yarp(
    grabber: FrameGrabber, options: ServeOptions, calibration: FittedCalibration
) -> Iterator[YarpGrabberServer | None]:
    from grabbergui.net.yarp.grabber_image import Capability
    from grabbergui.net.yarp.os.configuration import require_authentication
    from grabbergui.net.yarp.server import YarpGrabberServer
    from grabbergui.terminal import remote_terminal

    if options.require_authentication:
        require_authentication()
    allowed = options.allowed
    with named_server(options.nameserver, ours=options.with_name_server, allowed=allowed) as names:
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
            allowed=allowed,
            terminal=remote_terminal(grabber),
            calibration=calibration,
        )
        with server:
            query = f"?nameserver={names.server.host}:{names.server.port}" if options.nameserver else ""
            print_line(f"YARP: {', '.join(server.places())}; open it as yarp:{server.name}{query}")
            yield server


def narrow_discovery(allowed: AllowedAddresses) -> None:
    """Let ROS 2 search for peers only among the allowed. It prevents accidents, not attacks."""
    hosts = allowed.hosts
    if hosts is None or "ROS_AUTOMATIC_DISCOVERY_RANGE" in os.environ:
        log.warning("--allow %s: ROS 2 answers everybody in its domain; use a firewall or SROS 2", allowed)
        return
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    os.environ["ROS_STATIC_PEERS"] = ";".join(hosts)
    log.warning(
        "--allow %s: ROS 2 looks for peers only on this machine and there; it still answers any peer that "
        "knows its address",
        allowed,
    )


@contextmanager
def _on_ros2(
    grabber: FrameGrabber, options: ServeOptions, calibration: FittedCalibration, ros_args: Sequence[str]
) -> Iterator[Ros2GrabberServer]:
    from grabbergui.net.ros2.server import Ros2GrabberServer
    from grabbergui.terminal import remote_terminal

    allowed = options.allowed
    if not allowed.everybody:
        narrow_discovery(allowed)
    server = Ros2GrabberServer(
        grabber,
        options.ros2,
        frame_id=options.frame_id,
        calibration=calibration,
        qos=options.qos,
        ros_args=ros_args,
        read_only=options.read_only,
        lifecycle=options.lifecycle,
        terminal=remote_terminal(grabber),
    )
    with server:
        print_line(f"ROS 2: {', '.join(server.places())}; open it as ros2:{server.name}")
        yield server


def _show_window(
    grabber: FrameGrabber,
    stop: threading.Event,
    options: ServeOptions,
    servers: Sequence[YarpGrabberServer | Ros2GrabberServer],
) -> int:
    from grabbergui.core.shared import SharedGrabber
    from grabbergui.models.share import Network, ShareOptions
    from grabbergui.models.sharing import Served
    from grabbergui.net.yarp.server import YarpGrabberServer
    from grabbergui.ui.run import window

    def served(server: YarpGrabberServer | Ros2GrabberServer) -> Served:
        network = Network.YARP if isinstance(server, YarpGrabberServer) else Network.ROS2
        shared = ShareOptions(
            server.name,
            options.nameserver or "",
            options.with_name_server and not options.nameserver,
            read_only=options.read_only,
        )
        return Served(grabber.info.uri, network, shared, server)

    def create(uri: SourceUri) -> FrameGrabber:
        """Return the served grabber for its own URI, or open another source that is chosen in the list."""
        return SharedGrabber(grabber) if str(uri) == grabber.info.uri else sources.create(uri)

    return window.run(grabber.info.uri, create=create, served=[*map(served, servers)], stop=stop)
