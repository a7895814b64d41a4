"""Subscriptions to the topics of a camera's further components, and their images joined with the first."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from typing import Any

from grabbergui.core.errors import PixelFormatError
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.scan3d import FollowedScan3d, in_camera_units
from grabbergui.net.component_joiner import MOST_COMPONENTS, WAIT, ComponentJoiner, kind_of
from grabbergui.net.ros2.image_messages import frame_of
from grabbergui.net.ros2.pictures import IMAGE_TYPE
from grabbergui.net.ros2.runtime import quality_of_service

log = logging.getLogger(__name__)


class ComponentSubscriptions:
    """A best-effort subscription for each component topic of a camera, such as `range/image`.

    `image` and all callbacks run on the node's thread, which also delivers the frames; `look` and `close` on
    any one other thread.
    """

    def __init__(
        self, node: Any, topic: str, grabber: FrameGrabber, deliver: Callable[[Frame], None]
    ) -> None:
        """`topic` is the camera's first one; `grabber` reports what distances mean."""
        self._node = node
        self._prefix = topic.rpartition("/")[0]
        self._grabber = grabber
        self._deliver = deliver
        self._joiner = ComponentJoiner()
        self._subscriptions: dict[str, Any] = {}
        self._scan: FollowedScan3d | None = None
        self._timer = node.create_timer(WAIT / 2, self._expire, autostart=False)
        self._remarked: set[str] = set()

    def image(self, frame: Frame) -> None:
        """Deliver a frame once its components are there, or are not waited for any more."""
        now = time.monotonic()
        self._send(self._joiner.due(now) + self._joiner.image(frame, now))

    def look(self) -> None:
        """Subscribe to component topics that appeared. Those that are gone send nothing."""
        found = self._node.get_topic_names_and_types()
        names = {self._name_in(topic) for topic, types in found if IMAGE_TYPE in types}
        for name in sorted(name for name in names if name):
            if name not in self._subscriptions and len(self._subscriptions) < MOST_COMPONENTS:
                self._subscribe(name)

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
        name = topic.removeprefix(f"{self._prefix}/").removesuffix("/image")
        known = topic == f"{self._prefix}/{name}/image" and kind_of(name) is not None
        return name if known else ""

    def _subscribe(self, name: str) -> None:
        from sensor_msgs.msg import Image

        if self._scan is None:
            self._scan = FollowedScan3d(self._grabber)
        self._subscriptions[name] = self._node.create_subscription(
            Image,
            f"{self._prefix}/{name}/image",
            lambda message: self._on_image(name, message),
            quality_of_service("sensor_data"),
        )

    # -- on the node's thread ------------------------------------------------------------------------
    def _on_image(self, name: str, message: Any) -> None:
        try:
            frame = frame_of(message, 0)
            if self._scan is not None:
                frame = in_camera_units(frame, self._scan.value)
        except PixelFormatError as error:
            if str(error) not in self._remarked and len(self._remarked) < MOST_COMPONENTS:
                self._remarked.add(str(error))
                log.warning("%s/%s/image: %s", self._prefix, name, error)
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
