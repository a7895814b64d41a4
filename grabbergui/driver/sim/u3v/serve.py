"""Serves the simulated camera over USB, for `grabbergui simulate --u3v`."""

from __future__ import annotations

import threading
from collections.abc import Callable
from enum import Enum

from grabbergui.core.errors import UsageError
from grabbergui.driver.sim.model import CameraModel
from grabbergui.driver.sim.u3v.device import SimulatedU3vDevice, U3vFaults
from grabbergui.driver.sim.u3v.usbip import UsbIpServer
from grabbergui.driver.sim.u3v.virtual_host import attach_to_kernel, free_vhci_port

GADGET_LEADER_SPACE = 72
"Some controllers take up to 64 bytes that no host fetches, and deliver them at the next start."


class Via(Enum):
    """The way that connects the camera's USB to a host."""

    VHCI = "vhci"
    "This machine's virtual host controller, by USB/IP; the camera appears on this machine."
    TCP = "tcp"
    "USB/IP on a TCP port, for `usbip attach` on this or another machine."
    GADGET = "gadget"
    "Linux FunctionFS on a USB device controller; the camera appears at the other end of the cable."


def place_of(via: Via | str, host: str, port: int, udc: str) -> str:
    """Return the place at which a camera is plugged in, from which its default serial number follows.

    Raises SourceUnavailableError without a virtual host controller.
    """
    return {
        Via.VHCI: lambda: f"vhci port {free_vhci_port()}",
        Via.TCP: lambda: f"{host}:{port}",
        Via.GADGET: lambda: f"gadget {udc}",
    }[Via(via)]()


def serve(
    via: Via | str = Via.VHCI,
    *,
    model: CameraModel | None = None,
    faults: U3vFaults | None = None,
    host: str = "127.0.0.1",
    port: int = 3240,
    udc: str = "",
    stop: threading.Event | None = None,
    ready: Callable[[str], None] = print,
) -> None:
    """Run the camera until `stop` is set or a fault unplugs it. `ready` gets its location as display text.

    `host` and `port` are for TCP; `udc` names the device controller of a gadget, by default the first.
    Raises UsageError, SourceUnavailableError.
    """
    try:
        way = Via(via)
    except ValueError:
        ways = ", ".join(known.value for known in Via)
        raise UsageError(f"--via {via}: one of {ways} is expected") from None
    stop = stop or threading.Event()
    camera = SimulatedU3vDevice(
        model, faults=faults, leader_space=GADGET_LEADER_SPACE if way is Via.GADGET else 0
    )
    camera.on_unplug = stop.set
    camera.start()
    try:
        if way is Via.VHCI:
            _serve_vhci(camera, stop, ready)
        elif way is Via.TCP:
            _serve_tcp(camera, stop, ready, host, port)
        else:
            _serve_gadget(camera, stop, ready, udc)
    finally:
        camera.on_unplug = None
        camera.stop()


def _serve_vhci(camera: SimulatedU3vDevice, stop: threading.Event, ready: Callable[[str], None]) -> None:
    connection = attach_to_kernel(camera)
    thread = threading.Thread(target=connection.run, name="usbip", daemon=True)
    thread.start()
    ready(f"USB3 Vision camera {camera.identity.serial} is plugged into this machine's virtual bus")
    stop.wait()
    connection.close()
    thread.join()


def _serve_tcp(
    camera: SimulatedU3vDevice, stop: threading.Event, ready: Callable[[str], None], host: str, port: int
) -> None:
    server = UsbIpServer(camera, host, port)
    thread = threading.Thread(target=server.run, name="usbip-server", daemon=True)
    thread.start()
    host, port = server.address
    ready(f"USB3 Vision camera {camera.identity.serial}: usbip --tcp-port {port} attach -r {host} -b 1-1")
    stop.wait()
    server.close()
    thread.join()


def _serve_gadget(
    camera: SimulatedU3vDevice, stop: threading.Event, ready: Callable[[str], None], udc: str
) -> None:
    from grabbergui.driver.sim.u3v.gadget import Gadget

    with Gadget(camera, udc) as gadget:
        ready(f"USB3 Vision camera {camera.identity.serial} is on the device controller {gadget.udc}")
        stop.wait()
