"""Chunk data of the simulated camera.

Each chunk is its data, its id and its length. GigE Vision writes id and length big-endian, USB3 Vision
little-endian; values are in the format of the XML.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from grabbergui.driver.sim.enumerations import CHUNK_ID_BASE, Chunk

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
"The feature with each chunk's value."


def chunk_bytes(chunks: tuple[Chunk, ...]) -> int:
    """Return the bytes that these chunks add to a payload; the image becomes a chunk, too."""
    return _TAG_BYTES + sum(_VALUE[chunk].size + _TAG_BYTES for chunk in chunks) if chunks else 0


def chunks_alone(chunks: tuple[Chunk, ...]) -> int:
    """Return the bytes of chunks without an image."""
    return sum(_VALUE[chunk].size + _TAG_BYTES for chunk in chunks)


def append_chunks(
    out: NDArray[np.uint8],
    image_bytes: int,
    values: Mapping[Chunk, float],
    *,
    little_endian: bool = False,
    image: bool = True,
) -> int:
    """Write chunks behind the image in `out`; return the length of the payload."""
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
