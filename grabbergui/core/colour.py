"""Eight-bit sensor data to grey and RGB, and its reduction before colour is computed.

YUV422_8 and YCbCr422_8 are both BT.601 in full range (luma 0…255, chroma 128 ± 127): PFNC keeps the studio
range of BT.601 for the names YCbCr601_*, and cameras compute YUV with chroma factors of one half, as JPEG
does. OpenCV's own YUYV conversions assume the studio range and would clip such pictures.
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.core.pfnc import Family, PixelFormat

Bytes = NDArray[np.uint8]

# OpenCV's older names (COLOR_BayerBG2RGB) give the colours of the second line's second and third pixel;
# these give those of the first two lines.
_BAYER_TO_RGB = {
    "GR": cv2.COLOR_BayerGRBG2RGB,
    "RG": cv2.COLOR_BayerRGGB2RGB,
    "GB": cv2.COLOR_BayerGBRG2RGB,
    "BG": cv2.COLOR_BayerBGGR2RGB,
}
_BAYER_TO_GREY = {
    "GR": cv2.COLOR_BayerGRBG2GRAY,
    "RG": cv2.COLOR_BayerRGGB2GRAY,
    "GB": cv2.COLOR_BayerGBRG2GRAY,
    "BG": cv2.COLOR_BayerBGGR2GRAY,
}
_TO_RGB = {
    "BGR": cv2.COLOR_BGR2RGB,
    "RGBa": cv2.COLOR_RGBA2RGB,
    "BGRa": cv2.COLOR_BGRA2RGB,
}
_TO_GREY = {
    "RGB": cv2.COLOR_RGB2GRAY,
    "BGR": cv2.COLOR_BGR2GRAY,
    "RGBa": cv2.COLOR_RGBA2GRAY,
    "BGRa": cv2.COLOR_BGRA2GRAY,
}
BAYER_SECOND_LINE = {"GR": "BG", "RG": "GB", "GB": "RG", "BG": "GR"}


def eight_bits(raw: NDArray[Any], depth: int) -> Bytes:
    """The eight highest of `depth` bits; values beyond the depth become 255. uint8 passes through."""
    if raw.dtype == np.uint8:
        return raw
    # OpenCV rounds to nearest: the offset of almost one half makes it cut off, in one pass that saturates.
    divisor = 1 << depth - 8
    return _array(cv2.convertScaleAbs(raw, alpha=1 / divisor, beta=-(divisor - 1) / (2 * divisor)))


def to_rgb(data: Bytes, pixel_format: PixelFormat) -> Bytes:
    """(height, width, 3) R G B from (height, width[, n]) of the format; RGB8 passes through.

    Bayer is interpolated linearly; its outermost pixels take their neighbours' colour.
    """
    order = pixel_format.order
    if pixel_format.family is Family.BAYER:
        return _demosaiced(data, _BAYER_TO_RGB[order])
    if pixel_format.family is Family.YUV:
        return _yuv_to_rgb(data, order)
    if pixel_format.family is Family.MONO:
        return _array(cv2.cvtColor(data, cv2.COLOR_GRAY2RGB))
    return data if order == "RGB" else _array(cv2.cvtColor(data, _TO_RGB[order]))


def to_grey(data: Bytes, pixel_format: PixelFormat) -> Bytes:
    """(height, width) BT.601 luma of what `to_rgb` shows; Mono8 passes through."""
    if pixel_format.family is Family.BAYER:
        return _demosaiced(data, _BAYER_TO_GREY[pixel_format.order])
    if pixel_format.family is Family.YUV:
        return _array(cv2.extractChannel(data, pixel_format.order.index("Y")))
    if pixel_format.family is Family.MONO:
        return data
    return _array(cv2.cvtColor(data, _TO_GREY[pixel_format.order]))


def halved(data: Bytes) -> Bytes:
    """Half the width and height, rounded down, each pixel the mean of four; never less than one pixel."""
    height, width = data.shape[:2]
    even = data[: height - height % 2 or 1, : width - width % 2 or 1]
    return _array(cv2.resize(even, (max(1, width // 2), max(1, height // 2)), interpolation=cv2.INTER_AREA))


def bayer_cells(data: Bytes, order: str) -> Bytes:
    """(height // 2, width // 2, 3) R G B: a pixel for each whole cell of 2×2, its greens averaged."""
    height, width = data.shape[0] // 2, data.shape[1] // 2
    cells = data[: 2 * height, : 2 * width].reshape(height, 2, width, 2)
    planes = dict(zip(order, cv2.split(cells[:, 0]), strict=True))
    for colour, plane in zip(BAYER_SECOND_LINE[order], cv2.split(cells[:, 1]), strict=True):
        planes[colour] = cv2.addWeighted(planes[colour], 0.5, plane, 0.5, 0) if colour == "G" else plane
    return _array(cv2.merge([planes[colour] for colour in "RGB"]))


def _demosaiced(data: Bytes, code: int) -> Bytes:
    height, width = data.shape
    if height >= 3 and width >= 3:
        return _array(cv2.cvtColor(data, code))
    # OpenCV leaves so small a picture black; mirrored about its edges the pattern goes on.
    larger = cv2.copyMakeBorder(data, 2, 2, 2, 2, cv2.BORDER_REFLECT_101)
    return np.ascontiguousarray(cv2.cvtColor(larger, code)[2 : 2 + height, 2 : 2 + width])


def _yuv_to_rgb(data: Bytes, order: str) -> Bytes:
    height, width = data.shape[:2]
    if width % 2:  # the last pixel has no second chroma of its own: it borrows the pair's before it
        pair = data[:, -1:].copy()
        chroma = 1 - order.index("Y")
        pair[..., chroma] = data[:, -2, None, chroma] if width > 1 else 128
        data = np.concatenate((data, pair), axis=1)
    pairs = np.ascontiguousarray(data).reshape(height, -1, 4)
    first_y, u, second_y, v = (0, 1, 2, 3) if order == "YUYV" else (1, 0, 3, 2)
    full = np.empty((height, pairs.shape[1], 6), np.uint8)
    cv2.mixChannels([pairs], [full], [first_y, 0, v, 1, u, 2, second_y, 3, v, 4, u, 5])
    rgb = cv2.cvtColor(full.reshape(height, -1, 3), cv2.COLOR_YCrCb2RGB)
    return np.ascontiguousarray(rgb[:, :width])


def _array(result: Any) -> Bytes:
    """OpenCV's stubs allow more than uint8 arrays."""
    array: Bytes = result
    return array
