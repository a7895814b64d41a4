"""Reads what a camera's Coord3D values mean (SFNC 2.7, 3D Scan Control), and follows their changes."""

from __future__ import annotations

import math
import threading
from collections.abc import Iterable
from contextlib import suppress

from grabbergui.core.coord3d import Coordinate, Scan3d
from grabbergui.core.errors import GrabberError
from grabbergui.core.feature_source import FeatureSource
from grabbergui.core.features import FeatureValue
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.settings import SettingKey

MILLIMETRES_PER_UNIT = {"Millimeter": 1.0, "Inch": 25.4}
"Keys are the entries of Scan3dDistanceUnit."


def read_scan3d(grabber: FrameGrabber) -> Scan3d:
    """Read a camera's features; return `Scan3d()` for a camera without them.

    Blocks until the camera answers. Features that cannot be read have their defaults.
    """
    if (recorded := grabber.recorded_coordinates()) is not None:
        return recorded
    if not grabber.has_feature("Scan3dCoordinateScale"):
        return Scan3d()
    focal_length = _number(grabber, "Scan3dFocalLength")
    unit = MILLIMETRES_PER_UNIT.get(str(_value(grabber, "Scan3dDistanceUnit")), 1.0)
    baseline = _number(grabber, "Scan3dBaseline")
    return Scan3d(
        calibrated=True,
        coordinates=(_coordinate(grabber, "A"), _coordinate(grabber, "B"), _coordinate(grabber, "C")),
        unit=unit,
        system=str(_value(grabber, "Scan3dCoordinateSystem") or "Cartesian"),
        output_mode=str(_value(grabber, "Scan3dOutputMode") or ""),
        focal_length=focal_length or None,
        principal_point=(
            _number(grabber, "Scan3dPrincipalPointU") or 0.0,
            _number(grabber, "Scan3dPrincipalPointV") or 0.0,
        ),
        baseline=baseline * unit if baseline else None,
    )


def _coordinate(grabber: FeatureSource, axis: str) -> Coordinate:
    """Read one coordinate, or the values for all from a camera without a selector."""
    scale = _number(grabber, "Scan3dCoordinateScale", axis)
    offset = _number(grabber, "Scan3dCoordinateOffset", axis)
    invalid = None
    if _value(grabber, "Scan3dInvalidDataFlag", axis):
        invalid = _number(grabber, "Scan3dInvalidDataValue", axis)
    return Coordinate(1.0 if scale is None else scale, offset or 0.0, invalid)


def _number(grabber: FeatureSource, name: str, axis: str = "") -> float | None:
    """Return a finite number. Cameras may report NaN, which is invalid data in any case."""
    value = _value(grabber, name, axis)
    return float(value) if isinstance(value, int | float) and math.isfinite(value) else None


def _value(grabber: FeatureSource, name: str, axis: str = "") -> FeatureValue | None:
    if not grabber.has_feature(name):
        return None
    selected: tuple[tuple[str, str], ...] = ()
    if axis and "Scan3dCoordinateSelector" in grabber.selectors.of(name):
        selected = (("Scan3dCoordinateSelector", f"Coordinate{axis}"),)
    try:
        return grabber.read_setting(SettingKey(name, selected)).value
    except GrabberError:
        return None


def may_change(names: Iterable[str]) -> bool:
    """Return whether `Scan3d` must be read again after these features have changed."""
    # Reading changes the selector, which must not cause another reading.
    return any(name.startswith("Scan3d") and not name.endswith("Selector") for name in names)


class CurrentScan3d:
    """A grabber's Scan3d features, read again after changes. Use `value` from one thread.

    It listens to the grabber from the first `value` on, as a camera polls its features for listeners.
    """

    def __init__(self, grabber: FrameGrabber) -> None:
        self._grabber = grabber
        self._listening = False
        self._stale = threading.Event()
        self._stale.set()
        self._value = Scan3d()

    @property
    def value(self) -> Scan3d:
        """The current features. Blocks to read them after a change."""
        if not self._listening:
            self._listening = True
            self._grabber.features_changed.connect(self._on_features_changed)
        if self._stale.is_set():
            self._stale.clear()
            self._value = read_scan3d(self._grabber)
        return self._value

    def close(self) -> None:
        """Stop following the grabber. May be called twice."""
        self._grabber.features_changed.disconnect(self._on_features_changed, missing_ok=True)

    def _on_features_changed(self, names: frozenset[str]) -> None:
        if may_change(names):
            self._stale.set()


class FollowedScan3d:
    """A grabber's Scan3d features for threads that must not block.

    After a change, another thread reads them: the thread that reports the change may hold the grabber.
    """

    def __init__(self, grabber: FrameGrabber) -> None:
        """Read the features; blocks until the camera answers."""
        self._grabber = grabber
        self.value = Scan3d()
        "The features read last. Any thread."
        self._lock = threading.Lock()
        self._stale = self._reading = True
        grabber.features_changed.connect(self._on_features_changed)
        self._read()

    def close(self) -> None:
        """Stop following the grabber. May be called twice."""
        self._grabber.features_changed.disconnect(self._on_features_changed, missing_ok=True)

    def _on_features_changed(self, names: frozenset[str]) -> None:
        if not may_change(names):
            return
        with self._lock:
            idle, self._stale, self._reading = not self._reading, True, True
        if idle:
            threading.Thread(target=self._read, name="scan3d", daemon=True).start()

    def _read(self) -> None:
        """Read until nothing has changed during a reading."""
        while self._take_stale():
            with suppress(GrabberError):  # a grabber that is closed or lost reports a change on its return
                self.value = read_scan3d(self._grabber)

    def _take_stale(self) -> bool:
        with self._lock:
            self._reading, self._stale = self._stale, False
            return self._reading
