"""Finds the image of a frame whose payload is chunks (GigE Vision payload type 4), if it is a chunk itself.

The leader then has no size and no pixel format; ChunkWidth, ChunkHeight and ChunkPixelFormat have (SFNC,
Chunk Data Control). What the camera does not send as a chunk is taken from its features.
"""

from __future__ import annotations

from collections.abc import Mapping

from grabbergui.core import vendor_formats
from grabbergui.core.component import PayloadType
from grabbergui.core.features import FeatureValue
from grabbergui.core.frame import Frame
from grabbergui.driver.device import DataLayout
from grabbergui.driver.genapi.chunk_reader import chunk_spans

GEOMETRY = ("Width", "Height", "PixelFormat", "OffsetX", "OffsetY")
"Features that describe the image, and with `Chunk` before them the chunks that do."


def take_image(frame: Frame, layout: DataLayout, settings: Mapping[str, FeatureValue]) -> bool:
    """Make the image in a frame of chunks the frame's own; return whether there is one.

    `settings`: the camera's values of GEOMETRY, which its chunks replace. The image is the first chunk that
    is long enough.
    """
    if frame.payload_type is not PayloadType.CHUNK or frame.has_image or not frame.complete:
        return False
    width, height, pixel_format, offset_x, offset_y = (
        frame.chunks.get(f"Chunk{name}", settings.get(name, 0)) for name in GEOMETRY
    )
    found = vendor_formats.named(str(pixel_format))
    if not isinstance(width, int) or not isinstance(height, int) or width < 1 or height < 1 or not found:
        return False
    payload = frame.payload if frame.chunk_payload is None else frame.chunk_payload
    size = found.image_bytes(width, height)
    for _, begin, length in chunk_spans(payload, layout):
        if length >= size:
            frame.width, frame.height, frame.pixel_format = width, height, found
            frame.offset_x, frame.offset_y = (v if isinstance(v, int) else 0 for v in (offset_x, offset_y))
            frame.chunk_payload, frame.payload = payload, payload[begin : begin + length]
            frame.payload_type = PayloadType.IMAGE
            return True
    return False
