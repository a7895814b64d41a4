"""Topics of the further components of a frame: range, confidence, points."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from grabbergui.core.component import Component
from grabbergui.core.coord3d import Scan3d
from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import FrameSink
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.point_cloud import PointCloud
from grabbergui.core.scan3d import CurrentScan3d
from grabbergui.net.component_joiner import MOST_COMPONENTS, components_of
from grabbergui.net.distances import in_metres
from grabbergui.net.ros2.compressed_images import COMPRESSED_DEPTH, PNG_LEVEL, fill_depth, is_depth
from grabbergui.net.ros2.image_messages import message_bytes
from grabbergui.net.ros2.image_writer import ImageWriter

_FIELDS = (("x", 0), ("y", 4), ("z", 8), ("rgb", 12))
_POINT = np.dtype([("position", "<f4", (3,)), ("rgb", "<u4")])
_MILLIMETRES = np.float32(1000)

Stamp = Callable[[Any, Frame], None]
"""Fills a message's header for a frame."""


class ComponentTopics:
    """Each further image of the frames, with its camera_info, as `range/image`.

    Range images are 32FC1 in metres, NaN where nothing was measured (REP 118); a camera that reports no scale
    has its own values in `16UC1` or whatever fits. `range/points` are in metres, x to the right, y down, z
    forward (REP 103's optical frame), with the brightness of an intensity image of the same size. A topic
    without subscribers is neither converted nor sent.
    """

    def __init__(
        self,
        node: Any,
        grabber: FrameGrabber,
        publisher: Callable[[Any, str], Any],
        stamp: Stamp,
        camera_info: Callable[[Frame, Frame], Any],
        count: Callable[[Any, int], None],
        enabled: Callable[[], bool],
    ) -> None:
        """`publisher` makes one for a message type and a topic; `stamp` fills headers.

        `camera_info` returns the message for a frame's component. `count` notes the bytes that a publisher
        sent. Nothing is sent unless `enabled`.
        """
        from sensor_msgs.msg import CameraInfo, CompressedImage, Image, PointCloud2, PointField

        self._compressed_type = CompressedImage
        self._image_type, self._info_type = Image, CameraInfo
        self._cloud_type, self._field_type = PointCloud2, PointField
        self._publisher, self._stamp, self._camera_info = publisher, stamp, camera_info
        self._count, self._enabled = count, enabled
        self._scan = CurrentScan3d(grabber)
        self._writer = ImageWriter()
        self._topics: dict[str, tuple[Any, Any]] = {}
        "Publishers of the image and its camera_info, by component."
        self._depths: dict[str, Any] = {}
        "Publishers of `compressedDepth`, by component."
        self._points: Any = None
        self._sink = FrameSink(grabber, self._publish, name="ros2 components", reopens=True)

    def start(self) -> None:
        """Publish from now on."""
        self._sink.start()

    def stop(self) -> None:
        """End the thread. May be called twice."""
        self._sink.stop()
        self._scan.close()

    @property
    def topics(self) -> list[str]:
        """The topics of images and points so far. Any thread."""
        images = [publisher for publisher, _ in list(self._topics.values())] + list(self._depths.values())
        return [publisher.topic_name for publisher in (*images, self._points) if publisher is not None]

    def _publish(self, frame: Frame) -> bool:
        """Publish on the topics that have subscribers; return whether there was one."""
        if not self._enabled() or not (frame.parts or frame.pixel_format.is_coordinate):
            return False
        sent = False
        for name, part in components_of(frame):
            images, infos = self._of_component(name)
            if images is not None and images.get_subscription_count():
                message = self._image_type()
                self._stamp(message.header, frame)
                image = in_metres(frame.of_component(part), self._scan.value)
                self._count(images, self._writer.publish([images], message, image))
                sent = True
            if images is not None and part.pixel_format.is_coordinate:
                sent = self._publish_compressed(name, frame, part) or sent
            if infos is not None and infos.get_subscription_count():
                message = self._camera_info(frame, frame.of_component(part))
                self._stamp(message.header, frame)
                infos.publish(message)
                sent = True
            if part.pixel_format.is_coordinate and self._points is None:
                self._points = self._publisher(self._cloud_type, "~/range/points")
        if self._points is not None and self._points.get_subscription_count():
            message = self._cloud(frame, self._scan.value)
            self._stamp(message.header, frame)
            self._points.publish(message)
            self._count(self._points, len(message.data))
            sent = True
        return sent

    def _publish_compressed(self, name: str, frame: Frame, part: Component) -> bool:
        """Publish distances on `compressedDepth` if anybody subscribes; return whether that was so."""
        if name not in self._depths:
            self._depths[name] = self._publisher(self._compressed_type, f"~/{name}/image/{COMPRESSED_DEPTH}")
        depths = self._depths[name]
        if not depths.get_subscription_count():
            return False
        image = in_metres(frame.of_component(part), self._scan.value)
        if is_depth(image):
            message = self._compressed_type()
            self._stamp(message.header, frame)
            fill_depth(message, image, PNG_LEVEL)
            depths.publish(message)
            self._count(depths, len(message.data))
        return True

    def _of_component(self, name: str) -> tuple[Any, Any]:
        if name not in self._topics and len(self._topics) < MOST_COMPONENTS:
            kinds = (self._image_type, "image"), (self._info_type, "camera_info")
            images, infos = (self._publisher(kind, f"~/{name}/{topic}") for kind, topic in kinds)
            self._topics[name] = images, infos
        return self._topics.get(name, (None, None))

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
