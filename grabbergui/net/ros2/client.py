"""A camera on ROS 2 as a frame grabber: ours with its whole tree, anybody's by its topics and parameters."""

from __future__ import annotations

import logging
import threading
import time
from typing import Any

import numpy as np

from grabbergui.core.errors import (
    DeviceLostError,
    FrameTimeoutError,
    GrabberError,
    PixelFormatError,
    SourceNotFoundError,
)
from grabbergui.core.features import Category, Feature, FeatureValue
from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import RateMeter
from grabbergui.core.grabber import Access, ConnectionState, DeviceInfo, FrameGrabber, StreamStatistics
from grabbergui.net.feature_json import error_of, loads
from grabbergui.net.ros2.encodings import format_of
from grabbergui.net.ros2.parameter_features import ParameterFeatures
from grabbergui.net.ros2.runtime import Ros2Node, quality_of_service, require_interfaces
from grabbergui.net.tree_client import TreeFeatures

log = logging.getLogger(__name__)

IMAGE_TYPE = "sensor_msgs/msg/Image"
DISCOVERY_TIMEOUT = 3.0
"""Seconds that a topic has to appear."""
CALL_TIMEOUT = 7.0
WATCH_PERIOD = 0.1
"""Seconds between looks at what others changed, while anybody listens, and at whether it is still there."""


class Ros2Grabber(FrameGrabber):
    """An image topic, and the controls of the node behind it.

    `name` is a topic of images, or what stands before `/image_raw` or `/image` in one. It subscribes best
    effort, which matches every publisher, and only while streaming. Feature calls from any one thread at a
    time.
    """

    shared = True

    def __init__(self, name: str, uri: str = "") -> None:
        name = "/" + name.strip("/")
        super().__init__(DeviceInfo(uri or f"ros2:{name}", bus="ROS 2", address=name))
        self._name = name
        self._ros: Ros2Node | None = None
        self._topic = ""
        self._node_name = ""
        self._features: TreeFeatures | ParameterFeatures | None = None
        self._subscription: Any = None
        self._clients: dict[str, Any] = {}
        self._calls = threading.RLock()
        self._counters = StreamStatistics()
        self._rate = RateMeter()
        self._refused = ""
        self._watching = threading.Event()
        self._watcher: threading.Thread | None = None

    # -- connection ------------------------------------------------------------------------------
    def open(self, access: Access = Access.CONTROL) -> None:
        """See FrameGrabber. Raises SourceUnavailableError without ROS 2."""
        if self._ros is not None:
            return
        self.connection_changed.emit(ConnectionState.OPENING, "")
        self._ros = Ros2Node(f"grabbergui_{time.time_ns() % 10**9}")
        self._ros.start()
        try:
            self._topic, self._node_name = self._find_topic()
            self._features = self._find_features()
        except BaseException:
            self._leave()
            self.connection_changed.emit(ConnectionState.CLOSED, "")
            raise
        self._watching.set()
        self._watcher = threading.Thread(target=self._watch, name=f"ros2 watch {self._name}", daemon=True)
        self._watcher.start()
        self.connection_changed.emit(ConnectionState.OPEN, "")

    def close(self) -> None:
        """See FrameGrabber."""
        if self._ros is None:
            return
        self._watching.clear()
        watcher, self._watcher = self._watcher, None
        if watcher is not None:
            watcher.join()
        self.stop()
        self._leave()
        self._fanout.close()
        self.connection_changed.emit(ConnectionState.CLOSED, "")

    def _leave(self) -> None:
        ros, self._ros = self._ros, None
        self._features = None
        self._clients.clear()
        if ros is not None:
            ros.close()

    @property
    def access(self) -> Access:
        """See FrameGrabber."""
        return Access.CONTROL

    # -- features --------------------------------------------------------------------------------
    def feature_tree(self) -> Category:
        """See FrameGrabber."""
        return self._opened().tree

    def has_feature(self, name: str) -> bool:
        """See FrameGrabber."""
        return self._opened().has(name)

    def feature(self, name: str) -> Feature:
        """See FrameGrabber."""
        self._require(name)
        with self._calls:
            return self._opened().read(name)

    def write_feature(self, name: str, value: FeatureValue) -> Feature:
        """See FrameGrabber."""
        self._require(name)
        with self._calls:
            return self._opened().write(name, value)

    def execute(self, name: str) -> None:
        """See FrameGrabber."""
        self._require(name)
        with self._calls:
            self._opened().execute(name)

    # -- acquisition -----------------------------------------------------------------------------
    def start(self, *, keep_trigger: bool = False) -> None:
        """Subscribe; the remote camera itself is not touched."""
        from sensor_msgs.msg import Image

        if self._subscription is None:
            self._counters = StreamStatistics()
            self._rate.clear()
            self._fanout.clear()
            qos = quality_of_service("sensor_data")
            node = self._node()
            self._subscription = node.create_subscription(Image, self._topic, self._on_image, qos)

    def stop(self) -> None:
        """Unsubscribe."""
        subscription, self._subscription = self._subscription, None
        if subscription is not None and self._ros is not None:
            self._ros.node.destroy_subscription(subscription)

    @property
    def streaming(self) -> bool:
        """See FrameGrabber."""
        return self._subscription is not None

    def statistics(self) -> StreamStatistics:
        """See FrameGrabber."""
        counters = StreamStatistics(**self._counters.as_dict())
        counters.frame_rate, counters.bandwidth = self._rate.rates()
        return counters

    def _on_image(self, message: Any) -> None:
        try:
            frame = _frame(message, self._counters.frames + 1)
        except PixelFormatError as error:
            self._counters.incomplete += 1
            if str(error) != self._refused:
                self._refused = str(error)
                log.warning("%s: %s", self._topic, error)
            return
        self._counters.frames += 1
        self._counters.bytes += frame.payload.nbytes
        self._rate.add(frame.payload.nbytes)
        self._fanout.put(frame)

    # -- the other end ---------------------------------------------------------------------------
    def _find_topic(self) -> tuple[str, str]:
        """The image topic and the node that publishes it."""
        node = self._node()
        candidates = [f"{self._name}/image_raw", f"{self._name}/image", self._name]
        deadline = time.monotonic() + DISCOVERY_TIMEOUT
        while True:
            for topic in candidates:
                for publisher in node.get_publishers_info_by_topic(topic):
                    # A node is seen before its name is.
                    if (
                        publisher.topic_type == IMAGE_TYPE
                        and "_NODE_NAME_UNKNOWN_" not in publisher.node_name
                    ):
                        return topic, f"{publisher.node_namespace.rstrip('/')}/{publisher.node_name}"
            if time.monotonic() > deadline:
                raise SourceNotFoundError(
                    f"nobody publishes images at {' or '.join(candidates)}; check the name and ROS_DOMAIN_ID"
                )
            time.sleep(0.05)

    def _find_features(self) -> TreeFeatures | ParameterFeatures:
        if self._ours():
            require_interfaces()
            from grabber_interfaces.srv import Ask

            self._clients["ask"] = self._node().create_client(Ask, f"{self._name}/ask")
            self._clients["ask"].wait_for_service(DISCOVERY_TIMEOUT)
            hello = self._ask("hello").get("info", {})
            self.info = DeviceInfo(
                self.info.uri,
                vendor=str(hello.get("vendor", "")),
                model=str(hello.get("model", "")),
                serial=str(hello.get("serial", "")),
                bus="ROS 2",
                address=self._topic,
            )
            return TreeFeatures(self._ask)
        from rcl_interfaces.msg import ParameterEvent

        self.info = DeviceInfo(self.info.uri, model=self._node_name, bus="ROS 2", address=self._topic)
        self._node().create_subscription(ParameterEvent, "/parameter_events", self._on_parameter_event, 100)
        return ParameterFeatures(self._call_parameters)

    def _on_parameter_event(self, event: Any) -> None:
        if event.node == self._node_name:
            self._tell(frozenset(parameter.name for parameter in event.changed_parameters))

    def _ours(self) -> bool:
        services = dict(self._node().get_service_names_and_types())
        return f"{self._name}/ask" in services

    def _ask(self, verb: str, *arguments: str) -> Any:
        from grabber_interfaces.srv import Ask

        answer = self._wait(self._clients["ask"], Ask.Request(verb=verb, arguments=list(arguments)))
        if not answer.success:
            raise error_of(answer.error, answer.result, answer.feature)
        return loads(answer.result)

    def _call_parameters(self, service: str, request: Any) -> Any:
        kind = type(request)
        if service not in self._clients:
            from rcl_interfaces import srv

            name = "".join(part.title() for part in service.split("_"))
            client = self._node().create_client(getattr(srv, name), f"{self._node_name}/{service}")
            if not client.wait_for_service(DISCOVERY_TIMEOUT):
                raise DeviceLostError(f"the node {self._node_name} offers no {service}")
            self._clients[service] = client
        log.debug("%s %s", service, kind.__name__)
        return self._wait(self._clients[service], request)

    def _wait(self, client: Any, request: Any) -> Any:
        done = threading.Event()
        future = client.call_async(request)
        future.add_done_callback(lambda _: done.set())
        if not done.wait(CALL_TIMEOUT):
            client.remove_pending_request(future)
            raise FrameTimeoutError(f"{client.srv_name} did not answer within {CALL_TIMEOUT:g} s")
        return future.result()

    def _watch(self) -> None:
        there = True
        while self._watching.is_set():
            time.sleep(WATCH_PERIOD)
            here = self._node().count_publishers(self._topic) > 0
            if here != there:
                there = here
                state = ConnectionState.OPEN if here else ConnectionState.LOST
                self.connection_changed.emit(
                    state, "" if here else f"nobody publishes {self._topic} any more"
                )
                if here:
                    self._tell(frozenset(d.name for d in self._opened().tree.descriptions()))
            elif here and len(self.features_changed):
                self._look()

    def _look(self) -> None:
        try:
            features = self._opened()
            if isinstance(features, TreeFeatures):
                with self._calls:
                    self._tell(features.changes())
        except GrabberError as error:
            log.info("%s: %s", self._name, error)

    def _tell(self, names: frozenset[str]) -> None:
        if names:
            self.features_changed.emit(names)

    def _node(self) -> Any:
        if self._ros is None:
            raise DeviceLostError(f"{self.info.title} is not open")
        return self._ros.node

    def _opened(self) -> TreeFeatures | ParameterFeatures:
        if self._features is None:
            raise DeviceLostError(f"{self.info.title} is not open")
        return self._features


def _frame(message: Any, frame_id: int) -> Frame:
    """A message as a frame that looks into its bytes. Raises PixelFormatError for what cannot be shown."""
    pixel_format = format_of(message.encoding)
    payload = np.frombuffer(message.data, np.uint8)
    padding = message.step - pixel_format.line_bytes(message.width)
    if padding < 0 or message.step * message.height > payload.size or not message.width * message.height:
        raise PixelFormatError(
            f"an image of {message.width}×{message.height} {message.encoding} with lines of "
            f"{message.step} bytes and {payload.size} bytes in all contradicts itself"
        )
    stamp = message.header.stamp
    return Frame(
        payload=payload,
        width=message.width,
        height=message.height,
        pixel_format=pixel_format,
        frame_id=frame_id,
        received_ns=stamp.sec * 1_000_000_000 + stamp.nanosec or time.time_ns(),
        padding_x=padding,
        big_endian=bool(message.is_bigendian),
    )
