"""Converts 8-bit sensor data to grey and RGB, and reduces it before colour is computed.

YUV… and YCbCr… without a number are BT.601 in full range (luma 0…255, chroma 128 ± 127), as cameras compute
them and JPEG does; YCbCr601, 709 and 2020 have the matrix of that recommendation and its limited range (luma
16…235, chroma 16…240).
"""

from __future__ import annotations

from functools import cache
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.core import compiled_loops
from grabbergui.core.pfnc import Family, PixelFormat

Bytes = NDArray[np.uint8]

# OpenCV's older names (COLOR_BayerBG2RGB) name the second and third pixel of the second line; these name the
# first two pixels of the first two lines.
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
_OPENCV_YUYV = {"YUYV": cv2.COLOR_YUV2RGB_YUYV, "UYVY": cv2.COLOR_YUV2RGB_UYVY}
"OpenCV's own conversion has BT.601's matrix and limited range."
BAYER_SECOND_LINE = {"GR": "BG", "RG": "GB", "GB": "RG", "BG": "GR"}
_LUMA_SHARES = {"": (0.299, 0.114), "601": (0.299, 0.114), "709": (0.2126, 0.0722), "2020": (0.2627, 0.0593)}
"Weights of red and blue in the luma of each recommendation."
_STRIP_PIXELS = 1 << 17
"Pixels converted in one go, so that intermediate results stay in the processor's cache."


def eight_bits(
    raw: NDArray[Any], pixel_format: PixelFormat, bounds: tuple[float, float] | None = None
) -> Bytes:
    """Reduce samples as `Frame.raw` has them to 8 bits; unsigned 8-bit samples pass through.

    Deeper unsigned samples keep their eight highest bits, and values beyond the depth become 255. Samples of
    fewer bits are stretched to 0…255, signed ones shifted so that 0 becomes 128. Formats that need a range
    (`PixelFormat.needs_range`) are scaled from `bounds` to 1…255; NaN and infinite values become 0.
    """
    depth = pixel_format.depth
    if pixel_format.needs_range:
        return _scaled(raw, bounds or measured_bounds(raw))
    if pixel_format.kind == "i":
        shifted = raw.astype(np.int32) + (1 << depth - 1)
        return (shifted >> depth - 8).astype(np.uint8)
    if raw.dtype == np.uint8:
        return raw if depth == 8 and not pixel_format.fields else _stretched(raw, pixel_format)
    # OpenCV rounds to nearest; the offset of almost one half makes it truncate, in one saturating pass.
    divisor = 1 << depth - 8
    return _array(cv2.convertScaleAbs(raw, alpha=1 / divisor, beta=-(divisor - 1) / (2 * divisor)))


def measured_bounds(values: NDArray[Any]) -> tuple[float, float]:
    """Return the smallest and the largest finite value; (0, 1) if there is none."""
    if values.dtype.kind == "f":
        values = values[np.isfinite(values)]
    return (float(values.min()), float(values.max())) if values.size else (0.0, 1.0)


def to_rgb(data: Bytes, pixel_format: PixelFormat) -> Bytes:
    """Convert 8-bit samples, (height, width[, n]), to (height, width, 3) R G B; RGB8 passes through.

    Bayer is interpolated linearly; its outermost pixels take their neighbours' colour. Coordinates are shown
    by the last one, the distance, in grey.
    """
    order, family = pixel_format.order, pixel_format.family
    if family is Family.BAYER:
        return _demosaiced(data, _BAYER_TO_RGB[order])
    if family is Family.SPARSE:
        return _sparse_to_rgb(data, order)
    if family is Family.YUV:
        return _yuv_to_rgb(data, pixel_format)
    if family is Family.BICOLOR:
        green, first, second = _pairs(data, 1, 0)
        red, blue = (first, second) if order[0] == "R" else (second, first)
        return _array(cv2.merge([red, green, blue]))[:, : data.shape[1]]
    if family is Family.COORDINATES:
        return _array(cv2.cvtColor(_distance(data), cv2.COLOR_GRAY2RGB))
    if family is Family.MONO:
        return _array(cv2.cvtColor(data, cv2.COLOR_GRAY2RGB))
    return data if order == "RGB" else _array(cv2.cvtColor(data, _TO_RGB[order]))


def to_grey(data: Bytes, pixel_format: PixelFormat) -> Bytes:
    """Convert to (height, width) luma of the `to_rgb` image, by BT.601 unless the format names another."""
    family = pixel_format.family
    if family is Family.BAYER:
        return _demosaiced(data, _BAYER_TO_GREY[pixel_format.order])
    if family is Family.YUV:
        luma = _array(cv2.extractChannel(data, pixel_format.raw_order.index("Y")))
        return _array(cv2.LUT(luma, _limited_luma())) if pixel_format.standard else luma
    if family is Family.MONO:
        return data
    if family is Family.COORDINATES:
        return _distance(data)
    if family in (Family.SPARSE, Family.BICOLOR):
        return _array(cv2.cvtColor(to_rgb(data, pixel_format), cv2.COLOR_RGB2GRAY))
    return _array(cv2.cvtColor(data, _TO_GREY[pixel_format.order]))


def halved(data: Bytes) -> Bytes:
    """Return an image of half the size (rounded down, at least one pixel), each pixel the mean of four."""
    height, width = data.shape[:2]
    even = data[: height - height % 2 or 1, : width - width % 2 or 1]
    return _array(cv2.resize(even, (max(1, width // 2), max(1, height // 2)), interpolation=cv2.INTER_AREA))


def bayer_cells(data: Bytes, order: str) -> Bytes:
    """Return (height // 2, width // 2, 3) R G B: a pixel for each whole 2×2 cell, with averaged greens."""
    height, width = data.shape[0] // 2, data.shape[1] // 2
    cells = data[: 2 * height, : 2 * width].reshape(height, 2, width, 2)
    planes = dict(zip(order, cv2.split(cells[:, 0]), strict=True))
    for colour, plane in zip(BAYER_SECOND_LINE[order], cv2.split(cells[:, 1]), strict=True):
        planes[colour] = cv2.addWeighted(planes[colour], 0.5, plane, 0.5, 0) if colour == "G" else plane
    return _array(cv2.merge([planes[colour] for colour in "RGB"]))


def _stretched(raw: Bytes, pixel_format: PixelFormat) -> Bytes:
    """Scale samples of fewer than 8 bits so that the largest becomes 255."""
    if not pixel_format.fields:
        # The factor is whole for 1, 2 and 4 bits. One saturating pass is several times faster than a table.
        return _array(cv2.convertScaleAbs(raw, alpha=255 // ((1 << pixel_format.depth) - 1)))
    tables = [_stretch_table(bits) for bits in pixel_format.fields]
    return _array(cv2.LUT(raw, np.stack(tables, axis=-1)[:, None, :]))


@cache
def _stretch_table(bits: int) -> Bytes:
    top = (1 << bits) - 1
    return (np.minimum(np.arange(256), top) * 255 // top).astype(np.uint8)


def _scaled(raw: NDArray[Any], bounds: tuple[float, float]) -> Bytes:
    low, high = bounds
    finite = np.isfinite(raw)
    # The camera's bytes may be signalling NaNs, whose conversion is an invalid operation.
    values = np.where(finite, raw, 0).astype(np.float64)
    values = np.clip((values - low) * (254 / ((high - low) or 1.0)) + 1, 1, 255)
    return np.where(finite, values, 0).astype(np.uint8)


def _distance(data: Bytes) -> Bytes:
    """Return the last coordinate: C of AC and ABC."""
    return np.ascontiguousarray(data[..., -1])


def _demosaiced(data: Bytes, code: int) -> Bytes:
    height, width = data.shape
    if height >= 3 and width >= 3:
        return _array(cv2.cvtColor(data, code))
    # OpenCV leaves such a small image black. Mirroring it about its edges continues the pattern.
    larger = cv2.copyMakeBorder(data, 2, 2, 2, 2, cv2.BORDER_REFLECT_101)
    return np.ascontiguousarray(cv2.cvtColor(larger, code)[2 : 2 + height, 2 : 2 + width])


def _sparse_to_rgb(data: Bytes, order: str) -> Bytes:
    """Convert sparse colour filter 1: each 2×2 cell has one white diagonal and one of a single colour.

    The cells' colours form a Bayer pattern of half the size, which gives the colour; the interpolated white
    pixels give the detail.
    """
    height, width = data.shape
    mosaic = cv2.copyMakeBorder(data, 0, -height % 4 + 4, 0, -width % 4 + 4, cv2.BORDER_REFLECT_101)
    colours = cv2.addWeighted(mosaic[0::2, 1::2], 0.5, mosaic[1::2, 0::2], 0.5, 0)
    small = _demosaiced(_array(colours), _BAYER_TO_RGB[order[1] + order[3]])
    white = mosaic.astype(np.float32)
    white[0::2, 1::2] = white[1::2, 0::2] = 0
    # Every neighbour of a coloured pixel is white, so a cross-shaped filter interpolates it from all four.
    cross = np.array([[0, 0.25, 0], [0.25, 1, 0.25], [0, 0.25, 0]], np.float32)
    detail = cv2.filter2D(white, -1, cross, borderType=cv2.BORDER_REFLECT_101)
    size = (mosaic.shape[1], mosaic.shape[0])
    blurred = cv2.resize(cv2.resize(detail, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA), size)
    rgb = cv2.resize(small, size).astype(np.float32) + (detail - blurred)[:, :, None]
    return np.ascontiguousarray(np.clip(rgb + 0.5, 0, 255).astype(np.uint8)[:height, :width])


def _yuv_to_rgb(data: Bytes, pixel_format: PixelFormat) -> Bytes:
    order, width = pixel_format.raw_order, data.shape[1]
    if data.shape[2] == 3:
        return _array(cv2.transform(data, _yuv_matrix(pixel_format.standard, order)))
    if width % 2:
        return np.ascontiguousarray(_even_yuv_to_rgb(_completed(data, order), pixel_format)[:, :width])
    return _even_yuv_to_rgb(data, pixel_format)


def _even_yuv_to_rgb(data: Bytes, pixel_format: PixelFormat) -> Bytes:
    order, (height, width) = pixel_format.raw_order, data.shape[:2]
    if pixel_format.standard == "601":
        return _array(cv2.cvtColor(np.ascontiguousarray(data), _OPENCV_YUYV[order]))
    convert = compiled_loops.yuv422(order)
    rgb = np.empty((height, width, 3), np.uint8)
    if convert:
        numbers = _fixed_point(pixel_format.standard)
        convert(np.ascontiguousarray(data).reshape(-1), rgb.reshape(-1), *numbers)
        return rgb
    matrix, lines = _yuv_matrix(pixel_format.standard, "YUV"), max(1, _STRIP_PIXELS // width)
    for top in range(0, height, lines):
        planes = _pairs(data[top : top + lines], order.index("Y"), 1 - order.index("Y"))
        cv2.transform(cv2.merge(planes), matrix, dst=rgb[top : top + lines])
    return rgb


def _completed(data: Bytes, order: str) -> Bytes:
    """Extend lines of odd width by a pixel, whose chroma is that of the pair before."""
    pair = data[:, -1:].copy()
    chroma = 1 - order.index("Y")
    pair[..., chroma] = data[:, -2, None, chroma] if data.shape[1] > 1 else 128
    return np.concatenate((data, pair), axis=1)


def _pairs(data: Bytes, own: int, shared: int) -> list[Bytes]:
    """Split into three (height, width) planes: the component of each pixel, and the two shared by a pair."""
    if data.shape[1] % 2:
        data = np.concatenate((data, data[:, -2:-1] if data.shape[1] > 1 else data), axis=1)
    height, width = data.shape[:2]
    channels = cv2.split(np.ascontiguousarray(data))
    halves = cv2.split(channels[shared].reshape(height, width // 2, 2))
    return [
        _array(channels[own]),
        *(_array(cv2.merge([half, half])).reshape(height, width) for half in halves),
    ]


@cache
def _yuv_matrix(standard: str, order: str) -> NDArray[np.float32]:
    """Return the (3, 4) matrix from Y, U and V in the given order, and 1, to R, G and B."""
    red, blue = _LUMA_SHARES[standard]
    green = 1 - red - blue
    gain, chroma_gain, black = (255 / 219, 255 / 224, 16) if standard else (1.0, 1.0, 0)
    by_name = {
        "Y": np.full(3, gain),
        "U": chroma_gain * np.array([0, -2 * blue * (1 - blue) / green, 2 * (1 - blue)]),
        "V": chroma_gain * np.array([2 * (1 - red), -2 * red * (1 - red) / green, 0]),
    }
    offset = -black * by_name["Y"] - 128 * (by_name["U"] + by_name["V"])
    return np.column_stack([*(by_name[name] for name in order), offset]).astype(np.float32)


@cache
def _fixed_point(standard: str) -> tuple[int, ...]:
    """Return the matrix in the form of `compiled_loops.YuvConverter`, for chroma minus 128."""
    matrix = _yuv_matrix(standard, "YUV").astype(np.float64)
    (luma, _, red_v), (_, green_u, green_v), (_, blue_u, _) = matrix[:, :3]
    black = matrix[0, 3] + 128 * red_v + 0.5
    return tuple(round(number * (1 << 14)) for number in (luma, black, red_v, green_u, green_v, blue_u))


@cache
def _limited_luma() -> Bytes:
    """Return the table that stretches luma 16…235 to 0…255."""
    table: Bytes = np.clip(np.rint((np.arange(256) - 16) * (255 / 219)), 0, 255).astype(np.uint8)
    return table


def _array(result: Any) -> Bytes:
    """Narrow the type, as OpenCV's stubs allow more than uint8 arrays."""
    array: Bytes = result
    return array
