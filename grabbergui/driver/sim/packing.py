"""Pixels packed as in PFNC.

Packing is the inverse of `core.pixels`, written independently.
All packers take whole values (the value in the low bits) in the order of the lines and fill a byte array.
Packed formats continue across the end of a line; the last incomplete group is filled with zeros.
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.core.pfnc import Family, PixelFormat, SampleLayout

Bytes = NDArray[np.uint8]

COLOURED = (Family.RGB, Family.YUV, Family.BICOLOR, Family.SPARSE)
"Families that are packed from R G B."
_NEAREST_MM, _DEPTH_MM = 500.0, 1000.0
"Distances shown as black and white in floating-point formats."
_SPARSE_ROWS = ("WBWG", "BWGW", "WGWR", "GWRW")
_STANDARDS = {  # luma of red, green, blue
    "": (0.299, 0.587, 0.114),
    "601": (0.299, 0.587, 0.114),
    "709": (0.2126, 0.7152, 0.0722),
    "2020": (0.2627, 0.6780, 0.0593),
}


def sensor_depth(pixel_format: PixelFormat) -> int:
    """Return the bits in which the sensor measures for a format: 8 to 16, packed to more or fewer later."""
    return min(max(pixel_format.depth, 8), 16)


def pack(values: NDArray[Any], pixel_format: PixelFormat, out: Bytes) -> None:
    """Pack (height, width) values of `sensor_depth` bits into `out` of exactly the image's bytes."""
    if pixel_format.family is Family.COORDINATES:
        height, width = values.shape
        top = (1 << sensor_depth(pixel_format)) - 1
        across = np.broadcast_to(np.linspace(0, top, width).astype(values.dtype), values.shape)
        down = np.broadcast_to(np.linspace(0, top, height).astype(values.dtype)[:, None], values.shape)
        by_name = {"A": across, "B": down, "C": values}
        values = np.stack([by_name[name] for name in pixel_format.order], axis=-1)
    _write(_fitted(values, pixel_format), pixel_format, out)


def pack_colour(rgb: NDArray[Any], pixel_format: PixelFormat, out: Bytes) -> None:
    """Pack (height, width, 3) R G B of `sensor_depth` bits into a format of `COLOURED`."""
    height, width = rgb.shape[:2]
    family, depth = pixel_format.family, pixel_format.depth
    if family is Family.YUV and pixel_format.name in ("YUV422_8", "YUV422_8_UYVY"):
        _pack_yuv422(rgb, pixel_format.order, out.reshape(height, width, 2))
    elif family is Family.YUV:
        _pack_yuv(rgb, pixel_format, out)
    elif family is Family.SPARSE:
        _write(_sparse(rgb, pixel_format.order), pixel_format, out)
    elif family is Family.BICOLOR:
        values = np.repeat(rgb[..., 1:2], 2, axis=2)
        for column in (0, 1):
            values[:, column::2, 0] = rgb[:, column::2, "RGB".index(pixel_format.order[2 * column])]
        _write(values, pixel_format, out)
    elif pixel_format.fields:
        drops = [sensor_depth(pixel_format) - bits for bits in pixel_format.fields]
        _write_fields(
            rgb[..., ["RGB".index(name) for name in pixel_format.order]] >> drops, pixel_format, out
        )
    else:
        values = rgb
        if "a" in pixel_format.order:
            alpha = np.full((height, width, 1), (1 << depth) - 1, rgb.dtype)
            values = np.concatenate((rgb, alpha), axis=2)
        if pixel_format.order != "RGB":
            values = values[..., ["RGBa".index(name) for name in pixel_format.order]]
        _write(values, pixel_format, out)


def _fitted(values: NDArray[Any], pixel_format: PixelFormat) -> NDArray[Any]:
    """Convert values of the sensor's depth to the depth and type of the format."""
    depth, measured = pixel_format.depth, sensor_depth(pixel_format)
    if pixel_format.kind == "f":
        share = values.astype(np.float64) / ((1 << measured) - 1)
        return (_NEAREST_MM + _DEPTH_MM * share).astype(f"<f{pixel_format.sample_bytes}")
    if depth < measured:
        values = values >> (measured - depth)
    elif depth > measured:
        values = values.astype(np.uint64) << np.uint64(depth - measured)
    if pixel_format.kind == "i":
        bits = np.array(1 << depth - 1, values.dtype)
        values = (
            (values ^ bits).astype(f"<u{pixel_format.sample_bytes}").view(f"<i{pixel_format.sample_bytes}")
        )
    return values


def _write(values: NDArray[Any], pixel_format: PixelFormat, out: Bytes) -> None:
    if pixel_format.planar:
        size = len(out) // pixel_format.components
        for index in range(pixel_format.components):
            plane = np.ascontiguousarray(values[..., index])
            _write_run(plane, pixel_format, out[index * size : (index + 1) * size])
    else:
        _write_run(values, pixel_format, out)


def _write_run(values: NDArray[Any], pixel_format: PixelFormat, out: Bytes) -> None:
    layout, depth = pixel_format.layout, pixel_format.depth
    if layout is SampleLayout.WHOLE:
        out.view(f"<{pixel_format.kind}{pixel_format.sample_bytes}").reshape(values.shape)[...] = values
    elif layout is SampleLayout.PACKED_LSB and depth == 10:
        _fill(pack_10p, values, 4, out)
    elif layout is SampleLayout.PACKED_LSB and depth == 12:
        _fill(pack_12p, values, 2, out)
    elif layout is SampleLayout.PACKED_LSB:
        octets = np.ascontiguousarray(values.reshape(-1), "<u2").view(np.uint8).reshape(-1, 2)
        bits = np.unpackbits(octets, axis=1, bitorder="little")[:, :depth]
        out[:] = np.packbits(bits.reshape(-1), bitorder="little")
    elif layout is SampleLayout.PACKED_GIGE and depth == 10:
        _fill(pack_10_packed, values, 2, out)
    elif layout is SampleLayout.PACKED_GIGE:
        _fill(pack_12_packed, values, 2, out)
    else:
        _write_fields(values, pixel_format, out)


def _write_fields(values: NDArray[Any], pixel_format: PixelFormat, out: Bytes) -> None:
    words, shift = np.zeros(values.shape[:2], np.uint32), 0
    for index, bits in enumerate(pixel_format.fields):
        words |= values[..., index].astype(np.uint32) << np.uint32(shift)
        shift += bits
    out.view(f"<u{pixel_format.bits_per_pixel // 8}").reshape(words.shape)[...] = words


def _sparse(rgb: NDArray[Any], order: str) -> NDArray[Any]:
    """Apply the sparse colour filter: white pixels take the mean of the colours."""
    planes = {name: rgb[..., index] for index, name in enumerate("RGB")}
    planes["W"] = rgb.mean(axis=2).astype(rgb.dtype)
    down, across = next((y, x) for y in (0, 2) for x in (0, 2) if (_SPARSE_ROWS[y] * 2)[x : x + 4] == order)
    mosaic = np.empty(rgb.shape[:2], rgb.dtype)
    for y in range(4):
        for x in range(4):
            name = _SPARSE_ROWS[(y + down) % 4][(x + across) % 4]
            mosaic[y::4, x::4] = planes[name][y::4, x::4]
    return mosaic


def _pack_yuv(rgb: NDArray[Any], pixel_format: PixelFormat, out: Bytes) -> None:
    """Pack Y'CbCr in its standard's range and matrix; a group has its first pixel's chroma."""
    depth, order, subsampling = pixel_format.depth, pixel_format.order, pixel_format.subsampling
    height, width = rgb.shape[:2]
    share = rgb.astype(np.float32) / ((1 << depth) - 1)
    red, green, blue = _STANDARDS[pixel_format.standard]
    luma = share @ np.array((red, green, blue), np.float32)
    u, v = (share[..., 2] - luma) / (2 - 2 * blue), (share[..., 0] - luma) / (2 - 2 * red)
    scale, black, span, chroma_span = (1 << depth) / 256, 16, 219, 224
    if not pixel_format.standard:
        black, span, chroma_span = 0, 255, 255
    top, dtype = (1 << depth) - 1, np.uint16 if depth > 8 else np.uint8
    planes = {
        "Y": np.clip(np.rint((black + span * luma) * scale), 0, top).astype(dtype),
        "U": np.clip(np.rint((128 + chroma_span * u) * scale), 0, top).astype(dtype),
        "V": np.clip(np.rint((128 + chroma_span * v) * scale), 0, top).astype(dtype),
    }
    if pixel_format.semiplanar:
        vertical = pixel_format.cell[1]
        out[: height * width] = planes["Y"].reshape(-1)
        chroma = np.stack([planes[name][::vertical, ::2] for name in order[1:]], axis=-1)
        out[height * width :] = chroma.reshape(-1)
    elif subsampling == "411":
        luma_of_four = planes["Y"].reshape(height, -1, 4)
        places = iter(range(4))
        samples = [luma_of_four[..., next(places)] if name == "Y" else planes[name][:, ::4] for name in order]
        _write(np.stack(samples, axis=-1), pixel_format, out)
    elif subsampling:
        own = order.index("Y")
        values = np.repeat(planes["Y"][..., None], 2, axis=2)
        values[:, 0::2, 1 - own], values[:, 1::2, 1 - own] = planes["U"][:, ::2], planes["V"][:, ::2]
        _write(values, pixel_format, out)
    else:
        _write(np.stack([planes[name] for name in order], axis=-1), pixel_format, out)


def _pack_yuv422(rgb: NDArray[np.uint8], order: str, out: NDArray[np.uint8]) -> None:
    """Pack Y'CbCr of BT.601 over the full range; a chroma sample is the mean of two pixels."""
    ycc: NDArray[Any] = cv2.cvtColor(rgb, cv2.COLOR_RGB2YCrCb)
    luma, chroma = (0, 1) if order == "YUYV" else (1, 0)
    out[:, :, luma] = ycc[:, :, 0]
    red, blue = ((ycc[:, 0::2, index].astype(np.uint16) + ycc[:, 1::2, index] + 1) >> 1 for index in (1, 2))
    out[:, 0::2, chroma] = blue
    out[:, 1::2, chroma] = red


def _fill(packer: Any, values: NDArray[np.uint16], group: int, out: Bytes) -> None:
    flat = values.reshape(-1)
    rest = flat.size % group
    if rest:
        flat = np.concatenate((flat, np.zeros(group - rest, flat.dtype)))
    groups = flat.reshape(-1, group)
    if not rest:
        packer(groups, out.reshape(len(groups), -1))
        return
    whole = np.empty((len(groups), 5 if group == 4 else 3), np.uint8)
    packer(groups, whole)
    out[:] = whole.reshape(-1)[: out.size]


def pack_10p(groups: NDArray[np.uint16], out: Bytes) -> None:
    """Pack (n, 4) values into (n, 5) bytes: one stream of bits, pixel 0 in the lowest."""
    p0, p1, p2, p3 = groups.T
    out[:, 0] = p0 & 0xFF
    out[:, 1] = (p1 & 0x3F) << 2 | p0 >> 8
    out[:, 2] = (p2 & 0x0F) << 4 | p1 >> 6
    out[:, 3] = (p3 & 0x03) << 6 | p2 >> 4
    out[:, 4] = p3 >> 2


def pack_12p(groups: NDArray[np.uint16], out: Bytes) -> None:
    """Pack (n, 2) values into (n, 3) bytes: one stream of bits, pixel 0 in the lowest."""
    p0, p1 = groups.T
    out[:, 0] = p0 & 0xFF
    out[:, 1] = (p1 & 0x0F) << 4 | p0 >> 8
    out[:, 2] = p1 >> 4


def pack_10_packed(groups: NDArray[np.uint16], out: Bytes) -> None:
    """(n, 2) values to (n, 3) bytes: high bits in whole bytes around a byte of low bits."""
    p0, p1 = groups.T
    out[:, 0] = p0 >> 2
    out[:, 1] = (p1 & 0x03) << 4 | p0 & 0x03
    out[:, 2] = p1 >> 2


def pack_12_packed(groups: NDArray[np.uint16], out: Bytes) -> None:
    """(n, 2) values to (n, 3) bytes: high bits in whole bytes around a byte of low bits."""
    p0, p1 = groups.T
    out[:, 0] = p0 >> 4
    out[:, 1] = (p1 & 0x0F) << 4 | p0 & 0x0F
    out[:, 2] = p1 >> 4
