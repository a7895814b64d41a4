"""Topics for the further components of a camera's frames: images, and point clouds of range images."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from grabbergui.core.frame import Frame
from grabbergui.core.frame_sink import FrameSink
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.point_cloud import PointCloud
from grabbergui.core.scan3d import CurrentScan3d, Scan3d, components_of, in_metres
from grabbergui.net.ros2.image_messages import filled, message_bytes

MOST_TOPICS = 16
"""A camera that names more components is not believed."""
_FIELDS = (("x", 0), ("y", 4), ("z", 8), ("rgb", 12))
_POINT = np.dtype([("position", "<f4", (3,)), ("rgb", "<u4")])
_MILLIMETRES = np.float32(1000)

Stamp = Callable[[Any, Frame], None]
"""Fills a message's header for a frame."""


class ComponentTopics:
    """`range/image`, `confidence/image` …, and `range/points`, below the node's name, when frames have them.

    Range images are 32FC1 in metres, NaN where nothing was measured (REP 118); a camera that reports no scale
    has its own values in `16UC1` or whatever fits. Points are in metres, x to the right, y down, z forward
    (REP 103's optical frame), with the brightness of an intensity image of the same size. A topic without
    subscribers is neither converted nor sent.
    """

    def __init__(
        self, node: Any, grabber: FrameGrabber, publisher: Callable[[Any, str], Any], stamp: Stamp
    ) -> None:
        """`publisher` makes one for a message type and a topic; `stamp` fills headers."""
        from sensor_msgs.msg import Image, PointCloud2, PointField

        self._image_type, self._cloud_type, self._field_type = Image, PointCloud2, PointField
        self._publisher, self._stamp = publisher, stamp
        self._scan = CurrentScan3d(grabber)
        self._images: dict[str, Any] = {}
        self._points: Any = None
        self._sink = FrameSink(grabber, self._publish, name="ros2 components", reopens=True)

    def start(self) -> None:
        """Publish from now on."""
        self._sink.start()

    def stop(self) -> None:
        """End the thread. May be called twice."""
        self._sink.stop()
        self._scan.close()

    def _publish(self, frame: Frame) -> bool:
        """Publish what is subscribed to; return whether anything was."""
        if not frame.parts and not frame.pixel_format.is_coordinate:
            return False
        sent = False
        for name, part in components_of(frame):
            topic = self._topic(name)
            if topic is not None and topic.get_subscription_count():
                message = filled(self._image_type(), in_metres(frame.of_component(part), self._scan.value))
                self._stamp(message.header, frame)
                topic.publish(message)
                sent = True
            if part.pixel_format.is_coordinate and self._points is None:
                self._points = self._publisher(self._cloud_type, "~/range/points")
        if self._points is not None and self._points.get_subscription_count():
            message = self._cloud(frame, self._scan.value)
            self._stamp(message.header, frame)
            self._points.publish(message)
            sent = True
        return sent

    def _topic(self, name: str) -> Any:
        if name not in self._images and len(self._images) < MOST_TOPICS:
            self._images[name] = self._publisher(self._image_type, f"~/{name}/image")
        return self._images.get(name)

    def _cloud(self, frame: Frame, scan: Scan3d) -> Any:
        cloud = PointCloud.of(frame, scan)
        points = np.empty(len(cloud.points), _POINT)
        points["position"] = cloud.points / _MILLIMETRES
        points["rgb"] = 0
        if cloud.colours is not None:
            red, green, blue = cloud.colours.T.astype(np.uint32)
            points["rgb"] = red << 16 | green << 8 | blue
        message = self._cloud_type()
        message.height, message.width = 1, len(points)
        names = _FIELDS if cloud.colours is not None else _FIELDS[:3]
        float32 = self._field_type.FLOAT32
        message.fields = [
            self._field_type(name=name, offset=offset, datatype=float32, count=1) for name, offset in names
        ]
        message.is_bigendian, message.is_dense = False, True
        message.point_step, message.row_step = _POINT.itemsize, points.nbytes
        message.data = message_bytes(points)
        return message
