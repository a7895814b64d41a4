"""Frames of an open camera."""

from __future__ import annotations

from grabbergui.core.frame import Frame
from grabbergui.driver.device_grabber import DeviceGrabber
from patience import PATIENCE

DEEP = 1000
"""Frames that a queue keeps, so that it drops none while its reader waits for a core."""


def grab(camera: DeviceGrabber, count: int) -> list[Frame]:
    """The first frames of a new stream, without a gap."""
    queue = camera.open_queue(DEEP)
    camera.start()
    try:
        return [queue.get(PATIENCE) for _ in range(count)]
    finally:
        camera.stop()
        queue.close()
