"""Converts Coord3D values to millimetres and points (SFNC 2.7, 3D Scan Control).

Point clouds are written as PLY files (binary, little-endian).
"""

from __future__ import annotations

import json
import math
import re
import threading
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.component import Component, ComponentKind
from grabbergui.core.errors import GrabberError, PixelFormatError, UsageError
from grabbergui.core.features import FeatureValue
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.pfnc import PixelFormat
from grabbergui.core.pixels import millimetres
from grabbergui.core.settings import SettingKey

MILLIMETRES_PER_UNIT = {"Millimeter": 1.0, "Inch": 25.4}
"Keys are the entries of Scan3dDistanceUnit."
_COORDINATES = "ABC"
_LONGEST = 64
"Most characters of a mode's name."
_AXES = re.compile(r"Coord3D_([ABC]+)")


@dataclass(frozen=True)
class Coordinate:
    """One of Scan3dCoordinateSelector's coordinates: value × scale + offset, in Scan3dDistanceUnit."""

    scale: float = 1.0
    offset: float = 0.0
    invalid: float | None = None
    "The value of pixels where nothing was measured; None if there is no such value."


@dataclass(frozen=True)
class Scan3d:
    """The features of 3D Scan Control that define the meaning of Coord3D pixels. Immutable."""

    calibrated: bool = False
    "Whether the camera reports a scale; else values have no unit, and an unsigned 0 is invalid."
    coordinates: tuple[Coordinate, Coordinate, Coordinate] = (Coordinate(), Coordinate(), Coordinate())
    "A, B and C."
    unit: float = 1.0
    "Scan3dDistanceUnit in millimetres."
    system: str = "Cartesian"
    "Scan3dCoordinateSystem."
    output_mode: str = ""
    "Scan3dOutputMode; empty if the camera does not report it."
    focal_length: float | None = None
    "Pixels."
    principal_point: tuple[float, float] = (0.0, 0.0)
    "Column and line, for an image at offset (0, 0)."
    baseline: float | None = None
    "Distance between the two cameras of a stereo camera, millimetres."

    @classmethod
    def read(cls, grabber: FrameGrabber) -> Scan3d:
        """Read a camera's features; return `Scan3d()` for a camera without them.

        Blocks until the camera answers. Features that cannot be read have their defaults.
        """
        if (recorded := grabber.recorded_coordinates()) is not None:
            return recorded
        if not grabber.has_feature("Scan3dCoordinateScale"):
            return cls()
        focal_length = _number(grabber, "Scan3dFocalLength")
        unit = MILLIMETRES_PER_UNIT.get(str(_value(grabber, "Scan3dDistanceUnit")), 1.0)
        baseline = _number(grabber, "Scan3dBaseline")
        return cls(
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

    def as_json(self) -> str:
        """Return one line of JSON for `from_json`."""
        return json.dumps(asdict(self), separators=(",", ":"))

    @classmethod
    def from_json(cls, text: str) -> Scan3d:
        """Read the JSON of `as_json`. Raises UsageError for any other text."""
        try:
            values = json.loads(text)
            first, second, third = (_coordinate_of(axis) for axis in values["coordinates"])
            centre_x, centre_y = (_finite(value) or 0.0 for value in values["principal_point"])
            return cls(
                calibrated=values["calibrated"] is True,
                coordinates=(first, second, third),
                unit=_finite(values["unit"]) or 1.0,
                system=str(values["system"])[:_LONGEST],
                output_mode=str(values["output_mode"])[:_LONGEST],
                focal_length=_finite(values["focal_length"]),
                principal_point=(centre_x, centre_y),
                baseline=_finite(values["baseline"]),
            )
        except (ValueError, TypeError, KeyError, RecursionError, OverflowError):
            raise UsageError(f"'{text[:60]}' does not describe 3D coordinates") from None

    @property
    def disparity(self) -> bool:
        """Whether values are a stereo camera's disparities in pixels instead of distances."""
        return self.output_mode.startswith("DisparityC")

    def unit_of(self, pixel_format: PixelFormat) -> str:
        """Return the unit of `distances`: `mm`, `px` for disparities without a baseline, or none."""
        if not self.calibrated or not _AXES.match(pixel_format.name):
            return ""
        return "px" if self.disparity and not (self.baseline and self.focal_length) else "mm"

    def distances(self, values: NDArray[Any], pixel_format: PixelFormat) -> NDArray[np.float32]:
        """Return coordinate C of raw values, in `unit_of`, of any shape; NaN where nothing was measured.

        `values` is an array of `raw()`, or a part of it. With several coordinates they are the last axis.
        """
        axes = _axes_of(pixel_format)
        if len(axes) > 1:
            values = values[..., -1]
        found = self._scaled(values, axes[-1], pixel_format)
        if not self.disparity or self.baseline is None or self.focal_length is None:
            return found
        with np.errstate(divide="ignore"):
            depth = self.baseline * self.focal_length / (found / np.float32(self.unit))
        return np.where(found > 0, depth, np.float32(np.nan)).astype(np.float32)

    def points(self, image: Frame | Component) -> NDArray[np.float32]:
        """Return the points of a range image: (height, width, 3) float32, x y z in mm, NaN where invalid.

        Images of all three coordinates are scaled. For images of C alone, x (right) and y (down) follow from
        the focal length and principal point of a rectified or perspective camera; without a focal length,
        from the columns and lines of a `RectifiedC` image. Raises PixelFormatError, also if the camera does
        not report enough.
        """
        axes, raw = _axes_of(image.pixel_format), image.raw()
        if self.system != "Cartesian":
            raise PixelFormatError(
                f"points of a {self.system} coordinate system cannot be computed;"
                " set Scan3dCoordinateSystem=Cartesian if the camera has it"
            )
        if axes == _COORDINATES:
            points = [self._scaled(raw[..., i], axes[i], image.pixel_format) for i in range(3)]
            return _without_partial(np.stack(points, axis=-1))
        if axes[-1] != "C":
            raise PixelFormatError(
                f"{image.pixel_format} has no distances; set PixelFormat=Coord3D_ABC32f or Coord3D_C16"
            )
        z = self.distances(raw, image.pixel_format)
        columns = np.arange(image.width, dtype=np.float32) + image.offset_x
        lines = np.arange(image.height, dtype=np.float32)[:, None] + image.offset_y
        if self.focal_length is not None:
            centre_x, centre_y = self.principal_point
            x = (columns - np.float32(centre_x)) / np.float32(self.focal_length) * z
            y = (lines - np.float32(centre_y)) / np.float32(self.focal_length) * z
        elif self.output_mode.startswith("RectifiedC"):
            x = self._position(0, columns) + 0 * z
            y = self._position(1, lines) + 0 * z
        else:
            raise PixelFormatError(
                "no point cloud: the camera reports neither Scan3dFocalLength nor all coordinates;"
                " set PixelFormat=Coord3D_ABC32f or Scan3dOutputMode=RectifiedC if it has them"
            )
        if "A" in axes:
            x = self._scaled(raw[..., 0], "A", image.pixel_format)
        return _without_partial(np.stack([x, y, z], axis=-1))

    def _position(self, index: int, places: NDArray[np.float32]) -> NDArray[np.float32]:
        coordinate = self.coordinates[index]
        scaled = places * coordinate.scale + coordinate.offset
        return np.asarray(scaled * self.unit, np.float32)

    def _scaled(self, values: NDArray[Any], axis: str, pixel_format: PixelFormat) -> NDArray[np.float32]:
        coordinate = self.coordinates[_COORDINATES.index(axis)]
        invalid = coordinate.invalid
        if not self.calibrated and pixel_format.kind == "u" and axis == "C":
            invalid = 0.0
        return millimetres(values, coordinate.scale * self.unit, coordinate.offset * self.unit, invalid)


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


def _coordinate_of(values: dict[str, object]) -> Coordinate:
    scale, offset = _finite(values["scale"]), _finite(values["offset"])
    return Coordinate(1.0 if scale is None else scale, offset or 0.0, _finite(values["invalid"]))


def _finite(value: object) -> Any:
    """Return a finite number as float, and None for None. Raises ValueError for anything else."""
    if value is None:
        return None
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ValueError(value)
    return float(value)


def _axes_of(pixel_format: PixelFormat) -> str:
    """Return the coordinates of a pixel, such as `ABC`; `C` for a format other than Coord3D."""
    match = _AXES.match(pixel_format.name)
    return match[1] if match else "C"


def _without_partial(points: NDArray[np.float32]) -> NDArray[np.float32]:
    """Make all coordinates of a point invalid if one is."""
    points[~np.isfinite(points).all(axis=-1)] = np.nan
    return points


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
        image = range_image(frame)
        if image is None:
            raise PixelFormatError(
                f"a frame of {frame.pixel_format} has no range image;"
                " switch on ComponentEnable[ComponentSelector=Range] if the camera has it"
            )
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
            self._value = Scan3d.read(self._grabber)
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
                self.value = Scan3d.read(self._grabber)

    def _take_stale(self) -> bool:
        with self._lock:
            self._reading, self._stale = self._stale, False
            return self._reading
