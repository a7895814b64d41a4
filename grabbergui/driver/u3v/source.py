"""`u3v:` sources: `u3v:` (the first), `u3v:<serial>`, `u3v:<GUID>`, `u3v:<bus-port>`.

Its options are in `U3vOptions`.
"""

from __future__ import annotations

from dataclasses import replace

from grabbergui.core.errors import SourceUnavailableError
from grabbergui.core.grabber import DeviceInfo, FrameGrabber
from grabbergui.core.uri import SourceUri, U3vOptions, read_options
from grabbergui.driver.camera import Camera
from grabbergui.driver.u3v.device import U3vDevice
from grabbergui.driver.u3v.enumeration import find_cameras


def create(uri: SourceUri) -> FrameGrabber:
    """Return the camera that a URI names, not yet opened. Raises UsageError."""
    options = read_options(U3vOptions, uri)
    device = U3vDevice(
        uri.name, largest_transfer=options.transfer_size, transfers_in_flight=options.transfers
    )
    device.info = replace(device.info, uri=str(uri))
    return Camera(device)


def discover(timeout: float) -> list[DeviceInfo]:
    """Return every camera on the USB buses; none if there is no libusb. Asks each for its names."""
    try:
        return [camera.info for camera in find_cameras()]
    except SourceUnavailableError:
        return []
