"""Calibrations as `sensor_msgs/CameraInfo` and back."""

from __future__ import annotations

from typing import Any

import numpy as np

from grabbergui.core.calibration import (
    DISTORTION_LENGTH,
    Calibration,
    given_projection,
    given_rectification,
)
from grabbergui.core.errors import UsageError

DEFAULT_MODEL = "plumb_bob"
"""Where a message names no distortion model."""


def fill_camera_info(message: Any, calibration: Calibration) -> None:
    """Write a calibration into a message; its header is left alone."""
    message.width, message.height = calibration.width, calibration.height
    message.distortion_model = calibration.distortion_model
    message.d = [float(value) for value in np.ravel(calibration.distortion)]
    message.k = [float(value) for value in np.ravel(calibration.matrix)]
    message.r = [float(value) for value in np.ravel(calibration.rectification)]
    message.p = [float(value) for value in np.ravel(calibration.projection)]


def read_camera_info(message: Any, name: str) -> Calibration:
    """What a message says of the pictures that it comes with. Raises UsageError where that is nothing.

    Its matrix is of the whole sensor; its region and binning, in this order, tell what became of it
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
