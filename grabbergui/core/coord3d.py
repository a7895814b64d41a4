"""The meaning of the values of Coord3D pixels (SFNC 2.7, 3D Scan Control)."""

from __future__ import annotations

import json
import math
import re
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.component import Component
from grabbergui.core.errors import PixelFormatError, UsageError
from grabbergui.core.frame import Frame
from grabbergui.core.json_text import to_json
from grabbergui.core.pfnc import PixelFormat
from grabbergui.core.pixels import millimetres

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

    def as_json(self) -> str:
        """Return one line of JSON for `from_json`."""
        return to_json(asdict(self), compact=True)

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
