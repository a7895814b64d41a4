"""`simulate`: serve the simulated camera on the wire, as a GigE Vision or a USB3 Vision device."""

from __future__ import annotations

import argparse
import functools
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from grabbergui.cli.arguments import count_or_none, ipv4, not_negative, part, port, seconds
from grabbergui.cli.process import stop_on_signals
from grabbergui.core.environment import find_file
from grabbergui.core.errors import UsageError
from grabbergui.core.uri import SourceUri

_FASTEST_LINK = 1e12
"""Bytes per second; the camera has its speed in a register of 32 bits, in Mbit/s."""


def add_commands(commands: Any) -> None:
    """Add the parser."""
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

    parser.add_argument(
        "--wire",
        action="append",
        default=[],
        type=_wire,
        metavar="A.Line2=B.Line1",
        help="connect the output of the camera at address A to the input of that at B; repeatable",
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


def _bandwidth(text: str) -> float:
    """Parse bytes per second; 0 is unlimited."""
    value = not_negative(text)
    if value > _FASTEST_LINK:
        raise argparse.ArgumentTypeError(f"'{text}' is more than {_FASTEST_LINK:g}; 0 is unlimited")
    return value


def _wire(text: str) -> tuple[str, str]:
    """Parse the ends of a wire: the addresses of the sender and of the receiver."""
    sender, _, receiver = text.partition("=")
    ends = sender.removesuffix(".Line2"), receiver.removesuffix(".Line1")
    if f"{ends[0]}.Line2={ends[1]}.Line1" != text:
        raise argparse.ArgumentTypeError(f"'{text}' is no wire, such as 127.0.0.1.Line2=127.0.0.2.Line1")
    return ipv4(ends[0]), ipv4(ends[1])


def _simulate_camera(options: argparse.Namespace) -> int:
    if options.wire and (options.u3v or options.twin is not None):
        raise UsageError("--wire needs --gige, and no --twin")
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
    for end in {end for wire in options.wire for end in wire}.difference(addresses):
        raise UsageError(f"--wire: there is no camera at {end}; add it to --gige")
    from grabbergui.driver.sim.device import power_on_at_address, scene_of
    from grabbergui.driver.sim.gige.faults import GigeFaults
    from grabbergui.driver.sim.gige.server import serve

    faults = GigeFaults(
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
        wires=options.wire,
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
