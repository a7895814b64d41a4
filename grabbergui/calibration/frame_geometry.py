"""Reads from a camera's features where the pixels of its frames lie on the sensor."""

from __future__ import annotations

import threading

from grabbergui.core.feature_source import FeatureSource
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.image_geometry import ImageGeometry

Pair = tuple[int, int]

_WHOLE = ("WidthMax", "HeightMax")
_SENSOR = ("SensorWidth", "SensorHeight")
_OFFSET = ("OffsetX", "OffsetY")
_BINNING = (("BinningHorizontal", "DecimationHorizontal"), ("BinningVertical", "DecimationVertical"))
_REVERSE = ("ReverseX", "ReverseY")
_READ = frozenset({*_WHOLE, *_SENSOR, *_BINNING[0], *_BINNING[1], *_REVERSE})
"""Features that are read again when they change."""


class GeometryReader:
    """Returns the geometry of a camera's frames. Any thread.

    The features are read again only after a change, so a frame costs no request to the camera. A mirror that
    is switched while the camera sends applies to the frames that are in transit, too: frames do not tell.
    """

    def __init__(self, grabber: FrameGrabber) -> None:
        self._grabber = grabber
        self._lock = threading.Lock()
        self._listening = False
        self.changes = 0
        "Number of changes of the features so far."
        self._known: tuple[int, ImageGeometry | None] = (-1, None)
        "The number of changes before the features were read, and their values, without an offset."

    def of(self, frame: Frame) -> ImageGeometry | None:
        """Return the geometry of a frame; None if the camera does not report it.

        From the first call on, the camera polls the features that change by themselves.
        """
        return self._at((frame.offset_x, frame.offset_y), listen=True)

    def now(self) -> ImageGeometry | None:
        """Return the geometry of images with the current settings; None if the camera does not report it."""
        return self._at(pair_of(self._grabber, _OFFSET) or (0, 0), listen=False)

    def close(self) -> None:
        """Release the grabber until the next frame. May be called twice."""
        with self._lock:
            self._listening = False
            self._known = (-1, None)
            self._grabber.features_changed.disconnect(self._on_features_changed, missing_ok=True)

    def _at(self, offset: Pair, *, listen: bool) -> ImageGeometry | None:
        with self._lock:
            if listen and not self._listening:  # only now, as listening makes the camera poll its features
                self._listening = True
                self._grabber.features_changed.connect(self._on_features_changed, unique=True)
            listening = self._listening
        changes, known = self._known
        if not listening or changes != self.changes:
            changes = self.changes
            known = _without_offset(self._grabber)
            self._known = changes, known
        if known is None:
            return None
        x, y = offset
        return ImageGeometry(known.whole, (max(x, 0), max(y, 0)), known.binning, known.reversed)

    def _on_features_changed(self, names: frozenset[str]) -> None:
        if not names.isdisjoint(_READ):
            self.changes += 1


def _without_offset(grabber: FeatureSource) -> ImageGeometry | None:
    whole = pair_of(grabber, _WHOLE)
    if whole is None or min(whole) <= 0:
        return None
    across, down = (_product(grabber, names) for names in _BINNING)
    if (sensor := pair_of(grabber, _SENSOR)) is not None:
        # Some cameras report the largest size without binning.
        whole = _largest(whole[0], across, sensor[0]), _largest(whole[1], down, sensor[1])
    reverse_x, reverse_y = (_value(grabber, name) is True for name in _REVERSE)
    return ImageGeometry(whole, (0, 0), (across, down), (reverse_x, reverse_y))


def _largest(whole: int, binning: int, sensor: int) -> int:
    return sensor // binning if sensor < whole * binning and sensor >= binning else whole


def _product(grabber: FeatureSource, names: tuple[str, ...]) -> int:
    product = 1
    for name in names:
        value = _value(grabber, name)
        if isinstance(value, int) and value > 0:
            product *= value
    return product


def pair_of(grabber: FeatureSource, names: tuple[str | None, str | None]) -> Pair | None:
    """Return the values of two integer features; None if either is missing."""
    match [_value(grabber, name) for name in names]:
        case [int(first), int(second)]:
            return first, second
    return None


def _value(grabber: FeatureSource, name: str | None) -> object:
    return grabber.feature(name).value if name and grabber.has_feature(name) else None
