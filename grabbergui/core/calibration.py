"""A camera's calibration: how directions become pixels.

The model is the pinhole of OpenCV: `x = K · distorted(X / Z)`, pixel centres at whole numbers, distortion
`plumb_bob` (k1 k2 p1 p2 k3) or `rational_polynomial` (eight numbers); or that of a fisheye lens, ROS's
`equidistant` (k1 k2 k3 k4, OpenCV's `fisheye`). `calibration.camera_info` reads and writes it as ROS's tools
do.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.errors import UsageError
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.image_geometry import ImageGeometry

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
    geometry: ImageGeometry | None = None
    "Where the images lie on the sensor; None if it was not recorded."

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
            raise self.of_another_crop(width, height)
        return self.resampled(width, height, (along_x, along_y))

    def of_another_crop(self, width: int, height: int) -> UsageError:
        """Return the error for images of this size, to which the calibration cannot be fitted."""
        return UsageError(
            f"the calibration is of {self.width}×{self.height} images, the camera sends {width}×{height}, "
            "which is another crop; calibrate at this size"
        )

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

    def mirrored(self, along: tuple[bool, bool], extent: tuple[float, float]) -> Calibration:
        """Return the calibration of the same images mirrored along x, y or both.

        Columns `c` become `extent[0] - 1 - c`, rows likewise. It is that of the camera which would see the
        mirrored world; mirrored along both, the same camera turned by 180°.
        """
        signs = np.array([-1.0 if each else 1.0 for each in along])
        turn = np.diag([*signs, 1.0])

        def mirrored(projection: Matrix) -> Matrix:
            result = projection.copy()
            result[:2, 2] = np.where(along, np.array(extent) - 1 - result[:2, 2], result[:2, 2])
            result[0, 1] *= signs[0] * signs[1]
            result[:2, 3:] *= signs[:, None]
            return result

        distortion = self.distortion.copy()
        if not self.fisheye:  # its terms are even in x and y
            distortion[2:4] *= signs[::-1]  # p1 acts along y, p2 along x
        return replace(
            self,
            matrix=mirrored(self.matrix),
            distortion=distortion,
            rectification=turn @ self.rectification @ turn,
            rectified=None if self.rectified is None else mirrored(self.rectified),
            geometry=None,
        )

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
        return replace(self, width=width, height=height, matrix=matrix, rectified=rectified, geometry=None)


@dataclass(frozen=True, eq=False)
class FrameCalibration:
    """The calibration of a frame, in the two forms in which it is passed on."""

    image: Calibration
    "Calibration of the frame itself: fitted to its region and binning."
    full: Calibration
    """Calibration of the images that were calibrated, or of the whole sensor without binning, as described by
    the matrices of a sensor_msgs/CameraInfo."""
    region: tuple[int, int, int, int] | None = None
    "The frame in the images of `full`: column, row, width, height; None for all of it."
    binning: tuple[int, int] | None = None
    "Pixels of `full` for each pixel of the frame; None without binning."


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
