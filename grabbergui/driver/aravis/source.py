"""`aravis:` sources: `aravis:` the first found, `aravis:192.168.0.10`, `aravis:SERIAL`, `aravis:AravisID`."""

from __future__ import annotations

import os

from grabbergui.core.grabber import DeviceInfo, FrameGrabber
from grabbergui.core.uri import NoOptions, SourceUri, read_options
from grabbergui.driver.aravis.device import AravisDevice
from grabbergui.driver.aravis.library import find_cameras, load
from grabbergui.driver.camera import Camera

SEARCH = "GRABBERGUI_ARAVIS"
"""Environment variable: set to 1, searches list what Aravis sees too, beside our own finds of the same."""


def create(uri: SourceUri) -> FrameGrabber:
    """The camera that a URI names, not yet opened. Raises UsageError, SourceUnavailableError."""
    read_options(NoOptions, uri)
    load()
    info = DeviceInfo(str(uri), bus="Aravis", address=uri.name)
    return Camera(AravisDevice(uri.name, info))


def discover(timeout: float) -> list[DeviceInfo]:
    """Return the cameras that Aravis finds, if `SEARCH` is set. Takes a second, whatever the `timeout`."""
    if os.environ.get(SEARCH, "") in ("", "0"):
        return []
    return [camera.info() for camera in find_cameras()]
