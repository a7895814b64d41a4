"""`ros2:` sources: `ros2:/camera`, or any image topic."""

from __future__ import annotations

import atexit
import functools
import os
import time

from grabbergui.core.errors import SourceUnavailableError, UsageError
from grabbergui.core.grabber import DeviceInfo, FrameGrabber
from grabbergui.core.uri import Ros2Options, SourceUri, read_options
from grabbergui.net.ros2.runtime import Ros2Node, require_ros2


def create(uri: SourceUri) -> FrameGrabber:
    """Return the camera of a URI. Raises SourceUnavailableError without ROS 2, UsageError without a name."""
    require_ros2()
    from grabbergui.net.ros2.client import Ros2Grabber

    if not uri.name.strip("/"):
        raise UsageError("ros2: which topic? Write ros2:/camera; `grabbergui list` shows the image topics")
    options = read_options(Ros2Options, uri)
    return Ros2Grabber(uri.name, str(uri), reliable=options.qos == "reliable", components=options.components)


def discover(timeout: float = 1.0) -> list[DeviceInfo]:
    """List the image topics on the network; none, silently, if ROS 2 is not installed.

    ROS 2's discovery takes a second or two and does not report its end. The listening node stays open, so a
    later call finds topics that an earlier one missed.
    """
    try:
        require_ros2()
    except SourceUnavailableError:
        return []
    from grabbergui.net.ros2.pictures import IMAGE_TYPE, publishers_of

    node = _listener(*map(os.environ.get, _NETWORK)).node
    deadline = time.monotonic() + timeout
    topics: list[str] = []
    while not topics and time.monotonic() < deadline:
        time.sleep(0.05)
        topics = [name for name, types in node.get_topic_names_and_types() if IMAGE_TYPE in types]
    # A camera that offers both names is one camera.
    cameras = {topic.removesuffix("/image_raw").removesuffix("/image") or topic: topic for topic in topics}
    return [
        DeviceInfo(
            f"ros2:{name}",
            model=name,
            bus="ROS 2",
            address=name,
            interface=" and ".join(map(str, publishers_of(node, topic))),
        )
        for name, topic in cameras.items()
    ]


_NETWORK = ("ROS_DOMAIN_ID", "ROS_AUTOMATIC_DISCOVERY_RANGE")
"""Environment variables that define which nodes discover each other."""


@functools.cache
def _listener(domain: str | None, reach: str | None) -> Ros2Node:
    """Hears who is there in one domain, without a thread of ours, until the program ends."""
    listener = Ros2Node(f"grabbergui_list_{time.time_ns() % 10**9}")
    atexit.register(listener.close)
    return listener
