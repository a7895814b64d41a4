"""A camera's calibration, and the camera_info YAML that ROS's tools read and write.

The model is the pinhole of OpenCV: `x = K · distorted(X / Z)`, pixel centres at whole numbers, distortion
`plumb_bob` (k1 k2 p1 p2 k3) or `rational_polynomial` (eight numbers). The file's keys are those of
camera_info_manager and camera_calibration; how they lie in YAML is read by `core.camera_info_yaml`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grabbergui.core import camera_info_yaml
from grabbergui.core.errors import UsageError

Matrix = NDArray[np.float64]

DISTORTION_LENGTH = {"plumb_bob": 5, "rational_polynomial": 8}
"Model to how many coefficients it has."
NOMINAL_FIELD_OF_VIEW = 60.0
"Degrees from left to right that are assumed of a camera nobody calibrated."
MAX_FILE_BYTES = 64 * 1024


@dataclass(frozen=True, eq=False)
class Calibration:
    """How directions become pixels, for pictures of one size."""

    width: int
    height: int
    "Of the pictures it was made from, in pixels."
    matrix: Matrix
    "(3, 3) float64: fx 0 cx, 0 fy cy, 0 0 1; pixels."
    distortion: Matrix
    "(5,) or (8,) float64."
    camera_name: str = "camera"
    nominal: bool = False
    "Whether it is only assumed from a field of view; poses are then rough."
    rectification: Matrix = field(default_factory=lambda: np.eye(3))
    "(3, 3) float64: turns the camera into the one of the rectified pictures, in a stereo pair."
    rectified: Matrix | None = None
    "(3, 4) float64: that one's projection, a pair's baseline in it; None where nobody rectified."

    def __post_init__(self) -> None:
        if self.width < 1 or self.height < 1:
            raise UsageError(f"a calibration for pictures of {self.width}×{self.height} pixels means nothing")
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
                f"focal lengths of {self.matrix[0, 0]:g} and {self.matrix[1, 1]:g} pixels cannot be; "
                "they are positive in every calibration that was finished"
            )

    @property
    def distortion_model(self) -> str:
        """ROS's name of the model."""
        return next(name for name, size in DISTORTION_LENGTH.items() if size == self.distortion.shape[0])

    @property
    def projection(self) -> Matrix:
        """(3, 4): of the rectified pictures; where nobody rectified, the camera's own."""
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
            raise UsageError(f"a field of view of {degrees:g}° makes no pinhole; allowed is 1 to 170")
        focal = width / 2 / math.tan(math.radians(degrees) / 2)
        matrix = np.array([[focal, 0, (width - 1) / 2], [0, focal, (height - 1) / 2], [0, 0, 1]])
        return cls(width, height, matrix, np.zeros(5), nominal=True)

    def scaled_to(self, width: int, height: int) -> Calibration:
        """The same camera with binned or reduced pictures of another size.

        Raises UsageError where the proportions differ by more than a hundredth: that is another crop, and
        where it was cut out is not known here.
        """
        if (width, height) == (self.width, self.height):
            return self
        along_x, along_y = width / self.width, height / self.height
        if abs(along_x / along_y - 1) > 0.01:
            raise UsageError(
                f"the calibration is of {self.width}×{self.height} pictures, the camera sends "
                f"{width}×{height}, which is another crop; calibrate at this size"
            )
        # Half a pixel lies between a picture's edge and its first pixel's centre, whatever their size.
        shift = ((along_x - 1) / 2, (along_y - 1) / 2)
        return self._changed(width, height, (along_x, along_y), shift)

    def cut_out(self, x: int, y: int, width: int, height: int) -> Calibration:
        """The same camera with pictures of a region whose first pixel is at `x`, `y`."""
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

    # -- the file --------------------------------------------------------------------------------
    def to_yaml(self) -> str:
        """The text of a camera_info file."""
        return camera_info_yaml.write(
            {
                "image_width": self.width,
                "image_height": self.height,
                "camera_name": self.camera_name,
                "camera_matrix": _matrix(self.matrix),
                "distortion_model": self.distortion_model,
                "distortion_coefficients": _matrix(self.distortion[None]),
                "rectification_matrix": _matrix(self.rectification),
                "projection_matrix": _matrix(self.projection),
            }
        )

    @classmethod
    def from_yaml(cls, text: str, where: str = "calibration") -> Calibration:
        """Read a camera_info file's text. Raises UsageError naming `where` and what is wrong."""
        values = camera_info_yaml.read(text, where)
        model = str(values.get("distortion_model", "plumb_bob"))
        if model not in DISTORTION_LENGTH:
            raise UsageError(
                f"{where}: distortion model '{model}' is not known; there are {', '.join(DISTORTION_LENGTH)}"
            )
        coefficients = _numbers(values, "distortion_coefficients", where).reshape(-1)
        # Older files leave out zeros at the end.
        padding = DISTORTION_LENGTH[model] - coefficients.size
        if padding < 0:
            raise UsageError(f"{where}: {coefficients.size} coefficients are too many for {model}")
        matrix = _numbers(values, "camera_matrix", where)
        if matrix.shape != (3, 3):
            raise UsageError(f"{where}: camera_matrix is {matrix.shape}, not 3×3")
        try:
            return cls(
                _size(values, "image_width", where),
                _size(values, "image_height", where),
                matrix,
                np.pad(coefficients, (0, padding)),
                str(values.get("camera_name", "camera")),
                rectification=given_rectification(_optional(values, "rectification_matrix", where)),
                rectified=given_projection(_optional(values, "projection_matrix", where)),
            )
        except UsageError as error:
            raise UsageError(f"{where}: {error}") from None

    @classmethod
    def load(cls, path: Path) -> Calibration:
        """Read a file. Raises UsageError, OSError."""
        if path.stat().st_size > MAX_FILE_BYTES:
            raise UsageError(f"{path} is too long for a calibration")
        return cls.from_yaml(path.read_text("utf-8", "replace"), str(path))

    def save(self, path: Path) -> None:
        """Write a file that camera_info_manager reads."""
        path.write_text(self.to_yaml(), "utf-8")


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


def _matrix(values: Matrix) -> dict[str, Any]:
    return {"rows": values.shape[0], "cols": values.shape[1], "data": [float(v) for v in values.flat]}


def _numbers(values: dict[str, Any], key: str, where: str) -> Matrix:
    """A matrix entry, checked: rows × cols finite numbers."""
    entry = values.get(key)
    if not isinstance(entry, dict) or not isinstance(entry.get("data"), list):
        raise UsageError(f"{where}: {key} is missing, or has no list 'data'")
    data, rows, columns = entry["data"], entry.get("rows"), entry.get("cols")
    if not all(isinstance(value, (int, float)) for value in data):
        raise UsageError(f"{where}: {key} holds something that is no number")
    if not isinstance(rows, int) or not isinstance(columns, int) or rows * columns != len(data) or rows < 1:
        raise UsageError(f"{where}: {key} has {len(data)} numbers for {rows} rows and {columns} columns")
    return np.array(data, np.float64).reshape(rows, columns)


def _optional(values: dict[str, Any], key: str, where: str) -> Matrix | None:
    return _numbers(values, key, where) if key in values else None


def _size(values: dict[str, Any], key: str, where: str) -> int:
    value = values.get(key)
    if not isinstance(value, int) or not 0 < value < 1 << 16:
        raise UsageError(f"{where}: {key} is {value}, not a number of pixels")
    return value
