"""Plugs the simulated camera into Linux's virtual USB host controller (vhci-hcd)."""

from __future__ import annotations

import socket
import sys
from pathlib import Path

from grabbergui.core.errors import SourceUnavailableError
from grabbergui.driver.sim.u3v.device import SimulatedU3vDevice
from grabbergui.driver.sim.u3v.usbip import SUPER_SPEED, UsbIpConnection

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
