"""`ros2:` sources: `ros2:/camera`, or any image topic."""

from __future__ import annotations

import time

from grabbergui.core.errors import SourceUnavailableError, UsageError
from grabbergui.core.grabber import DeviceInfo, FrameGrabber
from grabbergui.core.uri import SourceUri
from grabbergui.net.ros2.runtime import Ros2Node, require_ros2

DISCOVERY = 2.5
"""Seconds that participants may take to find each other; ROS 2 tells no end of it."""
SETTLING = 0.3


def create(uri: SourceUri) -> FrameGrabber:
    """The camera of a URI. Raises SourceUnavailableError without ROS 2, UsageError without a name."""
    require_ros2()
    from grabbergui.net.ros2.client import Ros2Grabber

    if not uri.name.strip("/"):
        raise UsageError("ros2: which topic? Write ros2:/camera; `grabbergui list` shows the image topics")
    return Ros2Grabber(uri.name, str(uri))


def discover(timeout: float = 1.0) -> list[DeviceInfo]:
    """Image topics on the network; none, silently, where ROS 2 is not installed."""
    try:
        require_ros2()
    except SourceUnavailableError:
        return []
    from grabbergui.net.ros2.client import IMAGE_TYPE

    ros = Ros2Node(f"grabbergui_list_{time.time_ns() % 10**9}")
    try:
        topics = _image_topics(ros, IMAGE_TYPE, max(timeout, DISCOVERY))
    finally:
        ros.close()
    # A camera that offers both names is one camera.
    names = dict.fromkeys(
        topic.removesuffix("/image_raw").removesuffix("/image") or topic for topic in topics
    )
    return [DeviceInfo(f"ros2:{name}", model=name, bus="ROS 2", address=name) for name in names]


def _image_topics(ros: Ros2Node, image_type: str, timeout: float) -> list[str]:
    """Topics of images; those that are there some moments after the first has come."""
    deadline = time.monotonic() + timeout
    topics: list[str] = []
    while time.monotonic() < deadline:
        time.sleep(0.1)
        found = [name for name, types in ros.node.get_topic_names_and_types() if image_type in types]
        if found and not topics:
            deadline = min(deadline, time.monotonic() + SETTLING)
        topics = found
    return topics
