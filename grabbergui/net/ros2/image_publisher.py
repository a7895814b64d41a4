"""Publishes a grabber's frames as images, each kind only while somebody subscribes.

Further components of the frames have topics of their own: images, and point clouds of range images.
`ImageWriter` copies their pixels once, where rclpy does so three times.
"""

from __future__ import annotations

import array
import ctypes
import functools
import logging
import sys
import threading
import time
from collections.abc import Callable, Sequence
from typing import Any
from weakref import WeakKeyDictionary

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.calibration.camera_info import FittedCalibration
from grabbergui.core.calibration import Scan3d
from grabbergui.core.errors import PixelFormatError
from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import FrameSink
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.pfnc import Family
from grabbergui.core.scan3d import CurrentScan3d, PointCloud
from grabbergui.net.component_joiner import MOST_COMPONENTS, components_of, in_metres
from grabbergui.net.ros2.image_messages import describe, fill_camera_info, message_bytes, pixels_of
from grabbergui.net.ros2.runtime import quality_of_service

log = logging.getLogger(__name__)

JPEG_QUALITY = "image_raw.compressed.jpeg_quality"
"""The node's parameter, named as image_transport's."""


class ImagePublisher:
    """`image`, `image_raw`, `image_raw/compressed` and `camera_info` below the node's name.

    Frames with several components also have `ComponentTopics`.

    A thread of its own publishes the messages; the node's parameters `frame_id` and `JPEG_QUALITY` apply. A
    slow network drops frames here and does not affect the camera or other consumers.
    """

    def __init__(self, node: Any, grabber: FrameGrabber, qos: str, calibration: FittedCalibration) -> None:
        """`calibration` is adapted to each image and sent with it."""
        from sensor_msgs.msg import CameraInfo, CompressedImage, Image

        self._calibration = calibration
        self._info_type = CameraInfo
        self.published = 0
        self._node = node
        self._image_type, self._compressed_type = Image, CompressedImage
        self._stamps = _Stamps(node.get_clock())

        def publisher(kind: Any, topic: str) -> Any:
            """Make a publisher with a configurable quality of service: qos_overrides.<topic>.publisher…."""
            from rclpy.event_handler import PublisherEventCallbacks, UnsupportedEventTypeError
            from rclpy.qos import qos_policy_name_from_kind
            from rclpy.qos_overriding_options import QoSOverridingOptions

            def on_incompatible(event: Any) -> None:
                policy = qos_policy_name_from_kind(event.last_policy_kind)
                log.warning(
                    "%s: a subscriber asks for more than is offered (%s) and gets nothing; %s",
                    node.resolve_topic_name(topic),
                    policy,
                    "offer it with --qos reliable or qos_overrides"
                    if policy == "RELIABILITY"
                    else "images are volatile, without deadline or liveliness: let it subscribe so",
                )

            create = functools.partial(
                node.create_publisher,
                kind,
                topic,
                quality_of_service(qos),
                qos_overriding_options=QoSOverridingOptions.with_default_policies(),
            )
            try:
                return create(event_callbacks=PublisherEventCallbacks(incompatible_qos=on_incompatible))
            except UnsupportedEventTypeError:  # not every middleware reports it
                return create()

        self._writer = ImageWriter()
        self._images = [publisher(Image, topic) for topic in ("~/image", "~/image_raw")]
        raw = node.resolve_topic_name("~/image_raw")
        place = raw.rpartition("/")[0]
        compressed = _unless_remapped(node, "~/image_raw/compressed", f"{raw}/compressed")
        self._compressed = publisher(CompressedImage, compressed)
        self._info = publisher(CameraInfo, _unless_remapped(node, "~/camera_info", f"{place}/camera_info"))
        self._components = ComponentTopics(node, grabber, publisher, self._stamp, self._camera_info)
        self._sink = FrameSink(grabber, self._publish, name="ros2 images", reopens=True)

    @property
    def dropped(self) -> int:
        """Number of frames received while the previous one was still being published."""
        return self._sink.dropped

    def start(self) -> None:
        """Publish from now on."""
        self._sink.start()
        self._components.start()

    def stop(self) -> None:
        """End the threads. May be called twice."""
        self._sink.stop()
        self._components.stop()

    def _publish(self, frame: Frame) -> bool:
        """Publish a frame; return whether anybody subscribes."""
        frame_id = self._node.get_parameter("frame_id").value
        stamp = self._stamps.of(frame)
        wanted = [publisher for publisher in self._images if publisher.get_subscription_count()]
        if wanted:
            message = self._image_type()
            _fill(message.header, stamp, frame_id)
            self._writer.publish(wanted, message, frame)
            self.published += 1
        if self._compressed.get_subscription_count():
            message = self._jpeg(frame)
            _fill(message.header, stamp, frame_id)
            self._compressed.publish(message)
        if self._info.get_subscription_count():
            message = self._camera_info(frame)
            _fill(message.header, stamp, frame_id)
            self._info.publish(message)
        return bool(wanted) or any(one.get_subscription_count() for one in (self._compressed, self._info))

    def _stamp(self, header: Any, frame: Frame) -> None:
        _fill(header, self._stamps.of(frame), self._node.get_parameter("frame_id").value)

    def _jpeg(self, frame: Frame) -> Any:
        message = self._compressed_type()
        mono = frame.pixel_format.family in (Family.MONO, Family.COORDINATES)
        image = frame.mono() if mono else cv2.cvtColor(frame.rgb(), cv2.COLOR_RGB2BGR)
        quality = self._node.get_parameter(JPEG_QUALITY).value
        done, encoded = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, quality])
        if not done:
            raise PixelFormatError(f"an image of {frame.width}×{frame.height} cannot be written as JPEG")
        # The encoding that image_transport's subscribers give the decoded image precedes that of the JPEG.
        encoding = "mono8" if mono else "bgr8"
        message.format = f"{encoding}; jpeg compressed {encoding}"
        message.data = array.array("B", encoded.tobytes())
        return message

    def _camera_info(self, frame: Frame, component: Frame | None = None) -> Any:
        """Return the camera_info; without a calibration its matrices are zero, ROS's "uncalibrated".

        A `component` has the frame's calibration if it has its size.
        """
        image = component or frame
        message = self._info_type(width=image.width, height=image.height)
        same_size = (image.width, image.height) == (frame.width, frame.height)
        calibration = self._calibration.of(frame) if same_size else None
        if calibration is not None:
            fill_camera_info(message, calibration)
        return message


def _unless_remapped(node: Any, topic: str, beside: str) -> str:
    """Return `beside`, which follows `image_raw` as in image_transport; `topic` if it is remapped itself."""
    own = topic.replace("~", node.get_fully_qualified_name())
    return beside if node.resolve_topic_name(topic) == own else topic


class _Stamps:
    """When frames were exposed, on ROS's clock, as seconds and nanoseconds. Thread-safe.

    With `use_sim_time` that clock is not the host's: it may stand, jump, or run at another rate. A frame
    keeps the stamp it was given first, since subscribers match image, components and camera_info by it.
    """

    def __init__(self, clock: Any) -> None:
        self._clock = clock
        self._lock = threading.Lock()
        self._given: WeakKeyDictionary[Frame, tuple[int, int]] = WeakKeyDictionary()

    def of(self, frame: Frame) -> tuple[int, int]:
        """Return the frame's stamp."""
        with self._lock:
            if (stamp := self._given.get(frame)) is None:
                stamp = self._given[frame] = divmod(self._on_ros_clock(frame.received_ns), 1_000_000_000)
            return stamp

    def _on_ros_clock(self, host_ns: int) -> int:
        if not self._clock.ros_time_is_active:
            return host_ns
        age = time.time_ns() - host_ns
        return max(0, int(self._clock.now().nanoseconds) - age)


def _fill(header: Any, stamp: tuple[int, int], frame_id: str) -> None:
    header.stamp.sec, header.stamp.nanosec = stamp
    header.frame_id = frame_id


# -- components ----------------------------------------------------------------------------------
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
    ) -> None:
        """`publisher` makes one for a message type and a topic; `stamp` fills headers.

        `camera_info` returns the message for a frame's component.
        """
        from sensor_msgs.msg import CameraInfo, Image, PointCloud2, PointField

        self._image_type, self._info_type = Image, CameraInfo
        self._cloud_type, self._field_type = PointCloud2, PointField
        self._publisher, self._stamp, self._camera_info = publisher, stamp, camera_info
        self._scan = CurrentScan3d(grabber)
        self._writer = ImageWriter()
        self._topics: dict[str, tuple[Any, Any]] = {}
        "Publishers of the image and its camera_info, by component."
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
        """Publish on the topics that have subscribers; return whether there was one."""
        if not frame.parts and not frame.pixel_format.is_coordinate:
            return False
        sent = False
        for name, part in components_of(frame):
            images, infos = self._of_component(name)
            if images is not None and images.get_subscription_count():
                message = self._image_type()
                self._stamp(message.header, frame)
                image = in_metres(frame.of_component(part), self._scan.value)
                self._writer.publish([images], message, image)
                sent = True
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
            sent = True
        return sent

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


# -- images without copies in between ------------------------------------------------------------
_LENGTH_BYTES = 4
"""Size of the length field in front of the pixels."""


class ImageWriter:
    """Publishes `sensor_msgs/msg/Image` with one copy of the pixels. One thread.

    rclpy copies an image three times, each time into new memory, while it holds the GIL, so that the camera's
    packets wait. Here rclpy serializes the message without pixels. They are written behind that, into memory
    that is kept, and rcl publishes all of it from there, without the GIL.
    """

    def __init__(self) -> None:
        self._rcl = _rcl()
        self._memory = np.empty(0, np.uint8)

    def publish(self, publishers: Sequence[Any], message: Any, frame: Frame) -> None:
        """Publish a frame in a message of which the caller has filled the header.

        Raises PixelFormatError for a format without encoding, and what rclpy's `publish` raises.
        """
        pixels, left = pixels_of(frame), publishers
        describe(message, frame, pixels)
        if self._rcl is not None and (serialized := self._serialized(message, pixels)) is not None:
            left = [publisher for publisher in publishers if not self._rcl.publish(publisher, serialized)]
        if left:  # rclpy raises the reason of a failure
            message.data = message_bytes(pixels)
            for publisher in left:
                publisher.publish(message)

    def _serialized(self, message: Any, pixels: NDArray[Any]) -> NDArray[np.uint8] | None:
        """Return the message in the memory that is kept; None if it does not end with its data."""
        from rclpy.serialization import serialize_message

        head: bytes = serialize_message(message)
        if head[-_LENGTH_BYTES:] != bytes(_LENGTH_BYTES):
            return None
        size = len(head) + pixels.nbytes
        if self._memory.size < size:
            self._memory = np.empty(size, np.uint8)
        serialized = self._memory[:size]
        start = head[:-_LENGTH_BYTES] + pixels.nbytes.to_bytes(_LENGTH_BYTES, sys.byteorder)
        serialized[: len(start)] = np.frombuffer(start, np.uint8)
        np.copyto(serialized[len(start) :].view(pixels.dtype).reshape(pixels.shape), pixels)
        return serialized


class _SerializedMessage(ctypes.Structure):
    """rcl_serialized_message_t; its allocator (five pointers) is not used for publishing."""

    _fields_ = (
        ("buffer", ctypes.c_void_p),
        ("length", ctypes.c_size_t),
        ("capacity", ctypes.c_size_t),
        ("allocator", ctypes.c_void_p * 5),
    )


class _Rcl:
    """The one function of rcl that rclpy offers only for `bytes`, of which it makes another copy."""

    def __init__(self, rcl: ctypes.CDLL, rcutils: ctypes.CDLL) -> None:
        self._publish = rcl.rcl_publish_serialized_message
        self._publish.argtypes = (ctypes.c_void_p, ctypes.POINTER(_SerializedMessage), ctypes.c_void_p)
        self._publish.restype = ctypes.c_int
        self._reset_error = rcutils.rcutils_reset_error
        self._reset_error.restype = None

    def publish(self, publisher: Any, serialized: NDArray[np.uint8]) -> bool:
        """Return whether rcl took the message; it has copied it by then."""
        message = _SerializedMessage(serialized.ctypes.data, serialized.size, serialized.size)
        with publisher.handle:  # keeps it from being destroyed
            if self._publish(publisher.handle.pointer, ctypes.byref(message), None) == 0:
                return True
        self._reset_error()
        return False


@functools.cache
def _rcl() -> _Rcl | None:
    """Return the library that rclpy has loaded, by its bare name; None if it has another name."""
    try:
        return _Rcl(ctypes.CDLL("librcl.so"), ctypes.CDLL("librcutils.so"))
    except (OSError, AttributeError):
        return None
