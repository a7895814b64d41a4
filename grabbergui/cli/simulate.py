"""`grabbergui simulate`: the simulated camera as a real device on the wire."""

from __future__ import annotations

import argparse
import functools
from collections.abc import Callable
from typing import Any

from grabbergui.cli.numbers import count_or_none, not_negative, part, port, seconds
from grabbergui.cli.stopping import stop_on_signals
from grabbergui.core.errors import UsageError
from grabbergui.core.uri import SourceUri


def add_commands(commands: Any) -> None:
    """Add the parsers of this family."""
    parser = commands.add_parser("simulate", help="serve the simulated camera to any GenICam software")
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument(
        "--gige",
        nargs="*",
        metavar="ADDRESS",
        help="as a GigE Vision device at each address (127.0.0.1)",
    )
    what.add_argument("--u3v", action="store_true", help="as a USB3 Vision device")
    parser.add_argument(
        "--camera", default="sim:", metavar="SOURCE", help="its power-on values: sim:?width=640&fps=60 …"
    )
    parser.add_argument(
        "--serial",
        default="",
        help="the serial number (follows from the address); further cameras count on",
    )

    parser.add_argument(
        "--bandwidth",
        type=not_negative,
        default=125e6,
        metavar="BYTES/S",
        help="of the link that --gige paces its packets to; 0 is unlimited (125e6: 1 GbE)",
    )
    parser.add_argument(
        "--segmentation",
        action="store_true",
        help="let the kernel cut --gige's packets out of large sends: faster, but packet sockets and "
        "captures on this machine see the large ones",
    )

    faults = parser.add_argument_group("faults on the network (--gige)")
    faults.add_argument("--loss", type=part, default=0.0, metavar="1%", help="packets that never leave")
    faults.add_argument("--reorder", action="store_true", help="let some packets overtake others")
    faults.add_argument("--duplicate", action="store_true", help="send some packets twice")
    faults.add_argument("--delay", type=seconds, default=0.0, metavar="5ms", help="hold every datagram back")
    faults.add_argument(
        "--stall-after", type=count_or_none, default=0, metavar="N", help="fall silent after N frames"
    )
    faults.add_argument(
        "--reboot-after", type=not_negative, default=0.0, metavar="S", help="vanish after S seconds"
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
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    camera = SourceUri.parse(options.camera)
    if camera.scheme != "sim":
        raise UsageError(f"--camera {options.camera}: only the simulated camera can be simulated (sim:?…)")
    serve = _serve_u3v if options.u3v else _serve_gige
    with stop_on_signals() as stop:
        serve(options, camera)(stop=stop, ready=functools.partial(print, flush=True))
    return 0


def _serve_gige(options: argparse.Namespace, camera: SourceUri) -> Callable[..., None]:
    from grabbergui.driver.sim.gige.server import serve
    from grabbergui.driver.sim.gige.stream import Faults
    from grabbergui.driver.sim.source import power_on_values

    faults = Faults(
        loss=options.loss,
        reorder=options.reorder,
        duplicate=options.duplicate,
        delay=options.delay,
        stall_after=options.stall_after,
        reboot_after=options.reboot_after,
    )
    return functools.partial(
        serve,
        options.gige or ("127.0.0.1",),
        serial=options.serial,
        power_on=power_on_values(camera),
        faults=faults,
        bandwidth=options.bandwidth,
        segmentation=options.segmentation,
    )


def _serve_u3v(options: argparse.Namespace, camera: SourceUri) -> Callable[..., None]:
    from grabbergui.driver.sim.source import create_device, served_at
    from grabbergui.driver.sim.u3v.device import U3vFaults
    from grabbergui.driver.sim.u3v.serve import place_of, serve

    if options.serial:
        camera = SourceUri("sim", "", {**camera.options, "serial": options.serial})
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
