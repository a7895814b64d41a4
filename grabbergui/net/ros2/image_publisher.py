"""Publishes a grabber's frames as images, each kind only while somebody subscribes.

Further components of the frames have topics of their own: images, and point clouds of range images.
`ImageWriter` copies their pixels once, where rclpy does so three times.
"""

from __future__ import annotations

import functools
import logging
import threading
import time
from typing import Any
from weakref import WeakKeyDictionary

from grabbergui.calibration.fitting import FittedCalibration
from grabbergui.core.camera_info_message import fill_camera_info
from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import FrameSink
from grabbergui.core.grabber import FrameGrabber
from grabbergui.net.readers import Reader
from grabbergui.net.ros2.component_topics import ComponentTopics
from grabbergui.net.ros2.compressed_topics import CompressedTopics
from grabbergui.net.ros2.image_metadata import FrameMetadata
from grabbergui.net.ros2.image_writer import ImageWriter
from grabbergui.net.ros2.runtime import quality_of_service

log = logging.getLogger(__name__)

_NOT_YET_KNOWN = "_NODE_NAME_UNKNOWN_"
"""rmw's name of a node whose topics were discovered before the node itself."""


class ImagePublisher:
    """`image`, `image_raw`, `image_raw/compressed` and `camera_info` below the node's name.

    Frames with several components also have `ComponentTopics`.

    A thread of its own publishes the messages; the node's parameters `frame_id` and those of
    `CompressedTopics` apply. `camera_info` keeps its last message for late subscribers. A slow network drops
    frames here and does not affect the camera or other consumers.
    """

    def __init__(self, node: Any, grabber: FrameGrabber, qos: str, calibration: FittedCalibration) -> None:
        """`calibration` is adapted to each image and sent with it."""
        from diagnostic_msgs.msg import DiagnosticArray
        from sensor_msgs.msg import CameraInfo, Image

        self._calibration = calibration
        self._info_type = CameraInfo
        self.published = 0
        self.enabled = True
        "Whether frames are published. Any thread."
        self._traffic: dict[str, tuple[int, int]] = {}
        "Messages and their bytes by topic. Replaced, never changed, so that any thread may read it."
        self._node = node
        self._image_type = Image
        self._stamps = _Stamps(node.get_clock())

        def publisher(kind: Any, topic: str, *, latched: bool = False) -> Any:
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
                quality_of_service(qos, latched=latched),
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
        self._compressed = CompressedTopics(
            node, lambda last: _unless_remapped(node, f"~/image_raw/{last}", f"{raw}/{last}"), publisher
        )
        info = _unless_remapped(node, "~/camera_info", f"{place}/camera_info")
        self._info = publisher(CameraInfo, info, latched=True)
        metadata = _unless_remapped(node, "~/image_raw/metadata", f"{raw}/metadata")
        self._metadata = publisher(DiagnosticArray, metadata)
        self._described = FrameMetadata(grabber)
        self._title = node.get_fully_qualified_name()
        self._info_sent: object = None
        "Facts from which the last camera_info was made; a subscriber may come while no frame does."
        self._components = ComponentTopics(
            node, grabber, publisher, self._stamp, self._camera_info, self._count, lambda: self.enabled
        )
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
        self._described.close()

    def _publish(self, frame: Frame) -> bool:
        """Publish a frame; return whether anybody subscribes."""
        if not self.enabled:
            return False
        frame_id = self._node.get_parameter("frame_id").value
        stamp = self._stamps.of(frame)
        wanted = [publisher for publisher in self._images if publisher.get_subscription_count()]
        if wanted:
            message = self._image_type()
            _fill(message.header, stamp, frame_id)
            size = self._writer.publish(wanted, message, frame)
            self.published += 1
            for publisher in wanted:
                self._count(publisher, size)
        for publisher, message in self._compressed.messages(frame):
            _fill(message.header, stamp, frame_id)
            publisher.publish(message)
            self._count(publisher, len(message.data))
        informed = bool(self._info.get_subscription_count())
        about = (frame.width, frame.height, self._calibration.forms(frame), frame_id)
        if informed or about != self._info_sent:
            self._info_sent = about
            message = self._camera_info(frame)
            _fill(message.header, stamp, frame_id)
            self._info.publish(message)
        described = bool(self._metadata.get_subscription_count())
        if described:
            message = self._described.message(frame, self._title)
            _fill(message.header, stamp, frame_id)
            self._metadata.publish(message)
        return bool(wanted) or informed or described or self._compressed.wanted

    def _count(self, publisher: Any, size: int) -> None:
        images, total = self._traffic.get(publisher.topic_name, (0, 0))
        self._traffic = {**self._traffic, publisher.topic_name: (images + 1, total + size)}

    def readers(self) -> list[Reader]:
        """Return the subscribers of images; those of camera_info alone are left out. Any thread."""
        topics = [*(publisher.topic_name for publisher in self._images), *self._compressed.topics]
        return [
            Reader(_node_name(end), topic, "", *self._traffic.get(topic, (0, 0)))
            for topic in (*topics, *self._components.topics)
            for end in self._node.get_subscriptions_info_by_topic(topic)
            if end.node_name != _NOT_YET_KNOWN
        ]

    def _stamp(self, header: Any, frame: Frame) -> None:
        _fill(header, self._stamps.of(frame), self._node.get_parameter("frame_id").value)

    def _camera_info(self, frame: Frame, component: Frame | None = None) -> Any:
        """Return the camera_info; without a calibration its matrices are zero, ROS's "uncalibrated".

        A `component` has the frame's calibration if it has its size.
        """
        image = component or frame
        message = self._info_type(width=image.width, height=image.height)
        same_size = (image.width, image.height) == (frame.width, frame.height)
        forms = self._calibration.forms(frame) if same_size else None
        if forms is not None:
            fill_camera_info(message, forms)
        return message


def _node_name(end: Any) -> str:
    """Return the full name of an endpoint's node."""
    return f"{end.node_namespace.rstrip('/')}/{end.node_name}"


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
