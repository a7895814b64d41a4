"""Calibration on ROS 2: the message, the file that `camera_info_url` names, and that of a running camera.

The URLs and the default place are those of ROS's `camera_info_manager`: `file:///folder/front.yaml`,
`package://my_robot/config/front.yaml`; `${NAME}` and `${ROS_HOME}` are filled in.
"""

from __future__ import annotations

import os
import queue
import time
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np

from grabbergui.core.calibration import (
    DISTORTION_LENGTH,
    Calibration,
    given_projection,
    given_rectification,
)
from grabbergui.core.errors import SourceNotFoundError, UsageError
from grabbergui.net.ros2.runtime import Ros2Node

DEFAULT_MODEL = "plumb_bob"
"""Distortion model of a message that names none."""


def fill_camera_info(message: Any, calibration: Calibration) -> None:
    """Write a calibration into a message; its header is left alone."""
    message.width, message.height = calibration.width, calibration.height
    message.distortion_model = calibration.distortion_model
    message.d = [float(value) for value in np.ravel(calibration.distortion)]
    message.k = [float(value) for value in np.ravel(calibration.matrix)]
    message.r = [float(value) for value in np.ravel(calibration.rectification)]
    message.p = [float(value) for value in np.ravel(calibration.projection)]


def read_camera_info(message: Any, name: str) -> Calibration:
    """Return the calibration in a camera_info message. Raises UsageError if it contains none.

    Its matrix is of the whole sensor; its region and binning, in this order, describe what became of it
    (`sensor_msgs/CameraInfo`). Zeros mean all of it, unbinned.
    """
    matrix = np.array(message.k, float).reshape(3, 3)
    if not message.width or not message.height or not np.isfinite(matrix).all() or matrix[0, 0] <= 0:
        raise UsageError("the camera_info holds no calibration: width, height and k must be set")
    model = message.distortion_model or DEFAULT_MODEL
    if model not in DISTORTION_LENGTH:
        known = ", ".join(DISTORTION_LENGTH)
        raise UsageError(f"the camera_info has distortion model '{model}'; known are {known}")
    padding = DISTORTION_LENGTH[model] - len(message.d)
    if padding < 0:
        raise UsageError(f"the camera_info has {len(message.d)} coefficients, which are too many for {model}")
    distortion = np.pad(np.array(message.d, float), (0, padding))
    whole = Calibration(
        message.width,
        message.height,
        matrix,
        distortion,
        camera_name=name,
        rectification=given_rectification(np.array(message.r, float).reshape(3, 3)),
        rectified=given_projection(np.array(message.p, float).reshape(3, 4)),
    )
    region, across, down = message.roi, max(message.binning_x, 1), max(message.binning_y, 1)
    if region.width and region.height:
        whole = whole.cut_out(region.x_offset, region.y_offset, region.width, region.height)
    return whole.scaled_to(whole.width // across, whole.height // down) if across * down > 1 else whole


DEFAULT_URL = "file://${ROS_HOME}/camera_info/${NAME}.yaml"
"""The place of a camera for which no other is given."""


def path_of(url: str, camera: str) -> Path:
    """Return the file that a URL means for the camera of that full name. Raises UsageError.

    The file is named after the camera with `_` for `/`, so that cameras of two namespaces have two files.
    """
    filled = (url or DEFAULT_URL).replace("${NAME}", camera.strip("/").replace("/", "_"))
    filled = filled.replace("${ROS_HOME}", os.environ.get("ROS_HOME") or str(Path.home() / ".ros"))
    scheme, _, rest = filled.partition("://")
    if scheme == "file" and rest.startswith("/"):
        return Path(unquote(rest))
    package, _, inside = rest.partition("/")
    if scheme == "package" and package and inside:
        return _share_of(package, url) / unquote(inside)
    raise UsageError(
        f"camera_info_url {url}: write file:///folder/camera.yaml or package://PACKAGE/camera.yaml"
    )


def _share_of(package: str, url: str) -> Path:
    from ament_index_python.packages import PackageNotFoundError, get_package_share_directory

    try:
        return Path(get_package_share_directory(package))
    except (PackageNotFoundError, ValueError, OSError) as error:  # no name of a package; no index to look in
        raise UsageError(f"camera_info_url {url}: package {package} is not found: {error}") from error


def receive_camera_info(camera: str, timeout: float = 15.0) -> tuple[Calibration, str]:
    """Wait for one `sensor_msgs/CameraInfo` of a camera, named as itself or by its `image_raw`.

    Returns its calibration and the frame that its images are taken in, empty if it names none.
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
            message = messages.get(timeout=timeout)
            return read_camera_info(message, camera), message.header.frame_id.lstrip("/")
        except queue.Empty:
            raise SourceNotFoundError(f"nobody publishes {topic}; give --calibration FILE") from None
        except UsageError as error:
            raise UsageError(f"{topic}: {error}; give --calibration FILE") from error
    finally:
        ros.close()
