"""Images without the distortion of the lens."""

from __future__ import annotations

import math
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.core.calibration import Calibration
from grabbergui.core.pixels import Region

Map = NDArray[np.float32]


def undistorted(
    pixels: NDArray[np.uint8], calibration: Calibration, region: Region, size: tuple[int, int]
) -> NDArray[np.uint8]:
    """Return a region of the undistorted view in `size` pixels (width, height).

    `pixels` is the whole frame, (height, width) or (height, width, 3), possibly reduced; `region` is in
    pixels of the unreduced frame, as the calibration. Pixels outside of the frame are black.
    """
    columns, lines = _maps(calibration, region, size, (pixels.shape[1], pixels.shape[0]))
    return np.asarray(cv2.remap(pixels, columns, lines, cv2.INTER_LINEAR), np.uint8)


def distorted_pixel(calibration: Calibration, x: int, y: int) -> tuple[int, int]:
    """Return the pixel of the frame that is seen at a pixel of the undistorted view; it may be outside."""
    (focal_x, _, centre_x), (_, focal_y, centre_y), _ = calibration.matrix.tolist()
    ray = np.array([[[(x - centre_x) / focal_x, (y - centre_y) / focal_y, 1.0]]])
    still = np.zeros(3)
    if calibration.fisheye:
        seen, _ = cv2.fisheye.projectPoints(ray, still, still, calibration.matrix, calibration.distortion)
    else:
        seen, _ = cv2.projectPoints(ray, still, still, calibration.matrix, calibration.distortion)
    column, line = seen.reshape(2).tolist()
    if not (math.isfinite(column) and math.isfinite(line)):  # the calibration is absurd here
        return -1, -1
    return round(column), round(line)


@lru_cache(maxsize=2)
def _maps(
    calibration: Calibration, region: Region, size: tuple[int, int], whole: tuple[int, int]
) -> tuple[Map, Map]:
    """Return each view pixel's position in the reduced frame; cached until the view moves."""
    part = calibration.cut_out(region.x, region.y, region.width, region.height)
    seen = part.resampled(*size, (size[0] / region.width, size[1] / region.height))
    mapped = cv2.fisheye.initUndistortRectifyMap if calibration.fisheye else cv2.initUndistortRectifyMap
    columns, lines = mapped(
        calibration.matrix, calibration.distortion, np.eye(3), seen.matrix, size, cv2.CV_32FC1
    )
    along_x, along_y = whole[0] / calibration.width, whole[1] / calibration.height
    return (
        np.asarray((columns + 0.5) * along_x - 0.5, np.float32),
        np.asarray((lines + 0.5) * along_y - 0.5, np.float32),
    )
