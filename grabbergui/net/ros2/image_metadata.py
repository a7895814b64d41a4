"""Publishes what is known of each image beside it: exposure time, gain, temperature, numbers, chunk data.

ROS has no message for it that all drivers share. A `diagnostic_msgs/DiagnosticArray` can be shown and
recorded everywhere; its header is that of the image, by which subscribers join the two.
"""

from __future__ import annotations

import threading
import time
from typing import Any

from grabbergui.core.errors import GrabberError
from grabbergui.core.features import Feature, format_value
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.sfnc import Role
from grabbergui.net.ros2.runtime import sendable

ROLES = (Role.EXPOSURE, Role.GAIN, Role.FRAME_RATE, Role.TEMPERATURE)
"""Features that are reported under the camera's names for them."""
REREAD = 1.0
"""Seconds after which a value that the camera does not report to have changed is read again."""


class FrameMetadata:
    """Returns the metadata of frames. `of` on one thread, which may wait for the camera once a second.

    Chunk data (`ChunkExposureTime`) are exactly of the image; the features' values are those set at the time.
    """

    def __init__(self, grabber: FrameGrabber) -> None:
        self._grabber = grabber
        self._values: dict[str, str] = {}
        self._read_at = 0.0
        self._changed = threading.Event()
        self._listening = False

    def close(self) -> None:
        """Release the grabber. May be called twice."""
        self._grabber.features_changed.disconnect(self._on_features_changed, missing_ok=True)

    def of(self, frame: Frame) -> dict[str, str]:
        """Return names and values as text."""
        if not self._listening:
            self._listening = True
            self._grabber.features_changed.connect(self._on_features_changed, unique=True)
            self._changed.set()
        if self._changed.is_set() or time.monotonic() - self._read_at > REREAD:
            self._changed.clear()
            self._read()
        known = {
            "FrameID": str(frame.frame_id),
            "Timestamp": f"{frame.timestamp_ns} ns",
            "Status": frame.status.value,
            "MissingBytes": str(frame.missing_bytes),
            "PixelFormat": frame.pixel_format.name,
            "OffsetX": str(frame.offset_x),
            "OffsetY": str(frame.offset_y),
        }
        return known | self._values | {name: format_value(value) for name, value in frame.chunks.items()}

    def message(self, frame: Frame, title: str) -> Any:
        """Return the message, without its header."""
        from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

        level = DiagnosticStatus.OK if frame.complete else DiagnosticStatus.WARN
        values = [KeyValue(key=key, value=sendable(value)) for key, value in self.of(frame).items()]
        status = DiagnosticStatus(level=level, name=sendable(title), message=frame.status.value)
        status.hardware_id, status.values = sendable(self._grabber.info.serial), values
        return DiagnosticArray(status=[status])

    def _read(self) -> None:
        self._read_at = time.monotonic()
        names = [name for role in ROLES if (name := self._grabber.role(role)) is not None]
        try:
            features = self._grabber.read_features(names)
        except GrabberError:  # a lost camera: what was known is not of this image
            features = []
        self._values = {each.name: _text(each) for each in features if each.value is not None}

    def _on_features_changed(self, names: frozenset[str]) -> None:
        self._changed.set()


def _text(feature: Feature) -> str:
    return f"{feature.text} {feature.unit}".strip()
