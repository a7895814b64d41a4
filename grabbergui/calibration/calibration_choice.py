"""A calibration that a user may exchange while frames arrive."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path

from grabbergui.calibration.camera_info import load_for
from grabbergui.calibration.fitting import FittedCalibration
from grabbergui.calibration.frame_geometry import GeometryReader
from grabbergui.core.calibration import (
    NOMINAL_FIELD_OF_VIEW,
    Calibration,
)
from grabbergui.core.errors import GrabberError, UsageError
from grabbergui.core.frame import Frame
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
    def reported(cls, grabber: FrameGrabber, first: Calibration) -> CalibrationChoice:
        """Choose what the source reports with its images, and `first` until it does.

        Raises UsageError for a fisheye lens.
        """
        _ = first.pinhole_distortion

        def of_size(width: int, height: int) -> Calibration:
            own = grabber.calibration() or first
            return own if (own.width, own.height) == (width, height) else own.scaled_to(width, height)

        return cls(of_size)

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


class CalibrationWatch:
    """Notices when a CalibrationFor may return another calibration for a source's frames. One thread.

    It may after a change of the camera's binning, region or mirroring, or of the calibration that the source
    reports.
    """

    def __init__(self, grabber: FrameGrabber) -> None:
        self._grabber = grabber
        self._geometries = GeometryReader(grabber)
        self._last: object = None

    def another(self, frame: Frame) -> bool:
        """Return whether the frame may have another calibration than the frame before; True for the first."""
        before = self._last
        with suppress(GrabberError):  # while the camera does not answer
            geometry = self._geometries.of(frame)
            # A camera that does not report its geometry may have been cropped: its frames are not followed.
            size = None if geometry is None else (frame.width, frame.height)
            self._last = geometry, size, self._grabber.calibration()
        return self._last != before

    def close(self) -> None:
        """Release the grabber, and begin again with the next frame. May be called twice."""
        self._geometries.close()
        self._last = None
