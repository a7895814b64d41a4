"""Which libusb is used, and how it learns of cameras that come and go."""

from __future__ import annotations

import contextlib
import sys
from pathlib import Path
from typing import Any

import usb.backend.libusb1

_SYSTEM_DEVICES = Path("/sys/bus/usb/devices")
_UDEV_CONTROL = Path("/run/udev/control")

_kept: list[Any] = []
"""Backends in use, the newest last. None is ever dropped: devices found through one may still be open."""


def default_backend() -> Any | None:
    """Pyusb's libusb backend, with the system's libusb or the one of `libusb-package`; None without both."""
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
    newest = _kept[-1]
    if _is_out_of_date(newest):
        _kept.append(type(newest)(newest.lib))
    return _kept[-1]


def _is_out_of_date(backend: Any) -> bool:
    """Whether libusb missed devices that came or went.

    It hears of them through udev, which containers and small systems lack: then only a new context looks
    again.
    """
    if not sys.platform.startswith("linux") or _UDEV_CONTROL.exists():
        return False
    present = set()
    for folder in _SYSTEM_DEVICES.glob("*"):
        with contextlib.suppress(OSError, ValueError):
            present.add((int((folder / "busnum").read_text()), int((folder / "devnum").read_text())))
    known = set()
    for device in backend.enumerate_devices():
        descriptor = backend.get_device_descriptor(device)
        known.add((descriptor.bus, descriptor.address))
    return present != known
