"""`u3v:` sources: `u3v:` (the first), `u3v:<serial>`, `u3v:<GUID>`, `u3v:<bus-port>`."""

from __future__ import annotations

from dataclasses import replace

from grabbergui.core.errors import SourceUnavailableError, UsageError
from grabbergui.core.grabber import DeviceInfo, FrameGrabber
from grabbergui.core.uri import SourceUri
from grabbergui.driver.camera import Camera
from grabbergui.driver.u3v.device import LARGEST_TRANSFER, TRANSFERS_IN_FLIGHT, U3vDevice
from grabbergui.driver.u3v.enumeration import find_cameras

SMALLEST_TRANSFER = 1024
MOST_IN_FLIGHT = 1024


def create(uri: SourceUri) -> FrameGrabber:
    """The camera that a URI names, not yet opened. Raises UsageError.

    Options: `transfer_size` (bytes of a bulk transfer, for controllers that lose data in long ones) and
    `transfers` (how many are kept in flight; 1 uses synchronous calls).
    """
    size = _number(uri, "transfer_size", LARGEST_TRANSFER, SMALLEST_TRANSFER, LARGEST_TRANSFER * 16)
    in_flight = _number(uri, "transfers", TRANSFERS_IN_FLIGHT, 1, MOST_IN_FLIGHT)
    device = U3vDevice(uri.name, largest_transfer=size, transfers_in_flight=in_flight)
    device.info = replace(device.info, uri=str(uri))
    return Camera(device)


def discover(timeout: float) -> list[DeviceInfo]:
    """Every camera on the USB buses; none where there is no libusb. Asks each for its names."""
    try:
        return [camera.info for camera in find_cameras()]
    except SourceUnavailableError:
        return []


def _number(uri: SourceUri, name: str, default: int, low: int, high: int) -> int:
    text = uri.option(name, str(default))
    if not text.isdecimal() or not low <= int(text) <= high:
        raise UsageError(f"{uri}: {name}={text}: a number from {low} to {high} is expected")
    return int(text)
