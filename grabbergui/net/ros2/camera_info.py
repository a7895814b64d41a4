"""Calibrations as `sensor_msgs/CameraInfo` and back."""

from __future__ import annotations

from typing import Any

import numpy as np

from grabbergui.core.calibration import Calibration
from grabbergui.core.errors import UsageError


def fill_camera_info(message: Any, calibration: Calibration) -> None:
    """Write a calibration into a message; its header is left alone."""
    message.width, message.height = calibration.width, calibration.height
    message.distortion_model = calibration.distortion_model
    message.d = [float(value) for value in np.ravel(calibration.distortion)]
    message.k = [float(value) for value in np.ravel(calibration.matrix)]
    message.r = [float(value) for value in np.eye(3).ravel()]
    message.p = [float(value) for value in np.ravel(calibration.projection)]


def read_camera_info(message: Any, name: str) -> Calibration:
    """The calibration in a message. Raises UsageError where there is none in it."""
    matrix = np.array(message.k, float).reshape(3, 3)
    if not message.width or not message.height or not np.isfinite(matrix).all() or matrix[0, 0] <= 0:
        raise UsageError("the camera_info holds no calibration: width, height and k must be set")
    distortion = np.array(message.d, float)
    return Calibration(message.width, message.height, matrix, distortion, camera_name=name)
