"""Serves the simulated camera over USB, for `grabbergui simulate --u3v`."""

from __future__ import annotations

import socket
import sys
import threading
from collections.abc import Callable
from enum import Enum
from pathlib import Path

from grabbergui.core.errors import SourceUnavailableError, UsageError
from grabbergui.driver.sim.model import CameraModel
from grabbergui.driver.sim.u3v.device import SimulatedU3vDevice, U3vFaults
from grabbergui.driver.sim.u3v.usbip import SUPER_SPEED, UsbIpConnection, UsbIpServer

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


# -- this machine's virtual host controller ------------------------------------------------------
_VHCI = Path("/sys/devices/platform/vhci_hcd.0")
_DEVICE_ID = 0x10002
_FREE = "004"
"The state of a port without a device."


def attach_to_kernel(camera: SimulatedU3vDevice) -> UsbIpConnection:
    """Plug the camera into this machine's virtual host controller; `run` the connection then.

    Raises SourceUnavailableError without vhci-hcd or the right to use it.
    """
    if sys.platform == "win32":
        raise SourceUnavailableError("a virtual USB host controller needs Linux: use --via tcp")
    port = free_vhci_port()
    try:
        ours, kernels = socket.socketpair(socket.AF_UNIX, socket.SOCK_STREAM)
        with kernels:
            try:
                order = f"{port} {kernels.fileno()} {_DEVICE_ID} {SUPER_SPEED}"
                (_VHCI / "attach").write_text(order)
            except OSError:
                ours.close()
                raise
    except PermissionError as error:
        raise SourceUnavailableError(
            f"no permission to attach a virtual USB device ({_VHCI}/attach): run it as root"
        ) from error
    except OSError as error:
        raise SourceUnavailableError(f"the virtual USB host controller took no device: {error}") from error
    return UsbIpConnection(ours, camera)


def free_vhci_port() -> int:
    """Return the port of the virtual host controller that the next camera is attached to.

    Raises SourceUnavailableError.
    """
    try:
        status = (_VHCI / "status").read_text()
    except OSError as error:
        raise SourceUnavailableError(
            "this system has no virtual USB host controller: run `modprobe vhci-hcd` as root"
        ) from error
    return _free_port(status)


def _free_port(status: str) -> int:
    for line in status.splitlines()[1:]:
        hub, port, state, *_ = line.split()
        if hub == "ss" and state == _FREE:
            return int(port)
    raise SourceUnavailableError("all SuperSpeed ports of the virtual USB host controller are taken")
