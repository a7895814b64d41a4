"""`v4l2:` sources: the first found, or `v4l2:/dev/video2`, `v4l2:SERIAL`, by bus or by the model's name."""

from __future__ import annotations

from grabbergui.core.grabber import DeviceInfo, FrameGrabber
from grabbergui.core.uri import NoOptions, SourceUri, read_options
from grabbergui.driver.camera import Camera
from grabbergui.driver.v4l2.device import V4l2Device
from grabbergui.driver.v4l2.video import find


def create(uri: SourceUri) -> FrameGrabber:
    """The webcam that a URI names, not yet opened. Raises UsageError."""
    read_options(NoOptions, uri)
    return Camera(V4l2Device(uri.name, DeviceInfo(str(uri), bus="V4L2", address=uri.name)))


def discover(timeout: float) -> list[DeviceInfo]:
    """Every video device of this computer."""
    return find()
