"""A camera's calibration: how directions become pixels.

The model is the pinhole of OpenCV: `x = K · distorted(X / Z)`, pixel centres at whole numbers, distortion
`plumb_bob` (k1 k2 p1 p2 k3) or `rational_polynomial` (eight numbers). `calibration.camera_info` reads and
writes it as ROS's tools do.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.errors import UsageError

Matrix = NDArray[np.float64]

DISTORTION_LENGTH = {"plumb_bob": 5, "rational_polynomial": 8}
"Model to how many coefficients it has."
NOMINAL_FIELD_OF_VIEW = 60.0
"Degrees from left to right that are assumed of a camera nobody calibrated."


@dataclass(frozen=True, eq=False)
class Calibration:
    """How directions become pixels, for images of one size."""

    width: int
    height: int
    "Of the images it was made from, in pixels."
    matrix: Matrix
    "(3, 3) float64: fx 0 cx, 0 fy cy, 0 0 1; pixels."
    distortion: Matrix
    "(5,) or (8,) float64."
    camera_name: str = "camera"
    nominal: bool = False
    "Whether it is only assumed from a field of view; poses are then rough."
    rectification: Matrix = field(default_factory=lambda: np.eye(3))
    "(3, 3) float64: turns the camera into the one of the rectified images, in a stereo pair."
    rectified: Matrix | None = None
    "(3, 4) float64: that one's projection, a pair's baseline in it; None where nobody rectified."

    def __post_init__(self) -> None:
        if self.width < 1 or self.height < 1:
            raise UsageError(f"a calibration for images of {self.width}×{self.height} pixels means nothing")
        if self.matrix.shape != (3, 3) or self.distortion.shape[0] not in DISTORTION_LENGTH.values():
            raise UsageError(
                f"a calibration needs a 3×3 camera matrix and 5 or 8 distortion coefficients, not "
                f"{self.matrix.shape} and {self.distortion.shape}"
            )
        if self.rectification.shape != (3, 3) or self.projection.shape != (3, 4):
            raise UsageError(
                f"a calibration needs a 3×3 rectification and a 3×4 projection, not "
                f"{self.rectification.shape} and {self.projection.shape}"
            )
        numbers = (self.matrix, self.distortion, self.rectification, self.projection)
        if not all(np.isfinite(matrix).all() for matrix in numbers):
            raise UsageError("the calibration holds numbers that are not finite; calibrate again")
        if self.matrix[0, 0] <= 0 or self.matrix[1, 1] <= 0:
            raise UsageError(
                f"focal lengths of {self.matrix[0, 0]:g} and {self.matrix[1, 1]:g} pixels are impossible; "
                "they are positive in every calibration that was finished"
            )

    @property
    def distortion_model(self) -> str:
        """ROS's name of the model."""
        return next(name for name, size in DISTORTION_LENGTH.items() if size == self.distortion.shape[0])

    @property
    def projection(self) -> Matrix:
        """(3, 4): of the rectified images; where nobody rectified, the camera's own."""
        if self.rectified is not None:
            return self.rectified
        return np.hstack((self.matrix, np.zeros((3, 1))))

    @property
    def field_of_view(self) -> tuple[float, float]:
        """Degrees from the left edge to the right one and from top to bottom, distortion left out."""
        (focal_x, _, x), (_, focal_y, y), _ = self.matrix.tolist()
        return _angle(x, self.width, focal_x), _angle(y, self.height, focal_y)

    @classmethod
    def from_field_of_view(
        cls, width: int, height: int, degrees: float = NOMINAL_FIELD_OF_VIEW
    ) -> Calibration:
        """A pinhole with square pixels, its centre in the middle, that sees `degrees` from left to right."""
        if not 1 <= degrees <= 170:
            raise UsageError(f"a field of view of {degrees:g}° makes no pinhole; allowed: 1 to 170")
        focal = width / 2 / math.tan(math.radians(degrees) / 2)
        matrix = np.array([[focal, 0, (width - 1) / 2], [0, focal, (height - 1) / 2], [0, 0, 1]])
        return cls(width, height, matrix, np.zeros(5), nominal=True)

    def scaled_to(self, width: int, height: int) -> Calibration:
        """The same camera with binned or reduced images of another size.

        Raises UsageError where the proportions differ by more than a hundredth: that is another crop, and
        where it was cut out is not known here.
        """
        if (width, height) == (self.width, self.height):
            return self
        along_x, along_y = width / self.width, height / self.height
        if abs(along_x / along_y - 1) > 0.01:
            raise UsageError(
                f"the calibration is of {self.width}×{self.height} images, the camera sends "
                f"{width}×{height}, which is another crop; calibrate at this size"
            )
        # Half a pixel lies between an image's edge and its first pixel's centre, whatever their size.
        shift = ((along_x - 1) / 2, (along_y - 1) / 2)
        return self._changed(width, height, (along_x, along_y), shift)

    def binned(self, across: int, down: int) -> Calibration:
        """The same camera with images of which a pixel joins `across` × `down`. Raises UsageError."""
        width, height = self.width // across, self.height // down
        if not width or not height:
            raise UsageError(
                f"a binning of {across}×{down} leaves nothing of {self.width}×{self.height} pixels"
            )
        scale = (1 / across, 1 / down)
        return self._changed(width, height, scale, ((scale[0] - 1) / 2, (scale[1] - 1) / 2))

    def cut_out(self, x: int, y: int, width: int, height: int) -> Calibration:
        """The same camera with images of a region whose first pixel is at `x`, `y`."""
        return self._changed(width, height, (1.0, 1.0), (-x, -y))

    def _changed(
        self, width: int, height: int, scale: tuple[float, float], shift: tuple[float, float]
    ) -> Calibration:
        def changed(projection: Matrix) -> Matrix:
            result = projection.copy()
            result[:2] *= np.array(scale)[:, None]
            result[:2, 2] += shift
            return result

        rectified = None if self.rectified is None else changed(self.rectified)
        return replace(self, width=width, height=height, matrix=changed(self.matrix), rectified=rectified)


def _angle(centre: float, pixels: int, focal: float) -> float:
    """Degrees that a row of `pixels` spans, from its first one's outer edge to its last one's."""
    before, behind = centre + 0.5, pixels - 0.5 - centre
    return math.degrees(math.atan(before / focal) + math.atan(behind / focal))


def given_rectification(matrix: Matrix | None) -> Matrix:
    """A rectification as ROS's messages and files give it: left out or zero, there is none."""
    return matrix if matrix is not None and matrix.any() else np.eye(3)


def given_projection(matrix: Matrix | None) -> Matrix | None:
    """A projection as ROS's messages and files give it: left out or zero, it is the camera's own."""
    return matrix if matrix is not None and matrix.any() else None
