"""A camera's calibration: how directions become pixels, and what the values of Coord3D pixels mean.

The model is the pinhole of OpenCV: `x = K · distorted(X / Z)`, pixel centres at whole numbers, distortion
`plumb_bob` (k1 k2 p1 p2 k3) or `rational_polynomial` (eight numbers); or that of a fisheye lens, ROS's
`equidistant` (k1 k2 k3 k4, OpenCV's `fisheye`). `calibration.camera_info` reads and writes it as ROS's tools
do. The meaning of 3D data is that of the SFNC (2.7, 3D Scan Control).
"""

from __future__ import annotations

import json
import math
import re
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.component import Component
from grabbergui.core.errors import PixelFormatError, UsageError
from grabbergui.core.frame import Frame
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.json_text import to_json
from grabbergui.core.pfnc import PixelFormat
from grabbergui.core.pixels import millimetres

Matrix = NDArray[np.float64]

FISHEYE = "equidistant"
DISTORTION_LENGTH = {"plumb_bob": 5, "rational_polynomial": 8, FISHEYE: 4}
"The number of coefficients of each distortion model."
NOMINAL_FIELD_OF_VIEW = 60.0
"Horizontal field of view, in degrees, assumed for a camera that is not calibrated."
LARGEST_SIDE = (1 << 16) - 1
"Most pixels of a side of the images."
LARGEST_NUMBER = 1e9
"Largest coefficient or entry of a matrix. Telephoto lenses have k3 of some 1e5; 1e308 overflows."
FOCAL_LENGTHS = 0.01, 1e5
"Shortest focal length per pixel of the image's shorter side (178°), longest of its longer side (2″)."


@dataclass(frozen=True, eq=False)
class Calibration:
    """How directions become pixels, for images of one size."""

    width: int
    height: int
    "Size of the images in pixels."
    matrix: Matrix
    "(3, 3) float64: fx 0 cx, 0 fy cy, 0 0 1; pixels."
    distortion: Matrix
    "(5,), (8,) or, of a fisheye lens, (4,) float64."
    camera_name: str = "camera"
    nominal: bool = False
    "Whether it was derived from an assumed field of view; poses are then rough."
    rectification: Matrix = field(default_factory=lambda: np.eye(3))
    "(3, 3) float64: rotates the camera into the rectified one of a stereo pair."
    rectified: Matrix | None = None
    "(3, 4) float64: projection of the rectified camera, with the pair's baseline; None if not rectified."
    camera_model: str = ""
    camera_serial: str = ""
    "The camera that it was made with; empty if it was not recorded."

    def __post_init__(self) -> None:
        if not (1 <= self.width <= LARGEST_SIDE and 1 <= self.height <= LARGEST_SIDE):
            raise UsageError(
                f"a calibration for images of {self.width}×{self.height} pixels is impossible; "
                f"a side has 1 to {LARGEST_SIDE}"
            )
        if self.matrix.shape != (3, 3) or self.distortion.shape[0] not in DISTORTION_LENGTH.values():
            raise UsageError(
                f"a calibration needs a 3×3 camera matrix and 4, 5 or 8 distortion coefficients, not "
                f"{self.matrix.shape} and {self.distortion.shape}"
            )
        if self.rectification.shape != (3, 3) or self.projection.shape != (3, 4):
            raise UsageError(
                f"a calibration needs a 3×3 rectification and a 3×4 projection, not "
                f"{self.rectification.shape} and {self.projection.shape}"
            )
        numbers = (self.matrix, self.distortion, self.rectification, self.projection)
        if not all(np.isfinite(matrix).all() for matrix in numbers):
            raise UsageError("the calibration contains numbers that are not finite; calibrate again")
        if (most := max(np.abs(matrix).max() for matrix in numbers)) > LARGEST_NUMBER:
            raise UsageError(
                f"the calibration contains {most:g}; its numbers are at most {LARGEST_NUMBER:g}: "
                "calibrate again"
            )
        focal = self.matrix[[0, 1], [0, 1]]
        low, high = np.array(FOCAL_LENGTHS) * sorted((self.width, self.height))
        if focal.min() < low or focal.max() > high:
            raise UsageError(
                f"focal lengths of {focal[0]:g} and {focal[1]:g} pixels are impossible; allowed for "
                f"{self.width}×{self.height} images: {low:g} to {high:g}. "
                "The calibration was probably never finished"
            )

    @property
    def distortion_model(self) -> str:
        """ROS's name of the model."""
        return next(name for name, size in DISTORTION_LENGTH.items() if size == self.distortion.shape[0])

    @property
    def fisheye(self) -> bool:
        """Whether the lens is a fisheye, for which OpenCV has functions of their own."""
        return self.distortion_model == FISHEYE

    @property
    def pinhole_distortion(self) -> Matrix:
        """The coefficients for OpenCV's functions of pinhole cameras. Raises UsageError for a fisheye."""
        if self.fisheye:
            raise UsageError(
                f"the calibration is that of a fisheye lens ({FISHEYE}); poses and servoing need "
                "plumb_bob or rational_polynomial: calibrate with `grabbergui calibrate`"
            )
        return self.distortion

    @property
    def projection(self) -> Matrix:
        """(3, 4): projection of the rectified camera, or of the camera itself if it is not rectified."""
        if self.rectified is not None:
            return self.rectified
        return np.hstack((self.matrix, np.zeros((3, 1))))

    @property
    def field_of_view(self) -> tuple[float, float]:
        """Horizontal and vertical field of view in degrees, without distortion."""
        (focal_x, _, x), (_, focal_y, y), _ = self.matrix.tolist()
        return _angle(x, self.width, focal_x), _angle(y, self.height, focal_y)

    def made_with(self, info: DeviceInfo) -> Calibration:
        """Return this calibration with a record of the camera that it was made with."""
        return replace(self, camera_model=info.model, camera_serial=info.serial)

    def is_of_another(self, info: DeviceInfo) -> bool:
        """Return whether it was made with another camera. False if either has no serial number."""
        recorded, found = (self.camera_model, self.camera_serial), (info.model, info.serial)
        return bool(self.camera_serial and info.serial) and recorded != found

    @classmethod
    def from_field_of_view(
        cls, width: int, height: int, degrees: float = NOMINAL_FIELD_OF_VIEW
    ) -> Calibration:
        """Return a centred pinhole camera with square pixels and a horizontal field of view of `degrees`."""
        if not 1 <= degrees <= 170:
            raise UsageError(f"a field of view of {degrees:g}° is impossible; allowed: 1 to 170")
        focal = width / 2 / math.tan(math.radians(degrees) / 2)
        matrix = np.array([[focal, 0, (width - 1) / 2], [0, focal, (height - 1) / 2], [0, 0, 1]])
        return cls(width, height, matrix, np.zeros(5), nominal=True)

    def scaled_to(self, width: int, height: int) -> Calibration:
        """Return the calibration of the same images binned or scaled to another size.

        Raises UsageError if the aspect ratios differ by more than 1 %: the image was then cropped, and its
        offset is not known here.
        """
        if (width, height) == (self.width, self.height):
            return self
        along_x, along_y = width / self.width, height / self.height
        if abs(along_x - along_y) > 0.01 * along_y:
            raise UsageError(
                f"the calibration is of {self.width}×{self.height} images, the camera sends "
                f"{width}×{height}, which is another crop; calibrate at this size"
            )
        return self.resampled(width, height, (along_x, along_y))

    def binned(self, across: int, down: int) -> Calibration:
        """Return the calibration of images binned by `across` × `down`. Raises UsageError."""
        width, height = self.width // across, self.height // down
        if not width or not height:
            raise UsageError(
                f"images of {self.width}×{self.height} pixels are too small for a binning of {across}×{down}"
            )
        return self.resampled(width, height, (1 / across, 1 / down))

    def resampled(self, width: int, height: int, scale: tuple[float, float]) -> Calibration:
        """Return the calibration of the images scaled along x and y, to `width` × `height` whole pixels."""
        # The centre of the first pixel is half a pixel from the edge of the image, before and after scaling.
        return self._transformed(width, height, scale, ((scale[0] - 1) / 2, (scale[1] - 1) / 2))

    def cut_out(self, x: int, y: int, width: int, height: int) -> Calibration:
        """Return the calibration of a region of the image whose first pixel is at `x`, `y`."""
        return self._transformed(width, height, (1.0, 1.0), (-x, -y))

    def _transformed(
        self, width: int, height: int, scale: tuple[float, float], shift: tuple[float, float]
    ) -> Calibration:
        def transformed(projection: Matrix) -> Matrix:
            result = projection.copy()
            result[:2] *= np.array(scale)[:, None]
            result[:2, 2] += shift
            return result

        matrix = transformed(self.matrix)
        rectified = None if self.rectified is None else transformed(self.rectified)
        return replace(self, width=width, height=height, matrix=matrix, rectified=rectified)


def _angle(centre: float, pixels: int, focal: float) -> float:
    """Return the degrees that a row of `pixels` spans, from the first pixel's outer edge to the last's."""
    before, after = centre + 0.5, pixels - 0.5 - centre
    return math.degrees(math.atan(before / focal) + math.atan(after / focal))


def given_rectification(matrix: Matrix | None) -> Matrix:
    """Return a rectification from a ROS message or file, where None and zeros mean the identity."""
    return matrix if matrix is not None and matrix.any() else np.eye(3)


def given_projection(matrix: Matrix | None) -> Matrix | None:
    """Return a projection from a ROS message or file, where zeros mean none; None is the camera's own."""
    return matrix if matrix is not None and matrix.any() else None


# -- Coord3D -------------------------------------------------------------------------------------
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
