"""Range images in metres, as networks carry them, and in the camera's own units."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.component import (
    Conversions,
)
from grabbergui.core.coord3d import Scan3d
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import by_name


def in_metres(image: Frame, scan: Scan3d) -> Frame:
    """Return a range image in metres, as Coord3D_C32f with NaN where nothing was measured (REP 118).

    Other images, and those of a camera that reports no scale, are returned as they are. Raises
    PixelFormatError.
    """
    if not image.pixel_format.is_coordinate or scan.unit_of(image.pixel_format) != "mm":
        return image
    return _with_distances(image, scan.distances(image.raw(), image.pixel_format) / np.float32(1000))


def in_camera_units(image: Frame, scan: Scan3d) -> Frame:
    """Convert an image of `in_metres` back to the camera's own values, Coord3D_C32f, to which `scan` applies.

    NaN stays NaN. Other images, and those of a camera that reports no scale, are returned as they are. Raises
    PixelFormatError.
    """
    pixel_format = image.pixel_format
    if pixel_format.name != "Coord3D_C32f" or scan.unit_of(pixel_format) != "mm":
        return image
    found = image.raw() * np.float32(1000)
    if scan.disparity and scan.baseline is not None and scan.focal_length is not None:
        with np.errstate(divide="ignore"):
            found = np.float32(scan.baseline * scan.focal_length * scan.unit) / found
    _, _, depth = scan.coordinates
    values = (found / np.float32(scan.unit) - np.float32(depth.offset)) / np.float32(depth.scale or 1.0)
    return _with_distances(image, values)


def _with_distances(image: Frame, values: NDArray[np.float32]) -> Frame:
    """Return the image with these values, (height, width), as Coord3D_C32f."""
    return replace(
        image,
        payload=values.astype("<f4").reshape(-1).view(np.uint8),
        pixel_format=by_name("Coord3D_C32f"),
        padding_x=0,
        big_endian=False,
        _conversions=Conversions(),
    )
