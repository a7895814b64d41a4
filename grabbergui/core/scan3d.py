"""Reads what a camera's Coord3D values mean (SFNC 2.7, 3D Scan Control), and makes point clouds of them.

Point clouds are written as PLY files (binary, little-endian).
"""

from __future__ import annotations

import math
import threading
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.calibration import Coordinate, Scan3d
from grabbergui.core.component import Component, ComponentKind
from grabbergui.core.errors import GrabberError, PixelFormatError
from grabbergui.core.features import FeatureValue
from grabbergui.core.frame import Frame
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


def _coordinate(grabber: FrameGrabber, axis: str) -> Coordinate:
    """Read one coordinate, or the values for all from a camera without a selector."""
    scale = _number(grabber, "Scan3dCoordinateScale", axis)
    offset = _number(grabber, "Scan3dCoordinateOffset", axis)
    invalid = None
    if _value(grabber, "Scan3dInvalidDataFlag", axis):
        invalid = _number(grabber, "Scan3dInvalidDataValue", axis)
    return Coordinate(1.0 if scale is None else scale, offset or 0.0, invalid)


def _number(grabber: FrameGrabber, name: str, axis: str = "") -> float | None:
    """Return a finite number. Cameras may report NaN, which is invalid data in any case."""
    value = _value(grabber, name, axis)
    return float(value) if isinstance(value, int | float) and math.isfinite(value) else None


def _value(grabber: FrameGrabber, name: str, axis: str = "") -> FeatureValue | None:
    if not grabber.has_feature(name):
        return None
    selected: tuple[tuple[str, str], ...] = ()
    if axis and "Scan3dCoordinateSelector" in grabber.selectors.of(name):
        selected = (("Scan3dCoordinateSelector", f"Coordinate{axis}"),)
    try:
        return grabber.read_setting(SettingKey(name, selected)).value
    except GrabberError:
        return None


# -- points --------------------------------------------------------------------------------------
_POSITION = [("x", "<f4"), ("y", "<f4"), ("z", "<f4")]
_COLOUR = [("red", "u1"), ("green", "u1"), ("blue", "u1")]
_TYPES = {"<f4": "float", "u1": "uchar"}
"Types of a PLY file by numpy's names."


@dataclass(frozen=True, eq=False)
class PointCloud:
    """The measured points of an image, line by line."""

    points: NDArray[np.float32]
    "(n, 3): x y z in millimetres (without a unit if the camera reports no scale), all finite."
    colours: NDArray[np.uint8] | None = None
    "(n, 3) R G B; None without an intensity image of the same size."
    unit: str = "mm"
    "Unit of the points; empty if the camera reports no scale."

    @classmethod
    def of(cls, frame: Frame, scan: Scan3d) -> PointCloud:
        """Compute the points of a frame's first image of coordinates, with colours from its intensity image.

        Raises PixelFormatError if the frame has none, or the camera does not report enough.
        """
        image = required_range_image(frame)
        points = scan.points(image)
        valid = np.isfinite(points[..., 2])
        intensity = next((part for part in frame.components if _has_colours_of(part, image)), None)
        colours = None if intensity is None else intensity.rgb()[valid]
        return cls(points[valid], colours, scan.unit_of(image.pixel_format))

    def ply(self) -> bytes:
        """Encode the points as a PLY file, with colours if there are any."""
        fields = _POSITION + (_COLOUR if self.colours is not None else [])
        vertices = np.empty(len(self.points), fields)
        for index, (name, _) in enumerate(_POSITION):
            vertices[name] = self.points[:, index]
        if self.colours is not None:
            for index, (name, _) in enumerate(_COLOUR):
                vertices[name] = self.colours[:, index]
        header = [
            "ply",
            "format binary_little_endian 1.0",
            f"comment coordinates in {self.unit or 'the sensor values, without a unit'}",
            f"element vertex {len(vertices)}",
            *(f"property {_TYPES[kind]} {name}" for name, kind in fields),
            "end_header",
        ]
        return "\n".join([*header, ""]).encode("ascii") + vertices.tobytes()


def range_image(frame: Frame) -> Component | None:
    """Return the first component of coordinates, if there is any."""
    return next((part for part in frame.components if part.pixel_format.is_coordinate), None)


def required_range_image(frame: Frame) -> Component:
    """Return the first component of coordinates. Raises PixelFormatError if there is none."""
    image = range_image(frame)
    if image is None:
        raise PixelFormatError(
            f"a frame of {frame.pixel_format} has no range image;"
            " switch on ComponentEnable[ComponentSelector=Range] if the camera has it"
        )
    return image


def _has_colours_of(part: Component, image: Component) -> bool:
    same_size = (part.width, part.height) == (image.width, image.height)
    return same_size and part.kind is ComponentKind.INTENSITY and part.pixel_format.convertible


# -- following a camera --------------------------------------------------------------------------
def may_change(names: Iterable[str]) -> bool:
    """Return whether `Scan3d` must be read again after these features have changed."""
    # Reading changes the selector, which must not cause another reading.
    return any(name.startswith("Scan3d") and not name.endswith("Selector") for name in names)


class CurrentScan3d:
    """A grabber's Scan3d features, read again after changes. Use `value` from one thread."""

    def __init__(self, grabber: FrameGrabber) -> None:
        self._grabber = grabber
        self._stale = threading.Event()
        self._stale.set()
        self._value = Scan3d()
        grabber.features_changed.connect(self._on_features_changed)

    @property
    def value(self) -> Scan3d:
        """The current features. Blocks to read them after a change."""
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
