"""A calibration that a user may exchange while frames arrive."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

from grabbergui.calibration.camera_info import load_for
from grabbergui.calibration.fitting import FittedCalibration
from grabbergui.core.calibration import (
    NOMINAL_FIELD_OF_VIEW,
    Calibration,
)
from grabbergui.core.errors import UsageError
from grabbergui.core.grabber import FrameGrabber

CalibrationFor = Callable[[int, int], Calibration]
"Returns the calibration of images by width and height. Raises UsageError for a size that it does not fit."


class CalibrationChoice:
    """A CalibrationFor that can be exchanged. Any thread."""

    def __init__(self, chosen: CalibrationFor) -> None:
        self._chosen = chosen

    @classmethod
    def file(cls, path: Path, grabber: FrameGrabber) -> CalibrationChoice:
        """Choose the calibration of a camera from a camera_info file, for poses and servoing.

        It follows the camera's binning and region.

        Raises UsageError, also for a fisheye lens, OSError.
        """
        calibration = load_for(grabber.info, path)
        try:
            _ = calibration.pinhole_distortion
        except UsageError as error:
            raise UsageError(f"{path}: {error}") from None
        fitted = FittedCalibration(grabber)
        fitted.calibration = calibration
        return cls(fitted.of_size)

    @classmethod
    def nominal(cls, degrees: float = NOMINAL_FIELD_OF_VIEW) -> CalibrationChoice:
        """Choose an ideal camera with a horizontal field of view of `degrees`."""
        return cls(partial(Calibration.from_field_of_view, degrees=degrees))

    def __call__(self, width: int, height: int) -> Calibration:
        """Return the calibration of images by size."""
        return self._chosen(width, height)

    def exchange(self, other: CalibrationChoice) -> None:
        """Choose the same as `other` from now on."""
        self._chosen = other._chosen
