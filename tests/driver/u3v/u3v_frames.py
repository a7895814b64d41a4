"""Frames of an open camera."""

from __future__ import annotations

from grabbergui.core.frame import Frame
from grabbergui.driver.camera import Camera
from patience import PATIENCE


def grab(camera: Camera, count: int) -> list[Frame]:
    queue = camera.open_queue(count)
    camera.start()
    try:
        return [queue.get(PATIENCE) for _ in range(count)]
    finally:
        camera.stop()
        queue.close()
