"""The cameras of a rig on ROS 2: a namespace each, whose images an exact synchroniser matches."""

from __future__ import annotations

import os
import queue
from contextlib import ExitStack
from typing import Any

import pytest

pytest.importorskip("rclpy", reason="ROS 2 is not installed: make setup-ros2")
pytest.importorskip("grabber_interfaces", reason="the interface package is not built: make setup-ros2")
pytestmark = pytest.mark.ros2

from grabbergui.net.ros2.runtime import Ros2Node, quality_of_service  # noqa: E402
from grabbergui.net.ros2.server import Ros2GrabberServer  # noqa: E402
from grabbergui.rig import source  # noqa: E402
from grabbergui.rig.rig_file import CameraEntry, RigEntry, TriggerEntry  # noqa: E402
from grabbergui.rig.served_cameras import ServedCameras  # noqa: E402
from patience import PATIENCE  # noqa: E402
from ros2_domain import own_domain  # noqa: E402

NAMES = ("left", "right", "top")
SETS = 8


@pytest.fixture
def served(monkeypatch: pytest.MonkeyPatch) -> Any:
    """A rig whose cameras are `/stereo/NAME`, and a node of somebody else."""
    for name, value in own_domain().items():
        monkeypatch.setitem(os.environ, name, value)
    with ExitStack() as stack:
        sources = {
            name: CameraEntry(f"sim:?width=64&height=48&fps=50&exposure=1000&serial={name}") for name in NAMES
        }
        rig = source.of_entry(RigEntry(sources, trigger=TriggerEntry("software", 20)))
        stack.callback(rig.close)
        rig.open()
        rig.start()
        cameras = ServedCameras(rig)
        stack.callback(cameras.close)
        cameras.start()
        for name, camera in cameras.cameras.items():
            stack.enter_context(Ros2GrabberServer(camera, f"/stereo/{name}", frame_id=name))
        listener = Ros2Node("listener")
        stack.callback(listener.close)
        yield listener


def test_images_of_a_set_have_equal_stamps(served: Ros2Node) -> None:
    from sensor_msgs.msg import Image

    arrived: queue.Queue[tuple[str, int]] = queue.Queue()
    for name in NAMES:
        served.node.create_subscription(
            Image,
            f"/stereo/{name}/image_raw",
            lambda message, name=name: arrived.put((name, stamp_of(message))),
            quality_of_service("reliable"),
        )
    served.start()
    stamps: dict[str, set[int]] = {name: set() for name in NAMES}
    while len(set.intersection(*stamps.values())) < SETS:
        name, stamp = arrived.get(timeout=PATIENCE)
        stamps[name].add(stamp)


def test_message_filters_match_them_exactly(served: Ros2Node) -> None:
    message_filters = pytest.importorskip("message_filters", reason="ROS's message_filters are not installed")
    from sensor_msgs.msg import Image

    matched: queue.Queue[tuple[Any, ...]] = queue.Queue()
    subscribers = [
        message_filters.Subscriber(
            served.node, Image, f"/stereo/{name}/image_raw", qos_profile=quality_of_service("reliable")
        )
        for name in NAMES
    ]
    message_filters.TimeSynchronizer(subscribers, 10).registerCallback(lambda *all_of: matched.put(all_of))
    served.start()
    for _ in range(SETS):
        images = matched.get(timeout=PATIENCE)
        assert [image.header.frame_id for image in images] == list(NAMES)
        assert len({stamp_of(image) for image in images}) == 1


def stamp_of(message: Any) -> int:
    return int(message.header.stamp.sec * 1_000_000_000 + message.header.stamp.nanosec)
