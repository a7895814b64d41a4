"""Pictures without the distortion of the lens, as a calibration describes it. For looking at only."""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.core.calibration import Calibration
from grabbergui.core.region import Region

Map = NDArray[np.float32]


def undistorted(
    pixels: NDArray[np.uint8], calibration: Calibration, region: Region, size: tuple[int, int]
) -> NDArray[np.uint8]:
    """Return a region of the undistorted view, `size` pixels (width, height) large.

    `pixels` is the whole frame, (height, width) or (height, width, 3), possibly reduced; `region` is in the
    pixels of the frame that the calibration is of. What lies outside of the frame is black.
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
    """Where in the reduced frame each pixel of the view lies; computed again when the view moves."""
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
    """A camera matrix for pictures of another size; half a pixel lies between an edge and a centre."""
    scaled = matrix.copy()
    scaled[:2] *= np.array(scale)[:, None]
    scaled[:2, 2] += (np.array(scale) - 1) / 2
    return scaled
