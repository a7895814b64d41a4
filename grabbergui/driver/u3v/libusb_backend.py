"""Which libusb is used, and how it learns of cameras that come and go."""

from __future__ import annotations

import contextlib
import sys
import threading
from pathlib import Path
from typing import Any

import usb.backend.libusb1
import usb.core

_SYSTEM_DEVICES = Path("/sys/bus/usb/devices")
_UDEV_CONTROL = Path("/run/udev/control")

_lock = threading.Lock()
_kept: list[Any] = []
"""Backends in use, the newest last. None is ever dropped: devices found through one may still be open."""
_looked_at: set[tuple[int, int]] = set()
"Bus and address of the devices for which the newest was made."


def default_backend() -> Any | None:
    """Pyusb's libusb backend, with the system's libusb or the one of `libusb-package`; None without both."""
    with _lock:
        if not _kept:
            backend = usb.backend.libusb1.get_backend()
            if backend is None:
                try:
                    import libusb_package
                except ImportError:
                    return None
                backend = libusb_package.get_libusb1_backend()
            if backend is None:
                return None
            _kept.append(backend)
        with contextlib.suppress(usb.core.USBError):
            _look_again()
        return _kept[-1]


def _look_again() -> None:
    """Begin a new context where libusb missed devices that came or went.

    It hears of them through udev, which containers and small systems lack.
    """
    global _looked_at
    if not sys.platform.startswith("linux") or _UDEV_CONTROL.exists():
        return
    present = set()
    for folder in _SYSTEM_DEVICES.glob("*"):
        with contextlib.suppress(OSError, ValueError):
            present.add((int((folder / "busnum").read_text()), int((folder / "devnum").read_text())))
    newest = _kept[-1]
    descriptors = map(newest.get_device_descriptor, newest.enumerate_devices())
    known = {(descriptor.bus, descriptor.address) for descriptor in descriptors}
    # Once for each change: what a new context does not see either, it may not see.
    if present not in (known, _looked_at):
        _looked_at = present
        _kept.append(type(newest)(newest.lib))
