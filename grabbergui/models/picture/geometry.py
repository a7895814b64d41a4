"""The geometry of the view: rotated, mirrored and undistorted; the frame itself stays as it is."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.core.calibration import Calibration
from grabbergui.core.pixels import Region

_ROTATIONS = {1: cv2.ROTATE_90_CLOCKWISE, 2: cv2.ROTATE_180, 3: cv2.ROTATE_90_COUNTERCLOCKWISE}


@dataclass(frozen=True)
class Orientation:
    """First mirrored, then turned. The result is the *view*; both have their origin at the top left."""

    quarter_turns: int = 0
    "Clockwise, 0 … 3."
    mirrored_x: bool = False
    "Left and right exchanged, as the view shows it."
    mirrored_y: bool = False

    @property
    def neutral(self) -> bool:
        """Whether the view is the frame."""
        return self == Orientation()

    def turned(self, quarters: int) -> Orientation:
        """Return the orientation rotated clockwise."""
        return replace(self, quarter_turns=(self.quarter_turns + quarters) % 4)

    def mirrored(self, *, x: bool = False, y: bool = False) -> Orientation:
        """Return the current view with left and right (`x`) or top and bottom (`y`) exchanged."""
        if self.quarter_turns % 2:
            x, y = y, x  # the view's columns are the frame's lines
        return replace(self, mirrored_x=self.mirrored_x ^ x, mirrored_y=self.mirrored_y ^ y)

    def view_size(self, width: int, height: int) -> tuple[int, int]:
        """Return the view's size for a frame of that size, and vice versa."""
        return (height, width) if self.quarter_turns % 2 else (width, height)

    def to_view(self, region: Region, width: int, height: int) -> Region:
        """Return the place in the view of a region of a frame of that size."""
        region = self._mirrored(region, width, height)
        return _rotated(region, width, height, self.quarter_turns)

    def to_frame(self, region: Region, width: int, height: int) -> Region:
        """Return the region of a frame of that size that is seen there. Both sizes are the frame's."""
        view_width, view_height = self.view_size(width, height)
        region = _rotated(region, view_width, view_height, -self.quarter_turns % 4)
        return self._mirrored(region, width, height)

    def pixel(self, x: int, y: int, width: int, height: int) -> tuple[int, int]:
        """Return column and line of the frame's pixel at a place in the view."""
        region = self.to_frame(Region(x, y, 1, 1), width, height)
        return region.x, region.y

    def applied(self, pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Pixels of the frame, (height, width[, 3]), as they are seen; contiguous, perhaps themselves."""
        if self.mirrored_x or self.mirrored_y:
            code = -1 if self.mirrored_x and self.mirrored_y else int(self.mirrored_x)
            pixels = np.asarray(cv2.flip(pixels, code), np.uint8)
        if self.quarter_turns:
            pixels = np.asarray(cv2.rotate(pixels, _ROTATIONS[self.quarter_turns]), np.uint8)
        return pixels

    def _mirrored(self, region: Region, width: int, height: int) -> Region:
        x = width - region.right if self.mirrored_x else region.x
        y = height - region.bottom if self.mirrored_y else region.y
        return Region(x, y, region.width, region.height)


def _rotated(region: Region, width: int, height: int, quarters: int) -> Region:
    for _ in range(quarters):
        region = Region(height - region.bottom, region.x, region.height, region.width)
        width, height = height, width
    return region


def scaled_region(region: Region, size: tuple[int, int], other: tuple[int, int]) -> Region:
    """Return the region of an image of the size `other` that shows what `region` shows of one of `size`.

    Rounded outwards; sizes are (width, height).
    """
    if size == other:
        return region
    left, right = region.x * other[0] // size[0], -(-region.right * other[0] // size[0])
    top, bottom = region.y * other[1] // size[1], -(-region.bottom * other[1] // size[1])
    return Region(left, top, right - left, bottom - top)


Map = NDArray[np.float32]


def undistorted(
    pixels: NDArray[np.uint8], calibration: Calibration, region: Region, size: tuple[int, int]
) -> NDArray[np.uint8]:
    """Return a region of the undistorted view, `size` pixels (width, height) large.

    `pixels` is the whole frame, (height, width) or (height, width, 3), possibly reduced; `region` is in the
    pixels of the frame that the calibration is of. Pixels outside of the frame are black.
    """
    columns, lines = _maps(calibration, region, size, (pixels.shape[1], pixels.shape[0]))
    return np.asarray(cv2.remap(pixels, columns, lines, cv2.INTER_LINEAR), np.uint8)


def distorted_pixel(calibration: Calibration, x: int, y: int) -> tuple[int, int]:
    """Return the pixel of the frame that is seen at a pixel of the undistorted view; perhaps outside."""
    (focal_x, _, centre_x), (_, focal_y, centre_y), _ = calibration.matrix.tolist()
    ray = np.array([[[(x - centre_x) / focal_x, (y - centre_y) / focal_y, 1.0]]])
    still = np.zeros(3)
    seen, _ = cv2.projectPoints(ray, still, still, calibration.matrix, calibration.distortion)
    column, line = seen.reshape(2).tolist()
    return round(column), round(line)


@lru_cache(maxsize=2)
def _maps(
    calibration: Calibration, region: Region, size: tuple[int, int], whole: tuple[int, int]
) -> tuple[Map, Map]:
    """Return each view pixel's place in the reduced frame; computed again when the view moves."""
    part = calibration.cut_out(region.x, region.y, region.width, region.height)
    seen = _scaled(part.matrix, (size[0] / region.width, size[1] / region.height))
    columns, lines = cv2.initUndistortRectifyMap(
        calibration.matrix, calibration.distortion, np.eye(3), seen, size, cv2.CV_32FC1
    )
    along_x, along_y = whole[0] / calibration.width, whole[1] / calibration.height
    return (
        np.asarray((columns + 0.5) * along_x - 0.5, np.float32),
        np.asarray((lines + 0.5) * along_y - 0.5, np.float32),
    )


def _scaled(matrix: NDArray[np.float64], scale: tuple[float, float]) -> NDArray[np.float64]:
    """Return a camera matrix for pictures of another size; half a pixel lies between an edge and a centre."""
    scaled = matrix.copy()
    scaled[:2] *= np.array(scale)[:, None]
    scaled[:2, 2] += (np.array(scale) - 1) / 2
    return scaled
