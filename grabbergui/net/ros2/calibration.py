"""The calibration that a camera on ROS 2 tells of itself, on `camera_info` beside its pictures."""

from __future__ import annotations

import queue
import time
from typing import Any

from grabbergui.core.calibration import Calibration
from grabbergui.core.errors import SourceNotFoundError, UsageError
from grabbergui.net.ros2.camera_info import read_camera_info
from grabbergui.net.ros2.runtime import Ros2Node


def receive_calibration(camera: str, timeout: float = 15.0) -> Calibration:
    """Wait for one `sensor_msgs/CameraInfo` of a camera, named as itself or by its `image_raw`.

    Raises SourceNotFoundError where none comes within `timeout` seconds, UsageError where it is empty.
    """
    name, _, last = camera.partition("?")[0].rstrip("/").rpartition("/")
    topic = f"{name}/camera_info" if last.startswith("image") else f"{name}/{last}/camera_info"
    ros = Ros2Node(f"grabbergui_calibration_{time.time_ns() % 10**9}")
    try:
        from rclpy.qos import qos_profile_sensor_data
        from sensor_msgs.msg import CameraInfo

        messages: queue.Queue[Any] = queue.Queue()
        ros.node.create_subscription(CameraInfo, topic, messages.put, qos_profile_sensor_data)
        ros.start()
        try:
            return read_camera_info(messages.get(timeout=timeout), camera)
        except queue.Empty:
            raise SourceNotFoundError(f"nobody publishes {topic}; give --calibration FILE") from None
        except UsageError as error:
            raise UsageError(f"{topic}: {error}; give --calibration FILE") from error
    finally:
        ros.close()
