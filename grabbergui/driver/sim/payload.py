"""The bytes of a payload: pixels packed as in PFNC, and chunk data behind the image.

Packing is the inverse of `core.pixels`, written independently. All packers take whole values (the value in
the low bits) in the order of the lines and fill a byte array. Packed formats continue across the end of a
line; the last incomplete group is filled with zeros. Each chunk is its data, its id and its length; GigE
Vision writes id and length big-endian, USB3 Vision little-endian; the values are as the XML describes them.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.core.pfnc import Layout, PixelFormat
from grabbergui.driver.sim.registers import CHUNK_ID_BASE, Chunk

Bytes = NDArray[np.uint8]


def pack(values: NDArray[Any], pixel_format: PixelFormat, out: Bytes) -> None:
    """Mono or Bayer values, 8 or 16 bits each, into `out` of exactly the image's bytes."""
    if pixel_format.layout is Layout.WHOLE:
        out.view(values.dtype.newbyteorder("<")).reshape(values.shape)[...] = values
    elif pixel_format.layout is Layout.PACKED_LSB and pixel_format.depth == 10:
        _fill(pack_10p, values, 4, out)
    elif pixel_format.layout is Layout.PACKED_LSB:
        _fill(pack_12p, values, 2, out)
    elif pixel_format.depth == 10:
        _fill(pack_10_packed, values, 2, out)
    else:
        _fill(pack_12_packed, values, 2, out)


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
    """(n, 4) values to (n, 5) bytes: one stream of bits, pixel 0 in the lowest."""
    p0, p1, p2, p3 = groups.T
    out[:, 0] = p0 & 0xFF
    out[:, 1] = (p1 & 0x3F) << 2 | p0 >> 8
    out[:, 2] = (p2 & 0x0F) << 4 | p1 >> 6
    out[:, 3] = (p3 & 0x03) << 6 | p2 >> 4
    out[:, 4] = p3 >> 2


def pack_12p(groups: NDArray[np.uint16], out: Bytes) -> None:
    """(n, 2) values to (n, 3) bytes: one stream of bits, pixel 0 in the lowest."""
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


def pack_colour(rgb: NDArray[np.uint8], pixel_format: PixelFormat, out: Bytes) -> None:
    """(height, width, 3) R G B into RGB8, BGR8, RGBa8, BGRa8 or a YUV 4:2:2 format."""
    height, width = rgb.shape[:2]
    if pixel_format.layout is Layout.YUV422:
        _pack_yuv422(rgb, pixel_format.order, out.reshape(height, width, 2))
        return
    target = out.reshape(height, width, pixel_format.components)
    code = {
        "BGR": cv2.COLOR_RGB2BGR,
        "RGBa": cv2.COLOR_RGB2RGBA,
        "BGRa": cv2.COLOR_RGB2BGRA,
    }.get(pixel_format.order)
    if code is None:
        target[...] = rgb
    else:
        cv2.cvtColor(rgb, code, dst=target)


def _pack_yuv422(rgb: NDArray[np.uint8], order: str, out: NDArray[np.uint8]) -> None:
    """Y'CbCr of BT.601 over the full range; a chroma sample is the mean of two pixels."""
    ycc: NDArray[Any] = cv2.cvtColor(rgb, cv2.COLOR_RGB2YCrCb)
    luma, chroma = (0, 1) if order == "YUYV" else (1, 0)
    out[:, :, luma] = ycc[:, :, 0]
    red, blue = ((ycc[:, 0::2, index].astype(np.uint16) + ycc[:, 1::2, index] + 1) >> 1 for index in (1, 2))
    out[:, 0::2, chroma] = blue
    out[:, 1::2, chroma] = red


_VALUE = {
    Chunk.FRAME_ID: struct.Struct(">q"),
    Chunk.TIMESTAMP: struct.Struct(">q"),
    Chunk.EXPOSURE_TIME: struct.Struct(">d"),
    Chunk.GAIN: struct.Struct(">d"),
}
_TAG_BYTES = 8
CHUNK_FEATURE = {
    Chunk.FRAME_ID: "ChunkFrameID",
    Chunk.TIMESTAMP: "ChunkTimestamp",
    Chunk.EXPOSURE_TIME: "ChunkExposureTime",
    Chunk.GAIN: "ChunkGain",
}
"The feature that shows each chunk's value."


def chunk_bytes(chunks: tuple[Chunk, ...]) -> int:
    """By how much these chunks lengthen a payload; the picture itself becomes a chunk too."""
    return _TAG_BYTES + sum(_VALUE[chunk].size + _TAG_BYTES for chunk in chunks) if chunks else 0


def chunks_alone(chunks: tuple[Chunk, ...]) -> int:
    """Return the bytes of chunks that follow no image."""
    return sum(_VALUE[chunk].size + _TAG_BYTES for chunk in chunks)


def append_chunks(
    out: NDArray[np.uint8],
    image_bytes: int,
    values: Mapping[Chunk, float],
    *,
    little_endian: bool = False,
    image: bool = True,
) -> int:
    """Write chunks behind the picture in `out`; returns the payload's length."""
    tag = struct.Struct("<II" if little_endian else ">II")
    position = image_bytes
    if image:
        tag.pack_into(out.data, position, CHUNK_ID_BASE + Chunk.IMAGE, image_bytes)
        position += _TAG_BYTES
    for chunk, value in values.items():
        layout = _VALUE[chunk]
        layout.pack_into(out.data, position, value)
        position += layout.size
        tag.pack_into(out.data, position, CHUNK_ID_BASE + chunk, layout.size)
        position += _TAG_BYTES
    return position
