"""Fits the calibration of a file to the binning and region of each frame."""

from __future__ import annotations

import logging
from pathlib import Path

from grabbergui.calibration.camera_info import load_for, save
from grabbergui.core.calibration import (
    Calibration,
)
from grabbergui.core.errors import FeatureNotFoundError, GrabberError, UsageError
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.sfnc import Role

log = logging.getLogger(__name__)

_FULL_SIZE = ("WidthMax", "HeightMax")
"""The largest image with the current binning (SFNC, Image Format Control)."""
_OFFSET = ("OffsetX", "OffsetY")

_NONE = "the camera has no calibration; serve it with --calibration FILE"

Pair = tuple[int, int]


class FittedCalibration:
    """A camera's calibration, shared by the networks that serve it. Any thread."""

    def __init__(self, grabber: FrameGrabber, file: Path | None = None) -> None:
        """Begin with the calibration of `file`, as `use` does."""
        self.calibration: Calibration | None = None
        "The calibration as it was made; None without one."
        self._grabber = grabber
        self._file: Path | None = None
        self._refused = ""
        "Why the file was not loaded; empty if it was, or if there is none yet."
        self._fitted: tuple[object, Calibration | None] = (None, None)
        "What the last calibration was fitted to, and that calibration; exchanged as one."
        self._changes = 0
        "Counts changes of the full size."
        self._listening = False
        if file is not None:
            self.use(file)

    @property
    def file(self) -> Path | None:
        """The file that `keep` writes; None if the calibration is only in memory."""
        return self._file

    def use(self, file: Path) -> None:
        """Load `file` if it exists; `keep` writes it from now on.

        A file that is refused stops no camera: there is a warning, images are sent without a calibration, and
        the file is left as it is.
        """
        self._file, self._refused = file, ""
        try:
            if file.exists():
                self.calibration = load_for(self._grabber.info, file)
        except (UsageError, OSError) as error:
            self._refused = str(error)
            log.warning("%s; images are sent without this calibration", error)

    def close(self) -> None:
        """Release the grabber. May be called twice."""
        self._grabber.features_changed.disconnect(self._on_features_changed, missing_ok=True)

    def keep(self, calibration: Calibration) -> Path | None:
        """Use another calibration, and save it if there is a file; return that file.

        Raises OSError, and UsageError rather than replace a file that was refused or write one that would be.
        """
        calibration = calibration.made_with(self._grabber.info)
        if self._file is not None:
            if self._refused and self._file.exists():
                raise UsageError(
                    f"{self._file} is kept, as it could not be loaded ({self._refused}); rename or remove it"
                )
            save(calibration, self._file)
        self.calibration = calibration
        return self._file

    def of(self, frame: Frame) -> Calibration | None:
        """Return the calibration of a frame; None, with one warning, if it cannot be determined.

        Without a calibration here, it is the one that the source reports.
        """
        size, offset = (frame.width, frame.height), (frame.offset_x, frame.offset_y)
        calibration = self.calibration
        if calibration is None:
            return self._own(size)
        if not self._listening:  # only now, as listening makes the camera poll its features
            self._listening = True
            self._grabber.features_changed.connect(self._on_features_changed, unique=True)
        key = (calibration, size, offset, self._changes)
        last_key, last = self._fitted
        if key == last_key:
            return last
        try:
            result = fitted(calibration, size, offset, self._full_size())
        except GrabberError as error:
            log.warning("images are sent without a calibration: %s", error)
            result = None
        self._fitted = key, result
        return result

    def now(self) -> Calibration:
        """Return the calibration of images with the camera's current settings.

        Raises FeatureNotFoundError without one, UsageError if it does not fit the region.
        """
        size = self._pair((self._grabber.role(Role.WIDTH), self._grabber.role(Role.HEIGHT)))
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
        """Return the values of two integer features; None if either is missing."""
        has = self._grabber.has_feature
        values = [self._grabber.feature(name).value for name in names if name and has(name)]
        match values:
            case [int(first), int(second)]:
                return first, second
        return None

    def _on_features_changed(self, names: frozenset[str]) -> None:
        if not names.isdisjoint(_FULL_SIZE):
            self._changes += 1


def fitted(calibration: Calibration, size: Pair, offset: Pair, full_size: Pair | None) -> Calibration:
    """Fit a calibration to images of `size`, cut out at `offset` from binned ones of `full_size`.

    A calibration of exactly that size is returned unchanged. Without `full_size` the image counts as whole.
    Raises UsageError if the aspect ratios show that the calibration is of another region.
    """
    if size == (calibration.width, calibration.height):
        return calibration
    return calibration.scaled_to(*(full_size or size)).cut_out(*offset, *size)
