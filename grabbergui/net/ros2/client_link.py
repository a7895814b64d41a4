"""The node behind an image topic: found among the topic's publishers, asked by its services."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from grabbergui.core.errors import DeviceLostError, FrameTimeoutError
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.ros_image import COMPRESSED_ENDS
from grabbergui.net.remote_grabber import RemoteFeatures, reached_by
from grabbergui.net.ros2.parameter_features import NoFeatures, ParameterFeatures
from grabbergui.net.ros2.requirements import require_interfaces
from grabbergui.net.ros2.runtime import DISCOVERY_S
from grabbergui.net.tree import TreeFeatures, error_of, loads, read_info

SERVICE_TIMEOUT = DISCOVERY_S
"""Seconds that a service has to appear once its node has."""
SETTLED = 1.0
"""Seconds without a change after which the list of a node's services counts as complete for now. A lost
message of the discovery is repeated after 3 s, so the grabber looks again."""
FIRST_ANSWER = 2.0
"""Seconds for the first answer of another driver, which may never answer."""
CALL_TIMEOUT = 7.0
"""Seconds for one answer; a command may take five in the camera."""
POLL_TIMEOUT = 0.8
"""Seconds for one answer to a poll, and for any of a node that stopped answering."""
_POLLED = frozenset({"hello", "changes"})
_LOOK_PERIOD = 0.1
"""Seconds between checks whether a service that owes us an answer is still there, and whether we close."""
_ASK_AGAIN = 1.0
"""Seconds after which a service that never answered is asked again."""
_ASK_TYPE = "grabber_interfaces/srv/Ask"

IMAGE_TYPE = "sensor_msgs/msg/Image"
COMPRESSED_TYPE = "sensor_msgs/msg/CompressedImage"
IMAGE_TYPES = (IMAGE_TYPE, COMPRESSED_TYPE)
_NAMELESS = "_NODE_NAME_UNKNOWN_"
"""The node name that rmw reports for a publisher whose node is not known yet."""


@dataclass(frozen=True)
class Publisher:
    """One publisher of a topic."""

    node: str
    "Full name of its node; empty while that is not known."
    topic_type: str
    reliable: bool
    durable: bool
    "Whether it keeps its last messages for late subscribers (transient local)."

    @property
    def quality(self) -> str:
        """Its quality of service as display text."""
        return (
            f"{'reliable' if self.reliable else 'best effort'}, "
            f"{'transient local' if self.durable else 'volatile'}"
        )

    def __str__(self) -> str:
        return f"{self.node or 'a nameless node'} ({self.quality})"


def publishers_of(node: Any, topic: str) -> list[Publisher]:
    """Return the publishers that are known at the moment, in order of their nodes."""
    from rclpy.qos import DurabilityPolicy, ReliabilityPolicy

    found = (
        Publisher(
            "" if _NAMELESS in info.node_name else f"{info.node_namespace.rstrip('/')}/{info.node_name}",
            info.topic_type,
            info.qos_profile.reliability == ReliabilityPolicy.RELIABLE,
            info.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL,
        )
        for info in node.get_publishers_info_by_topic(topic)
    )
    return sorted(found, key=str)


def topics_of(name: str) -> list[str]:
    """Return the topics that a camera's name may mean, best first: plain images before compressed ones."""
    plain = [f"{name}/image_raw", f"{name}/image", name]
    return [*plain, *(f"{topic}{end}" for topic in plain for end in COMPRESSED_ENDS)]


def not_found(node: Any, name: str) -> str:
    """Return why there is no camera of this name, as display text."""
    topics = topics_of(name)
    for topic in topics:
        for publisher in publishers_of(node, topic):
            if publisher.topic_type not in IMAGE_TYPES:
                return f"{topic} carries {publisher.topic_type}, not {IMAGE_TYPE}; name a topic of images"
    return f"nobody publishes images at {' or '.join(topics[:3])}; check the name and ROS_DOMAIN_ID"


class CameraLink:
    """A topic of images and the node that publishes it. One thread at a time, except `published`.

    Once `closing` is set, all waiting ends with DeviceLostError.
    """

    def __init__(self, node: Any, topic: str, publisher: Publisher, closing: threading.Event) -> None:
        self.node = node
        "Our own node, by which everything is asked."
        self.topic = topic
        self.publisher = publisher
        "As it was when it was found."
        self.features: RemoteFeatures = NoFeatures()
        "The features of the camera; none before `join`."
        self.silence = ""
        "Reason for which no value can be set, as display text; empty if values can be set."
        self._closing = closing
        self._clients: dict[str, Any] = {}
        self._answered: set[str] = set()
        "Names of services that have answered."
        self._polls: frozenset[str] = frozenset()
        "Verbs that are asked again and again from now on: their first answer has come."
        self._unanswered_since: float | None = None
        "When the first request was sent that has no answer yet, nor any after it (`time.monotonic`)."
        self._events: Any = None

    @classmethod
    def find(cls, node: Any, topics: Sequence[str], closing: threading.Event) -> CameraLink | None:
        """Return the first of the topics that is published, if any is yet.

        A publisher with a known node goes first: it is seen before the node's name is.
        """
        for topic in topics:
            found = [each for each in publishers_of(node, topic) if each.topic_type in IMAGE_TYPES]
            if found:
                return cls(node, topic, next((each for each in found if each.node), found[0]), closing)
        return None

    def rivals(self, topics: Sequence[str]) -> list[str]:
        """Return those of the topics that other nodes publish. Never waits."""
        known = {each.node for each in publishers_of(self.node, self.topic)}
        return [
            topic
            for topic in topics
            for each in publishers_of(self.node, topic)
            if each.node and each.node not in known and each.topic_type == IMAGE_TYPE
        ]

    def join(self, on_change: Callable[[frozenset[str]], None]) -> None:
        """Find out what can be set. Raises SourceUnavailableError; of our own servers DeviceLostError too.

        A node that answers nothing is an image without controls. `on_change` is called with the names of
        features that others set, on our node's thread, where the remote node publishes it.
        """
        if self._ours():
            require_interfaces()
            self.features = TreeFeatures(self._ask)
            return
        try:
            if not self._offered("list_parameters") or self._client("list_parameters") is None:
                self.silence = "offers no parameters"
                return
            self.features = features = ParameterFeatures(self._call_parameters)
        except (FrameTimeoutError, DeviceLostError) as error:
            self.silence = f"does not answer ({error})"
            return
        self._follow(features, on_change)

    def leave(self) -> None:
        """Forget the node's services. May be called twice."""
        clients, self._clients = self._clients, {}
        for client in filter(None, clients.values()):
            self.node.destroy_client(client)
        if self._events is not None:
            self.node.destroy_subscription(self._events)
            self._events = None

    def published(self) -> bool:
        """Return whether the topic has a publisher. Any thread; never waits."""
        return bool(self.node.count_publishers(self.topic))

    @property
    def ours(self) -> bool:
        """Whether the node is a server of ours, which has the whole feature tree. After `join`."""
        return isinstance(self.features, TreeFeatures)

    def described(self, info: DeviceInfo) -> DeviceInfo:
        """Return the camera's known properties, with the publisher and its quality of service."""
        seen = DeviceInfo(info.uri, bus="ROS 2", address=self.topic, interface=str(self.publisher))
        if not isinstance(self.features, TreeFeatures):
            return replace(seen, model=self.publisher.node)
        return reached_by(seen, read_info(self.features.look().get("info", {})))

    @property
    def unanswered(self) -> float:
        """Seconds since the first request that has no answer, nor any after it; 0 if the last has one."""
        return 0.0 if self._unanswered_since is None else time.monotonic() - self._unanswered_since

    def _ours(self) -> bool:
        """Wait for the node's services, at most until their list has settled; return whether one is ours."""
        if not self.publisher.node:
            return False
        changed, before = time.monotonic(), self._services()
        while True:
            offered = self._services()
            if _ASK_TYPE in offered.get(f"{self.publisher.node}/ask", ()):
                return True
            # Services are discovered one by one; our servers offer `ask` before their parameters.
            if f"{self.publisher.node}/list_parameters" in offered:
                return False
            if offered != before:
                changed, before = time.monotonic(), offered
            elif time.monotonic() - changed > SETTLED:
                return False
            self._pause(0.02)

    def _services(self) -> dict[str, Sequence[str]]:
        """Return the types of the services that the node is known to offer, by their names."""
        from rclpy.node import NodeNameNonExistentError

        namespace, _, name = self.publisher.node.rpartition("/")
        try:
            # By node: the list of all services includes those that have clients only, such as ours.
            return dict(self.node.get_service_names_and_types_by_node(name, namespace or "/"))
        except NodeNameNonExistentError:
            return {}

    def _offered(self, service: str) -> bool:
        return bool(self.publisher.node) and f"{self.publisher.node}/{service}" in self._services()

    def _ask(self, verb: str, *arguments: str) -> Any:
        from grabber_interfaces.srv import Ask

        if "ask" not in self._clients:
            self._clients["ask"] = self.node.create_client(Ask, f"{self.publisher.node}/ask")
            self._await_service(self._clients["ask"])
        client = self._clients["ask"]
        request = Ask.Request(verb=verb, arguments=list(arguments))
        answer = self._wait(client, request, POLL_TIMEOUT if verb in self._polls else CALL_TIMEOUT)
        self._polls |= _POLLED & {verb}
        if not answer.success:
            raise error_of(answer.error, answer.result, answer.feature)
        return loads(answer.result)

    def _call_parameters(self, service: str, request: Any) -> Any:
        client = self._client(service)
        if client is None:
            raise DeviceLostError(f"the node {self.publisher.node} offers no {service}")
        return self._wait(client, request, CALL_TIMEOUT if self._answered else FIRST_ANSWER)

    def _client(self, service: str) -> Any:
        """Return a client of one of the node's parameter services; None where it offers none."""
        if not self.publisher.node:
            return None
        if service not in self._clients:
            from rcl_interfaces import srv

            kind = getattr(srv, "".join(part.title() for part in service.split("_")))
            client = self.node.create_client(kind, f"{self.publisher.node}/{service}")
            if not self._await_service(client):
                self.node.destroy_client(client)
                client = None
            self._clients[service] = client
        return self._clients[service]

    def _wait(self, client: Any, request: Any, timeout: float = CALL_TIMEOUT) -> Any:
        """Return the answer to a request. Raises DeviceLostError once the service disappears or we close.

        A service may receive a request before it has discovered the reader of its answers, which are then
        lost. So a service that never answered is asked again: a first request may safely be repeated.

        Services of a killed program stay visible for 20 s. Only the first request in that time waits for all
        of `timeout`.
        """
        self._pause(0.0)
        done = threading.Event()
        futures = [self._send(client, request, done)]
        begun = time.monotonic()
        if self.unanswered > CALL_TIMEOUT:
            timeout = min(timeout, POLL_TIMEOUT)
        try:
            while not done.wait(_LOOK_PERIOD):
                passed = time.monotonic() - begun
                self._pause(0.0)
                if not client.service_is_ready():
                    raise DeviceLostError(f"{client.srv_name} is not available at the moment")
                if passed > timeout:
                    self._unanswered_since = self._unanswered_since or begun
                    raise FrameTimeoutError(f"{client.srv_name} did not answer within {timeout:g} s")
                if client.srv_name not in self._answered and passed > _ASK_AGAIN * len(futures):
                    futures.append(self._send(client, request, done))
        finally:
            for future in futures:
                if not future.done():
                    client.remove_pending_request(future)
        self._answered.add(client.srv_name)
        self._unanswered_since = None
        return next(future for future in futures if future.done()).result()

    def _await_service(self, client: Any) -> bool:
        """Wait for a service; return whether it is there within SERVICE_TIMEOUT. Raises DeviceLostError."""
        deadline = time.monotonic() + SERVICE_TIMEOUT
        while not (ready := client.service_is_ready()) and time.monotonic() < deadline:
            self._pause(0.02)
        return bool(ready)

    def _pause(self, seconds: float) -> None:
        """Wait. Raises DeviceLostError if the link is being closed."""
        if self._closing.wait(seconds):
            raise DeviceLostError(f"{self.topic} was closed")

    @staticmethod
    def _send(client: Any, request: Any, done: threading.Event) -> Any:
        future = client.call_async(request)
        future.add_done_callback(lambda _: done.set())
        return future

    def _follow(self, features: ParameterFeatures, on_change: Callable[[frozenset[str]], None]) -> None:
        from rcl_interfaces.msg import ParameterEvent
        from rclpy.qos import qos_profile_parameter_events

        def on_event(event: Any) -> None:
            if event.node == self.publisher.node:
                changed = (*event.new_parameters, *event.changed_parameters, *event.deleted_parameters)
                names = frozenset(parameter.name for parameter in changed)
                features.doubt(names)
                on_change(frozenset(filter(features.has, names)))

        self._events = self.node.create_subscription(
            ParameterEvent, "/parameter_events", on_event, qos_profile_parameter_events
        )
