"""Stream of a remote camera: its image topic, those of its further components, and camera_info."""

from __future__ import annotations

import logging
import math
import time
from collections import deque
from collections.abc import Callable
from itertools import pairwise
from typing import Any

from grabbergui.core.calibration import Calibration
from grabbergui.core.camera_info_message import read_camera_info
from grabbergui.core.errors import GrabberError, PixelFormatError
from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import RateMeter, StreamStatistics
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.ros_image import plain_topic
from grabbergui.core.scan3d import FollowedScan3d
from grabbergui.net.component_joiner import MOST_COMPONENTS, WAIT, ComponentJoiner, kind_of
from grabbergui.net.distances import in_camera_units
from grabbergui.net.ros2.client_link import (
    COMPRESSED_TYPE,
    IMAGE_TYPE,
    IMAGE_TYPES,
    publishers_of,
)
from grabbergui.net.ros2.compressed_images import frame_of_compressed
from grabbergui.net.ros2.image_messages import Continuity, frame_of
from grabbergui.net.ros2.runtime import quality_of_service, steady_timer

log = logging.getLogger(__name__)
REMIND = 5.0
"""Seconds after which a lasting problem is reported again."""
REGULAR = 0.5
"""Longest seconds between two images after which the next is expected as soon."""
_SENDERS = 10
"""Number of the newest images whose publishers are compared."""


class ComponentSubscriptions:
    """A best-effort subscription for each component topic of a camera, such as `range/image`.

    `image` and all callbacks run on the node's thread, which also delivers the frames; `look` and `close` on
    any one other thread.
    """

    def __init__(
        self, node: Any, topic: str, publisher: str, grabber: FrameGrabber, deliver: Callable[[Frame], None]
    ) -> None:
        """`topic` is the camera's first one, `publisher` its node; `grabber` reports what distances mean."""
        self._node = node
        self._prefixes = (topic.rpartition("/")[0], publisher)  # not the same if `topic` is remapped
        self._grabber = grabber
        self._deliver = deliver
        self._joiner = ComponentJoiner()
        self._subscriptions: dict[str, Any] = {}
        self._scan: FollowedScan3d | None = None
        self._timer = steady_timer(node, WAIT / 2, self._expire, autostart=False)
        self._remarked: set[str] = set()

    def image(self, frame: Frame) -> None:
        """Deliver a frame once its components have arrived or their time is over."""
        now = time.monotonic()
        self._send(self._joiner.due(now) + self._joiner.image(frame, now))

    def look(self) -> None:
        """Subscribe to component topics that appeared. Those that are gone send nothing."""
        found = self._node.get_topic_names_and_types()
        topics = {self._name_in(topic): topic for topic, types in found if IMAGE_TYPE in types}
        for name, topic in sorted(topics.items()):
            if name and name not in self._subscriptions and len(self._subscriptions) < MOST_COMPONENTS:
                self._subscribe(name, topic)

    def close(self) -> None:
        """Unsubscribe. May be called twice."""
        subscriptions, self._subscriptions = self._subscriptions, {}
        for subscription in subscriptions.values():
            self._node.destroy_subscription(subscription)
        if self._timer is not None:
            timer, self._timer = self._timer, None
            self._node.destroy_timer(timer)
        if self._scan is not None:
            self._scan.close()

    def _name_in(self, topic: str) -> str:
        """Return the name of the component that a topic carries; empty for any other topic."""
        place, _, last = topic.rpartition("/")
        prefix, _, name = place.rpartition("/")
        return name if last == "image" and prefix in self._prefixes and kind_of(name) is not None else ""

    def _subscribe(self, name: str, topic: str) -> None:
        from sensor_msgs.msg import Image

        if self._scan is None:
            self._scan = FollowedScan3d(self._grabber)
        self._subscriptions[name] = self._node.create_subscription(
            Image,
            topic,
            lambda message: self._on_image(name, topic, message),
            quality_of_service("sensor_data"),
        )

    def _on_image(self, name: str, topic: str, message: Any) -> None:
        try:
            frame = frame_of(message, 0)
            if self._scan is not None:
                frame = in_camera_units(frame, self._scan.value)
        except PixelFormatError as error:
            if str(error) not in self._remarked and len(self._remarked) < MOST_COMPONENTS:
                self._remarked.add(str(error))
                log.warning("%s: %s", topic, error)
            return
        self._send(self._joiner.component(name, frame, time.monotonic()))

    def _expire(self) -> None:
        self._send(self._joiner.due(time.monotonic()))

    def _send(self, frames: list[Frame]) -> None:
        for frame in frames:
            self._deliver(frame)
        timer = self._timer
        if timer is None:
            return
        if self._joiner.deadline is None:
            timer.cancel()
        elif timer.is_canceled():
            timer.reset()


class _Senders:
    """Detects that images of several publishers alternate. A killed one stays listed, but sends none."""

    def __init__(self) -> None:
        self._newest: deque[bytes | None] = deque(maxlen=_SENDERS)

    def see(self, info: Any) -> None:
        """Note the publisher of an image, from rclpy's MessageInfo."""
        gid = info.get("publisher_gid")  # None before Kilted
        self._newest.append(None if gid is None else bytes(gid["data"]))

    @property
    def alternate(self) -> bool:
        """Whether the publishers changed more than once; True if they are not known."""
        newest = list(self._newest)
        changes = sum(first != second for first, second in pairwise(newest))
        return changes > 1 or None in newest


class ImageStream:
    """Receives one topic's images. Messages come on the node's thread, which also delivers the frames.

    It subscribes best effort, which every publisher can serve. If `reliable` is requested and a publisher
    cannot offer it, it reports that and falls back to best effort.
    """

    def __init__(
        self,
        node: Any,
        topic: str,
        deliver: Callable[[Frame], None],
        say: Callable[[str], None],
        *,
        reliable: bool = False,
        components: ComponentSubscriptions | None = None,
    ) -> None:
        """`say` is called with display text: why no images arrive, and how they changed.

        `components` adds what other topics of the camera carry.
        """
        self._components = components
        self._node = node
        self._topic = topic
        self._deliver = deliver
        self._say = say
        self._reliable = reliable
        self._subscribed: tuple[bool, bool] | None = None
        "Whether the subscription is reliable, and of compressed images."
        self._subscriptions: list[Any] = []
        self._counters = StreamStatistics()
        self._rate = RateMeter()
        self._read: Callable[[Any, int], Frame] = frame_of
        self._continuity = Continuity()
        self._senders = _Senders()
        self._last = (-math.inf, -math.inf)
        "Times (`time.monotonic`) of the last two images."
        self._reported: dict[str, float] = {}
        "Time (`time.monotonic`) of the last report, by its text or kind."
        self._info_key: object = None
        self._calibration: Calibration | None = None

    def close(self) -> None:
        """Unsubscribe. May be called twice."""
        self.pause()
        self._rate.clear()
        if self._components is not None:
            self._components.close()

    def pause(self) -> None:
        """Unsubscribe until the next `look`."""
        subscriptions, self._subscriptions = self._subscriptions, []
        for subscription in subscriptions:
            self._node.destroy_subscription(subscription)

    def calibration(self) -> Calibration | None:
        """Return the calibration of the newest camera_info."""
        return self._calibration

    def statistics(self) -> StreamStatistics:
        """Return a snapshot of the counters."""
        return self._counters.snapshot(self._rate)

    @property
    def idle(self) -> float:
        """Seconds since the last image; infinite before the first."""
        return time.monotonic() - self._last[1]

    @property
    def regular(self) -> bool:
        """Whether the last two images came within `REGULAR` seconds."""
        before, last = self._last
        return last - before < REGULAR

    def silence(self) -> str:
        """Return which publishers send no images, as display text."""
        publishers = publishers_of(self._node, self._topic)
        if not publishers:
            return f"nobody publishes {self._topic}"
        senders = " and ".join(map(str, publishers))
        return f"{self._topic} is subscribed to, and {senders} sends nothing that arrives here"

    def look(self) -> None:
        """Subscribe to match the topic's publishers, and log what does not fit. One thread at a time."""
        publishers = publishers_of(self._node, self._topic)
        images = [publisher for publisher in publishers if publisher.topic_type in IMAGE_TYPES]
        for other in publishers:
            if other.topic_type not in IMAGE_TYPES:
                self._remark(f"{other} publishes {other.topic_type} there, which is no image")
        if len(images) > 1 and self._senders.alternate:
            self._remark(f"{' and '.join(map(str, images))} publish on this topic: their images mix")
        unable = [publisher for publisher in images if not publisher.reliable]
        if self._reliable and unable:
            self._remark(f"{unable[0]} cannot send reliably; what gets lost is not sent again")
        reliable = self._reliable and not unable
        compressed = bool(images) and images[0].topic_type == COMPRESSED_TYPE
        wanted = (reliable, compressed) if images or self._subscribed is None else self._subscribed
        if wanted != self._subscribed or not self._subscriptions:
            self.pause()
            self._subscribe(*wanted)
        if self._components is not None:
            self._components.look()

    def _subscribe(self, reliable: bool, compressed: bool) -> None:
        from rclpy.event_handler import SubscriptionEventCallbacks, UnsupportedEventTypeError
        from sensor_msgs.msg import CameraInfo, CompressedImage, Image

        self._subscribed = reliable, compressed
        self._read = frame_of_compressed if compressed else frame_of
        qos = quality_of_service("reliable" if reliable else "sensor_data")

        def images(callbacks: Any) -> Any:
            return self._node.create_subscription(
                CompressedImage if compressed else Image,
                self._topic,
                self._on_image,
                qos,
                event_callbacks=callbacks,
            )

        events = SubscriptionEventCallbacks(
            incompatible_qos=self._on_incompatible, message_lost=self._on_lost, use_default_callbacks=False
        )
        try:
            subscription = images(events)
        except UnsupportedEventTypeError:  # not every middleware reports losses
            subscription = images(None)
        info_topic = f"{plain_topic(self._topic).rpartition('/')[0]}/camera_info"
        info = self._node.create_subscription(
            CameraInfo, info_topic, self._on_camera_info, quality_of_service("sensor_data")
        )
        self._subscriptions = [subscription, info]

    def _on_image(self, message: Any, info: Any) -> None:
        self._last = self._last[1], time.monotonic()
        self._senders.see(info)
        try:
            frame = self._read(message, self._counters.frames + 1)
        except PixelFormatError as error:
            self._counters.incomplete += 1
            self._remark(str(error), "unreadable")
            return
        self._counters.frames += 1
        self._counters.bytes += frame.payload.nbytes
        self._rate.add(frame.payload.nbytes)
        for kind, text in self._continuity.remarks(frame).items():
            self._remark(text, kind)
        if self._components is not None:
            self._components.image(frame)
        else:
            self._deliver(frame)

    def _on_camera_info(self, message: Any) -> None:
        region = message.roi
        key = (
            *(message.width, message.height, message.distortion_model, message.binning_x, message.binning_y),
            *(region.x_offset, region.y_offset, region.width, region.height),
            *(tuple(message.k), tuple(message.d), tuple(message.r), tuple(message.p)),
        )
        if key == self._info_key:
            return
        self._info_key = key
        try:
            self._calibration = read_camera_info(message, self._topic)
        except GrabberError as error:
            self._calibration = None
            if any(message.k):  # zeros mean "uncalibrated" and are no fault
                self._remark(str(error))

    def _on_incompatible(self, event: Any) -> None:
        from rclpy.qos import qos_policy_name_from_kind

        policy = qos_policy_name_from_kind(event.last_policy_kind)
        self._remark(f"a publisher's quality of service does not match ours ({policy}): no images arrive")

    def _on_lost(self, event: Any) -> None:
        self._counters.lost += event.total_count_change

    def _remark(self, text: str, kind: str = "") -> None:
        """Report a text, unless it or another of its kind was reported recently."""
        now, key = time.monotonic(), kind or text
        if now - self._reported.get(key, -REMIND) < REMIND:
            return
        recent = {each: when for each, when in self._reported.items() if now - when < REMIND}
        self._reported = {**recent, key: now}
        log.warning("%s: %s", self._topic, text)
        self._say(f"{self._topic}: {text}")
