"""A camera on ROS 2 as a frame grabber: ours with its whole tree, anybody's by its topics and parameters.

The URI is `ros2:/camera`, or any image topic.
"""

from __future__ import annotations

import atexit
import functools
import logging
import os
import threading
import time
from collections.abc import Mapping, Sequence

from typing_extensions import override

from grabbergui.core.calibration import Calibration
from grabbergui.core.errors import (
    DeviceLostError,
    FrameTimeoutError,
    GrabberError,
    OtherCameraError,
    SourceNotFoundError,
    SourceUnavailableError,
    UsageError,
)
from grabbergui.core.grabber import Access, ConnectionState, FrameGrabber
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.ros_image import plain_topic
from grabbergui.core.uri import Ros2Options, SourceUri, read_options
from grabbergui.net.remote_grabber import RemoteFeatures, RemoteGrabber
from grabbergui.net.ros2.client_link import (
    IMAGE_TYPES,
    CameraLink,
    Publisher,
    not_found,
    publishers_of,
    topics_of,
)
from grabbergui.net.ros2.client_stream import ComponentSubscriptions, ImageStream
from grabbergui.net.ros2.requirements import require_ros2
from grabbergui.net.ros2.runtime import Ros2Node, full_name
from grabbergui.net.tree import TreeFeatures

log = logging.getLogger(__name__)

DISCOVERY_TIMEOUT = 5.0
"""Seconds that a topic has to appear."""
PREFERRED_TIMEOUT = 1.0
"""Seconds that `image_raw` has to appear, of this node or another, if `image` is discovered first."""
NAME_TIMEOUT = 1.0
"""Seconds that a publisher's node has to become known before it is opened without controls. One outside ROS
never does."""
LATE_CONTROLS = 20.0
"""Seconds after which controls that were not there on opening are not looked for any more."""
WATCH_PERIOD = 0.1
"""Seconds between polls of what others changed, while anybody listens, and of whether it is still there."""
POLLS_PER_CHECK = 10
"""Polls after which the publishers of the topic are checked again."""
SILENCE = 5.0
"""Seconds without an answer to a poll, nor an image, after which a server of ours counts as lost: longer than
a command takes in a camera. A killed program stays visible on the network for 20 s."""
OVERDUE = 0.7
"""The same for a server whose images arrived regularly before."""
_NETWORK = ("ROS_DOMAIN_ID", "ROS_AUTOMATIC_DISCOVERY_RANGE")
"""Environment variables that define which nodes discover each other."""


class Ros2Grabber(RemoteGrabber[ImageStream]):
    """An image topic, and the controls of the node behind it.

    `name` is an image topic, with or without its last part `/image_raw` or `/image`. It subscribes only while
    streaming, best effort unless `reliable`. Feature calls from any one thread at a time. After the loss of a
    publisher, a watcher thread finds it again with its current features.
    """

    def __init__(self, name: str, uri: str = "", *, reliable: bool = False, components: bool = True) -> None:
        """With `components`, frames also contain what a node of ours publishes as range/image …."""
        name = "/" + name.strip("/")
        super().__init__(DeviceInfo(uri or f"ros2:{name}", bus="ROS 2", address=name))
        self._name = name
        self._reliable = reliable
        self._with_components = components
        self._ros: Ros2Node | None = None
        self._link: CameraLink | None = None
        self._refused = ""
        "Why the present publisher is refused: another camera, or no answer. Empty if it is accepted."
        self._stream_lock = threading.RLock()
        "Guards the stream, and is never held while the other end is asked. Taken after `_lock`."
        self._rivals: set[str] = set()
        "Topics of its name that other nodes publish, as reported."
        self._opened_at = 0.0
        self._closing = threading.Event()
        self._watcher: threading.Thread | None = None

    @override
    def open(self, access: Access = Access.CONTROL) -> None:
        """Raises SourceUnavailableError without ROS 2."""
        if self._ros is not None:
            return
        self.connection_changed.emit(ConnectionState.OPENING, "")
        try:
            with self._lock:
                self._closing.clear()
                self._ros = Ros2Node(f"grabbergui_{time.time_ns() % 10**9}")
                self._ros.start()
                link = self._link = self._find(topics_of(self._name), DISCOVERY_TIMEOUT)
        except BaseException:
            self._leave()
            self.connection_changed.emit(ConnectionState.CLOSED, "")
            raise
        self._access, self._lost, self._refused = access, "", ""
        self._opened_at = time.monotonic()
        self._rivals.clear()
        self._watcher = threading.Thread(target=self._watch, name=f"ros2 watch {self._name}", daemon=True)
        self._watcher.start()
        self.connection_changed.emit(ConnectionState.OPEN, "")
        self.noticed.emit(f"{link.topic} comes from {link.publisher}")
        self._report_rivals()
        if link.silence:
            node = link.publisher.node or "its publisher"
            self.noticed.emit(f"{link.topic} is shown without controls: {node} {link.silence}")

    @override
    def close(self) -> None:
        """Leave the network. Ends whatever waits for the other end, `open` included."""
        if self._ros is None:
            return
        self._closing.set()
        watcher, self._watcher = self._watcher, None
        if watcher is not None and watcher is not threading.current_thread():
            watcher.join()
        self.stop()
        self._leave()
        self._fanout.close()
        self.connection_changed.emit(ConnectionState.CLOSED, "")

    def start(self, *, keep_trigger: bool = False) -> None:
        """Subscribe; the remote camera itself is not touched."""
        with self._stream_lock:
            if self._stream is None:
                self._fanout.clear()
                link = self._opened()
                components = None
                if self._with_components and link.ours:
                    components = ComponentSubscriptions(
                        link.node, plain_topic(link.topic), link.publisher.node, self, self._fanout.put
                    )
                self._stream = ImageStream(
                    link.node,
                    link.topic,
                    self._fanout.put,
                    self.noticed.emit,
                    reliable=self._reliable,
                    components=components,
                )
                if not self._refused:  # otherwise once our camera is back
                    self._stream.look()

    @override
    def calibration(self) -> Calibration | None:
        """Return the calibration from the topic's camera_info, while streaming."""
        stream = self._stream
        return stream.calibration() if stream is not None else None

    def _find(self, topics: Sequence[str], timeout: float) -> CameraLink:
        """Wait for one of the topics, and join the node that publishes it. Raises SourceNotFoundError."""
        assert self._ros is not None
        begun = time.monotonic()
        nameless: float | None = None
        node = self._ros.node
        while True:
            link, now = CameraLink.find(node, topics, self._closing), time.monotonic()
            if link is None:
                if now - begun > timeout:
                    raise SourceNotFoundError(not_found(node, self._name))
            elif not link.publisher.node:
                if now - (nameless := nameless or now) > NAME_TIMEOUT:
                    break
            elif link.topic not in (*topics[1:2], *topics[3:]) or now - begun > PREFERRED_TIMEOUT:
                break
            self._pause(0.05)
        try:
            link.join(self._announce)
            self._recognise(link.described(self.info))
            self._pause(0.0)  # `join` takes a node that is not waited for any more for one without controls
        except BaseException:
            link.leave()
            raise
        return link

    def _pause(self, seconds: float) -> None:
        """Wait. Raises DeviceLostError once `close` was called."""
        if self._closing.wait(seconds):
            raise DeviceLostError(f"{self._name} was closed")

    def _leave(self) -> None:
        with self._lock:  # until nobody uses the node, whose handles become invalid
            ros, self._ros = self._ros, None
            self._link = None
        if ros is not None:
            ros.close()

    def _opened(self) -> CameraLink:
        if self._link is None:
            raise DeviceLostError(f"{self.info.title} is not open")
        return self._link

    def _known(self) -> RemoteFeatures:
        return self._opened().features

    @override
    def _connected(self) -> RemoteFeatures:
        if self._refused:
            raise DeviceLostError(self._refused)
        return self._known()

    def _watch(self) -> None:
        present, polls = True, 0
        while not self._closing.wait(WATCH_PERIOD):
            polls += 1
            published = self._opened().published()
            try:
                if published and not present:
                    self._come_back()
                    present = True
                elif published:
                    self._poll(check=polls % POLLS_PER_CHECK == 0)
                elif present:
                    present = False
                    self._lose(f"nobody publishes {self._opened().topic} any more")
            except OtherCameraError as error:
                present = False
                self._refuse(str(error))
            except FrameTimeoutError as error:
                log.info("%s: %s", self._name, error)
                link = self._opened()
                if present and self._silent(link):
                    present = False
                    self._refuse(f"{link.publisher.node} does not answer any more")
            except GrabberError as error:  # as when `close` ends a request
                log.info("%s: %s", self._name, error)

    def _silent(self, link: CameraLink) -> bool:
        """Return whether a server that owes an answer is to be taken for lost."""
        stream = self._stream
        if stream is None:
            return link.unanswered > SILENCE
        return min(stream.idle, link.unanswered) > (OVERDUE if stream.regular else SILENCE)

    def _refuse(self, reason: str) -> None:
        """Accept neither images nor features until our camera is back, and answers."""
        with self._stream_lock:
            self._refused = reason
            if self._stream is not None:
                self._stream.pause()
        self._lose(reason)

    def _poll(self, *, check: bool) -> None:
        if check:
            self._look_at_stream()
            self._report_rivals()
            if self._opened().silence and time.monotonic() - self._opened_at < LATE_CONTROLS:
                self._look_for_controls()
        with self._lock:
            features = self._known()
            changed: frozenset[str] = frozenset()
            if isinstance(features, TreeFeatures):
                if len(self.features_changed):
                    changed = features.changes()
                # A killed server stays visible for 20 s, in which another may start.
                if check or features.missed:
                    self._recognise(self._opened().described(self.info))
            self._forget_seen(changed)
        self._report_camera(features)
        self._announce(changed)

    def _look_for_controls(self) -> None:
        """Use the node's services if they were discovered, or answer, only now."""
        old = self._opened()
        found = CameraLink.find(old.node, [old.topic], self._closing)
        if found is None or not found.publisher.node:
            return
        try:
            found.join(self._announce)
            if found.silence:
                found.leave()
                return
            self._recognise(found.described(self.info))
        except BaseException:
            found.leave()
            raise
        with self._lock, self._stream_lock:
            self._link = found
            old.leave()
            if found.ours and self._stream is not None:  # its components are to be received as well
                self.stop()
                self.start()
        self.connection_changed.emit(ConnectionState.OPEN, f"{found.topic} has its controls")
        self._announce(frozenset(description.name for description in self.feature_tree().descriptions()))

    def _come_back(self) -> None:
        """Reconnect to the present publisher. Raises OtherCameraError if that is another camera."""
        # Without the lock, so that others learn of the loss meanwhile.
        found = self._find([self._opened().topic], DISCOVERY_TIMEOUT)
        with self._lock:
            old, self._link = self._opened(), found
            old.leave()
            self._refused = ""
            if not (camera_lost := self._ask_for_loss()):
                self._compare_with_seen()
            self._look_at_stream()
        if camera_lost:
            self._lose(camera_lost)
        else:
            self._report_return()
        self._announce(frozenset(description.name for description in self.feature_tree().descriptions()))

    def _report_rivals(self) -> None:
        """Report each other camera of the same name once; DDS may discover it at any time."""
        for topic in self._opened().rivals(topics_of(self._name)):
            if topic not in self._rivals:
                self._rivals.add(topic)
                self.noticed.emit(f"{topic} is another node's: open ros2:{topic} to see it")

    def _look_at_stream(self) -> None:
        with self._stream_lock:
            if self._stream is not None:
                self._stream.look()

    def _announce(self, names: frozenset[str]) -> None:
        if names:
            self.features_changed.emit(names)


def create(uri: SourceUri) -> FrameGrabber:
    """Return the camera of a URI. Raises SourceUnavailableError without ROS 2, UsageError without a name."""
    require_ros2()
    if not uri.name.strip("/"):
        raise UsageError("ros2: which topic? Write ros2:/camera; `grabbergui list` shows the image topics")
    options = read_options(Ros2Options, uri)
    name = full_name(uri.name, str(uri))
    return Ros2Grabber(name, str(uri), reliable=options.qos == "reliable", components=options.components)


def discover(timeout: float = 1.0) -> list[DeviceInfo]:
    """List the image topics on the network; none, silently, if ROS 2 is not installed.

    ROS 2's discovery takes up to 3.5 s and does not report its end. The listening node stays open: the first
    call returns after `timeout` seconds, later ones at once with what has been discovered since.
    """
    try:
        require_ros2()
    except SourceUnavailableError:
        return []
    listener, opened = _listener(*map(os.environ.get, _NETWORK))
    time.sleep(max(opened + timeout - time.monotonic(), 0))
    node = listener.node
    found = {
        name: publishers_of(node, name)
        for name, types in node.get_topic_names_and_types()
        if not set(types).isdisjoint(IMAGE_TYPES)
    }
    return [
        DeviceInfo(
            f"ros2:{name}",
            model=name,
            bus="ROS 2",
            address=name,
            interface=" and ".join(map(str, publishers)),
        )
        for name, publishers in _cameras(found).items()
    ]


def _cameras(found: Mapping[str, list[Publisher]]) -> dict[str, list[Publisher]]:
    """Return image topics as cameras: the two of one node are one camera, those of two nodes are two."""
    cameras = {}
    for topic, publishers in sorted(found.items()):  # image_raw behind image, whose place it takes
        if (plain := plain_topic(topic)) != topic and not _stands_alone(topic, plain, found):
            continue
        name = topic.removesuffix("/image_raw").removesuffix("/image") or topic
        both = [found.get(f"{name}/{last}", ()) for last in ("image_raw", "image")]
        raw, image = ({each.node for each in publishers if each.node} for publishers in both)
        cameras[topic if raw and image and raw.isdisjoint(image) else name] = publishers
    return cameras


def _stands_alone(topic: str, plain: str, found: Mapping[str, list[Publisher]]) -> bool:
    """Return whether nobody publishes the same images plain, or as `compressed` beside `compressedDepth`."""
    return plain not in found and (topic == f"{plain}/compressed" or f"{plain}/compressed" not in found)


@functools.cache
def _listener(domain: str | None, reach: str | None) -> tuple[Ros2Node, float]:
    """Return a node that discovers one domain until the program ends, without a thread, and since when."""
    listener = Ros2Node(f"grabbergui_list_{time.time_ns() % 10**9}")
    atexit.register(listener.close)
    return listener, time.monotonic()
