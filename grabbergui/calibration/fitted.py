"""The calibration that holds for an image: fitted to binning and region, or chosen by the user."""

from __future__ import annotations

import logging
from collections.abc import Callable
from functools import partial
from pathlib import Path

from grabbergui.calibration import camera_info
from grabbergui.core.calibration import NOMINAL_FIELD_OF_VIEW, Calibration
from grabbergui.core.errors import FeatureNotFoundError, GrabberError
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.sfnc import Role

log = logging.getLogger(__name__)

_FULL_SIZE = ("WidthMax", "HeightMax")
"""The largest image with the camera's present binning (SFNC, Image Format Control)."""
_OFFSET = ("OffsetX", "OffsetY")

_NONE = "the camera has no calibration; serve it with --calibration FILE"

Pair = tuple[int, int]


class FittedCalibration:
    """One camera's calibration, shared by the networks that it is served on. Any thread may call."""

    def __init__(self, grabber: FrameGrabber, file: Path | None = None) -> None:
        """Load `file` if it exists; `keep` writes it. Raises UsageError for a bad file, OSError."""
        self.calibration: Calibration | None = None
        "As it was made; None without one."
        self._grabber = grabber
        self._file: Path | None = None
        self._key: object = None
        self._fitted: Calibration | None = None
        self._listening = False
        if file is not None:
            self.use(file)

    @property
    def file(self) -> Path | None:
        """The file that `keep` writes; None if the calibration is only in memory."""
        return self._file

    def use(self, file: Path) -> None:
        """Load `file` if it exists; `keep` writes it from now on. Raises UsageError, OSError."""
        self._file = file
        if file.is_file():
            self.calibration = camera_info.load(file)

    def close(self) -> None:
        """Release the grabber. May be called twice."""
        self._grabber.features_changed.disconnect(self._on_features_changed, missing_ok=True)

    def keep(self, calibration: Calibration) -> Path | None:
        """Use another calibration; returns the file that it was saved to, if any. Raises OSError."""
        if self._file is not None:
            camera_info.save(calibration, self._file)
        self.calibration = calibration
        return self._file

    def of(self, frame: Frame) -> Calibration | None:
        """Return the calibration that holds for a frame; None, with one warning, if it cannot be known.

        Without a calibration of ours it is what the source itself says of its images.
        """
        size, offset = (frame.width, frame.height), (frame.offset_x, frame.offset_y)
        calibration = self.calibration
        if calibration is None:
            return self._own(size)
        if not self._listening:  # not before, since a camera that is listened to is polled
            self._listening = True
            self._grabber.features_changed.connect(self._on_features_changed)
        key = (calibration, size, offset)
        if key != self._key:
            try:
                self._fitted = fitted(calibration, size, offset, self._full_size())
            except GrabberError as error:
                log.warning("images go out without a calibration: %s", error)
                self._fitted = None
            self._key = key
        return self._fitted

    def now(self) -> Calibration:
        """Return the calibration of images as the camera is set at the moment.

        Raises FeatureNotFoundError without one, UsageError where it is of another region.
        """
        size = self._pair((Role.WIDTH.find(self._has), Role.HEIGHT.find(self._has)))
        if size is None:
            raise FeatureNotFoundError("the camera does not report the size of its images", "Width")
        calibration = self.calibration
        if calibration is None:
            own = self._own(size)
            if own is None:
                raise FeatureNotFoundError(_NONE, "calibration")
            return own
        return fitted(calibration, size, self._pair(_OFFSET) or (0, 0), self._full_size())

    def _own(self, size: Pair) -> Calibration | None:
        own = self._grabber.calibration()
        return own if own and (own.width, own.height) == size else None

    def _full_size(self) -> Pair | None:
        return self._pair(_FULL_SIZE)

    def _pair(self, names: tuple[str | None, str | None]) -> Pair | None:
        """The values of two integer features; None if either is missing."""
        values = [self._grabber.feature(name).value for name in names if name and self._has(name)]
        match values:
            case [int(first), int(second)]:
                return first, second
        return None

    def _has(self, name: str) -> bool:
        return self._grabber.has_feature(name)

    def _on_features_changed(self, names: frozenset[str]) -> None:
        if not names.isdisjoint(_FULL_SIZE):
            self._key = None


def fitted(calibration: Calibration, size: Pair, offset: Pair, full_size: Pair | None) -> Calibration:
    """Fit a calibration to images of `size`, which may be binned and cut out of `full_size` at `offset`.

    A calibration of exactly that size is returned as it is. Without `full_size` the image counts as whole.
    Raises UsageError if the proportions show that the calibration is of another region.
    """
    if size == (calibration.width, calibration.height):
        return calibration
    return calibration.scaled_to(*(full_size or size)).cut_out(*offset, *size)


CalibrationFor = Callable[[int, int], Calibration]
"Width and height of images to their calibration. Raises UsageError for a size that it does not fit."


class CalibrationChoice:
    """Is called as a CalibrationFor. Any thread."""

    def __init__(self, chosen: CalibrationFor) -> None:
        self._chosen = chosen

    @classmethod
    def file(cls, path: Path) -> CalibrationChoice:
        """That of a camera_info file. Raises UsageError, OSError."""
        return cls(camera_info.load(path).scaled_to)

    @classmethod
    def nominal(cls, degrees: float = NOMINAL_FIELD_OF_VIEW) -> CalibrationChoice:
        """An ideal camera that sees so much from left to right."""
        return cls(partial(Calibration.from_field_of_view, degrees=degrees))

    def __call__(self, width: int, height: int) -> Calibration:
        """The calibration for images of a size."""
        return self._chosen(width, height)

    def exchange(self, other: CalibrationChoice) -> None:
        """Be like another from now on."""
        self._chosen = other._chosen
