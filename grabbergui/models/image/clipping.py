"""Marks on pixels that are saturated or black."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.core import unpacking
from grabbergui.core.colour import halved
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import Family, PixelFormat
from grabbergui.core.pixels import Region, for_display

Mask = NDArray[np.uint8]

SATURATED_COLOUR = (255, 60, 60)
"R G B of saturated pixels."
BLACK_COLOUR = (70, 110, 255)
"R G B of black pixels."


def clipping_masks(frame: Frame, region: Region) -> tuple[Mask, Mask]:
    """Return masks of a region's black and saturated pixels, 255 for those and 0 for others.

    Shape (region.height, region.width). A coloured pixel is saturated if any component is, black if all are;
    for YUV the luma decides, within its range. Signed values, coordinates and other values without a white
    level are never clipped. Raises PixelFormatError.
    """
    pixel_format = frame.pixel_format
    if pixel_format.needs_range or pixel_format.kind == "i":
        unpacking.check(frame)
        nothing = np.zeros((region.height, region.width), np.uint8)
        return nothing, nothing
    if pixel_format.fields:  # the components' depths differ
        largest = for_display(frame, region).pixels.max(axis=2)
        return _mask(largest, 0, 0), _mask(largest, 255, 255)
    lines = unpacking.lines(frame, region.y, region.bottom)[:, region.x : region.right]
    values = _largest(pixel_format, np.ascontiguousarray(lines))
    top = (1 << pixel_format.depth) - 1
    if pixel_format.standard:
        scale = 1 << pixel_format.depth - 8
        return _mask(values, 0, 16 * scale), _mask(values, 235 * scale, top)
    return _mask(values, 0, 0), _mask(values, top, top)


def _with_clipping(pixels: NDArray[np.uint8], black: Mask, saturated: Mask) -> NDArray[np.uint8]:
    """Return an image, (height, width[, 3]) and possibly reduced, with both masks painted over it, in R G B.

    Even a single pixel of a mask shows, however much the image is reduced.
    """
    rgb = cv2.cvtColor(pixels, cv2.COLOR_GRAY2RGB) if pixels.ndim == 2 else pixels.copy()
    size = (pixels.shape[1], pixels.shape[0])
    for mask, colour in ((black, BLACK_COLOUR), (saturated, SATURATED_COLOUR)):
        if cv2.hasNonZero(mask):
            rgb[_reduced(mask, size) > 0] = colour
    return np.asarray(rgb, np.uint8)


def _largest(pixel_format: PixelFormat, lines: NDArray[Any]) -> NDArray[Any]:
    """Return each pixel's largest component, which must be 0 for black; for YUV the luma."""
    family, order = pixel_format.family, pixel_format.raw_order
    if family is Family.YUV:
        return np.ascontiguousarray(lines[:, :, order.index("Y")])
    if family in (Family.RGB, Family.BICOLOR):
        colours = [index for index, name in enumerate(order[: lines.shape[2]]) if name in "RGB"]
        largest = np.ascontiguousarray(lines[:, :, colours[0]])
        for index in colours[1:]:
            largest = cv2.max(largest, np.ascontiguousarray(lines[:, :, index]))
        return largest
    return lines


def _mask(values: NDArray[Any], low: int, high: int) -> Mask:
    return np.asarray(cv2.inRange(values, low, high), np.uint8)


def _reduced(mask: Mask, size: tuple[int, int]) -> Mask:
    """Return a mask reduced to (width, height), above zero wherever any pixel was.

    Repeated halving is several times cheaper than an exact area average, but would average a single pixel
    away; so every step restores full values.
    """
    while mask.shape[1] >= 2 * size[0] and mask.shape[0] >= 2 * size[1]:
        mask = np.asarray(cv2.threshold(halved(mask), 0, 255, cv2.THRESH_BINARY)[1], np.uint8)
    if mask.shape[1::-1] != size:
        mask = np.asarray(cv2.resize(mask, size, interpolation=cv2.INTER_AREA), np.uint8)
    return mask
