"""Pixels at the ends of the sensor's range: saturated, or clipped to black."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.core import unpacking
from grabbergui.core.colour import halved
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import Family
from grabbergui.core.region import Region

Mask = NDArray[np.uint8]

SATURATED = (255, 60, 60)
"R G B of what is too bright."
BLACK = (70, 110, 255)
"R G B of what is too dark."


def masks(frame: Frame, region: Region) -> tuple[Mask, Mask]:
    """Where a region is black and where it is saturated, 255 there and 0 elsewhere.

    Shape (region.height, region.width). A coloured pixel counts as saturated where any component is, as
    black where all are; of YUV the luma counts. Raises PixelFormatError.
    """
    lines = unpacking.lines(frame, region.y, region.bottom)[:, region.x : region.right]
    low, high = _extremes(frame, np.ascontiguousarray(lines))
    top = (1 << frame.pixel_format.depth) - 1
    return _mask(low, 0), _mask(high, top)


def painted(pixels: NDArray[np.uint8], black: Mask, saturated: Mask) -> NDArray[np.uint8]:
    """A picture, (height, width[, 3]) and perhaps reduced, with both masks painted over it, in R G B.

    One pixel of the masks is enough to show, however much the picture is reduced.
    """
    rgb = cv2.cvtColor(pixels, cv2.COLOR_GRAY2RGB) if pixels.ndim == 2 else pixels.copy()
    size = (pixels.shape[1], pixels.shape[0])
    for mask, colour in ((black, BLACK), (saturated, SATURATED)):
        if cv2.hasNonZero(mask):
            rgb[_reduced(mask, size) > 0] = colour
    return np.asarray(rgb, np.uint8)


def _extremes(frame: Frame, lines: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Of each pixel the largest component, which must be 0 for black, and the same for saturation."""
    family, order = frame.pixel_format.family, frame.pixel_format.order
    if family is Family.YUV:
        luma = lines[:, :, order.index("Y")]
        return luma, luma
    if family is Family.RGB:
        red, green, blue = (np.ascontiguousarray(lines[:, :, order.index(name)]) for name in "RGB")
        largest = cv2.max(cv2.max(red, green), blue)
        return largest, largest
    return lines, lines


def _mask(values: NDArray[Any], bound: int) -> Mask:
    return np.asarray(cv2.inRange(values, bound, bound), np.uint8)


def _reduced(mask: Mask, size: tuple[int, int]) -> Mask:
    """A mask of (width, height), above zero wherever anything was.

    Halving is several times cheaper than an exact area average, but loses one pixel among very many:
    every step makes it whole again.
    """
    while mask.shape[1] >= 2 * size[0] and mask.shape[0] >= 2 * size[1]:
        mask = np.asarray(cv2.threshold(halved(mask), 0, 255, cv2.THRESH_BINARY)[1], np.uint8)
    if mask.shape[1::-1] != size:
        mask = np.asarray(cv2.resize(mask, size, interpolation=cv2.INTER_AREA), np.uint8)
    return mask
