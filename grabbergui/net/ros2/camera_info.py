"""Calibrations as `sensor_msgs/CameraInfo` and back."""

from __future__ import annotations

import logging
from typing import Any

import numpy as np

from grabbergui.core.calibration import (
    DISTORTION_LENGTH,
    Calibration,
    given_projection,
    given_rectification,
)
from grabbergui.core.errors import GrabberError, UsageError
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import FrameGrabber

log = logging.getLogger(__name__)

DEFAULT_MODEL = "plumb_bob"
"""Where a message names no distortion model."""
_FULL_SIZE = ("WidthMax", "HeightMax")
"""What the camera could send with its present binning, region aside (SFNC, image format control)."""


class FittedCalibration:
    """A calibration as it holds for each frame, whatever binning and region the camera is set to.

    One thread asks; any thread may set another calibration.
    """

    def __init__(self, grabber: FrameGrabber) -> None:
        self.calibration: Calibration | None = None
        "As it was made; None where there is none."
        self._grabber = grabber
        self._key: object = None
        self._fitted: Calibration | None = None
        grabber.features_changed.connect(self._on_features_changed)

    def close(self) -> None:
        """Let go of the grabber. May be called twice."""
        self._grabber.features_changed.disconnect(self._on_features_changed, missing_ok=True)

    def of(self, frame: Frame) -> Calibration | None:
        """What holds for the frame; None, with a warning once, where that cannot be told.

        Without a calibration of ours it is what the source itself says of its pictures.
        """
        calibration = self.calibration
        if calibration is None:
            own = self._grabber.calibration()
            return own if own and (own.width, own.height) == (frame.width, frame.height) else None
        key = (calibration, frame.width, frame.height, frame.offset_x, frame.offset_y)
        if key != self._key:
            self._key = key
            try:
                self._fitted = fitted(calibration, frame, self._full_size())
            except GrabberError as error:
                log.warning("camera_info goes out uncalibrated: %s", error)
                self._fitted = None
        return self._fitted

    def _full_size(self) -> tuple[int, int] | None:
        if not all(map(self._grabber.has_feature, _FULL_SIZE)):
            return None
        width, height = (self._grabber.feature(name).value for name in _FULL_SIZE)
        return (width, height) if isinstance(width, int) and isinstance(height, int) else None

    def _on_features_changed(self, names: frozenset[str]) -> None:
        if not names.isdisjoint(_FULL_SIZE):
            self._key = None


def fitted(calibration: Calibration, frame: Frame, full_size: tuple[int, int] | None) -> Calibration:
    """The calibration for a frame that may be binned and cut out of a whole picture of `full_size`.

    One that was made at the frame's size is taken as it is. Without `full_size` the frame counts as whole.
    Raises UsageError where the proportions tell that the calibration is of another region.
    """
    if (frame.width, frame.height) == (calibration.width, calibration.height):
        return calibration
    whole = calibration.scaled_to(*(full_size or (frame.width, frame.height)))
    return whole.cut_out(frame.offset_x, frame.offset_y, frame.width, frame.height)


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
