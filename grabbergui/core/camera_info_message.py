"""Calibrations as `sensor_msgs/msg/CameraInfo` and back: rclpy's messages, and their bytes in recordings."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from grabbergui.core.calibration import (
    DISTORTION_LENGTH,
    Calibration,
    FrameCalibration,
    given_projection,
    given_rectification,
)
from grabbergui.core.errors import UsageError
from grabbergui.core.ros_image import CDR_LITTLE_ENDIAN, CdrReader, CdrWriter

NAME = "sensor_msgs/msg/CameraInfo"
_MOST_COEFFICIENTS = 64
DEFAULT_MODEL = "plumb_bob"
"""Distortion model of a message that names none."""


@dataclass
class RegionFields:
    """The fields of a `sensor_msgs/msg/RegionOfInterest`."""

    x_offset: int = 0
    y_offset: int = 0
    height: int = 0
    width: int = 0


@dataclass
class CameraInfoFields:
    """The fields of the message, by their names there."""

    stamp_ns: int = 0
    frame_id: str = ""
    height: int = 0
    width: int = 0
    distortion_model: str = ""
    d: list[float] = field(default_factory=list)
    k: list[float] = field(default_factory=lambda: [0.0] * 9)
    r: list[float] = field(default_factory=lambda: [0.0] * 9)
    p: list[float] = field(default_factory=lambda: [0.0] * 12)
    binning_x: int = 0
    binning_y: int = 0
    roi: RegionFields = field(default_factory=RegionFields)

    def encode(self) -> bytes:
        """Return the message, including its encapsulation header."""
        writer, roi = CdrWriter(), self.roi
        writer.header(self.stamp_ns, self.frame_id)
        writer.numbers("II", self.height, self.width)
        writer.text(self.distortion_model)
        writer.numbers("I", len(self.d))
        for numbers in (self.d, self.k, self.r, self.p):
            writer.numbers("d" * len(numbers), *numbers)
        writer.numbers("II", self.binning_x, self.binning_y)
        writer.numbers("IIIIB", roi.x_offset, roi.y_offset, roi.height, roi.width, 0)
        return CDR_LITTLE_ENDIAN + bytes(writer.content)

    @classmethod
    def decode(cls, message: bytes | memoryview) -> CameraInfoFields:
        """Read a message. Raises RemoteProtocolError."""
        reader = CdrReader(message)
        stamp, frame_id = reader.header()
        height, width, model = reader.number("I"), reader.number("I"), reader.text()
        count = min(reader.number("I"), _MOST_COEFFICIENTS)
        d, k, r, p = ([reader.real() for _ in range(size)] for size in (count, 9, 9, 12))
        binning = reader.number("I"), reader.number("I")
        roi = RegionFields(*(reader.number("I") for _ in range(4)))
        return cls(stamp, frame_id, height, width, model, d, k, r, p, *binning, roi)


def fill_camera_info(message: Any, forms: FrameCalibration) -> None:
    """Write a calibration into a message; its header is left alone.

    The matrices are those of the images that were calibrated or of the whole sensor; region and binning say
    what the frame is of these, as `sensor_msgs/CameraInfo` has it.
    """
    calibration = forms.full
    message.width, message.height = calibration.width, calibration.height
    message.distortion_model = calibration.distortion_model
    message.d = [float(value) for value in np.ravel(calibration.distortion)]
    message.k = [float(value) for value in np.ravel(calibration.matrix)]
    message.r = [float(value) for value in np.ravel(calibration.rectification)]
    message.p = [float(value) for value in np.ravel(calibration.projection)]
    if forms.binning is not None:
        message.binning_x, message.binning_y = forms.binning
    if forms.region is not None:
        region = message.roi
        region.x_offset, region.y_offset, region.width, region.height = forms.region


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
    return whole.binned(across, down) if across * down > 1 else whole
