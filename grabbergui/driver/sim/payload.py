"""Chunk data behind the image of a payload.

Each chunk is its data, its id and its length; GigE
Vision writes id and length big-endian, USB3 Vision little-endian; the values are as the XML describes them.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from grabbergui.driver.sim.registers import CHUNK_ID_BASE, Chunk

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
