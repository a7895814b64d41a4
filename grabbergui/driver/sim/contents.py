"""Payloads other than one plain image: components, containers, compressed images, video.

Components follow each other in their order, chunks are last. A GenDC container begins with its descriptor.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.core.component import ComponentKind, PayloadType
from grabbergui.core.pfnc import PixelFormat, by_name
from grabbergui.driver import gendc
from grabbergui.driver.sim.chunks import append_chunks, chunk_bytes, chunks_alone
from grabbergui.driver.sim.enumerations import Chunk
from grabbergui.driver.sim.h264_encoder import H264Encoder
from grabbergui.driver.sim.packing import sensor_depth
from grabbergui.driver.sim.settings import FrameSettings

FILE_NAME = "frame.raw"
COMPRESSED_RESERVE = 64 << 10
"Bytes beyond those of the plain image that a compressed one may take."
_SMALLEST_OF_OPENJPEG = 32
"Pixels of the shorter side: OpenCV has it halve an image five times."
_SUFFIX = {PayloadType.JPEG: ".jpg", PayloadType.JPEG2000: ".jp2"}
_FORMATS = {ComponentKind.RANGE: by_name("Coord3D_C16"), ComponentKind.CONFIDENCE: by_name("Confidence8")}
NEAREST_MM, STEP_MM = 600.0, 0.1
"Nearest distance and step of the range component; `camera.xml` has the step as Scan3dCoordinateScale."


@dataclass(frozen=True)
class Piece:
    """One component, or the chunks, in a payload."""

    kind: ComponentKind
    "METADATA for chunks."
    pixel_format: PixelFormat
    begin: int
    length: int


def pieces(settings: FrameSettings, chunks: tuple[Chunk, ...]) -> tuple[Piece, ...]:
    """Return offset and length of each component of a multi-part block or a container."""
    begin, found = first_piece(settings, chunks), []
    for kind in settings.components:
        pixel_format = _FORMATS.get(kind, settings.pixel_format)
        length = pixel_format.image_bytes(settings.width, settings.height)
        found.append(Piece(kind, pixel_format, begin, length))
        begin += length
    if chunks:
        found.append(Piece(ComponentKind.METADATA, PixelFormat("chunks", 0), begin, chunks_alone(chunks)))
    return tuple(found)


def first_piece(settings: FrameSettings, chunks: tuple[Chunk, ...]) -> int:
    """Return the offset of the image: behind the descriptor of a container."""
    if settings.payload_type is not PayloadType.GENDC:
        return 0
    return gendc.descriptor_size([1] * (len(settings.components) + bool(chunks)))


def payload_bytes(settings: FrameSettings, chunks: tuple[Chunk, ...]) -> int:
    """Return the bytes of the largest payload."""
    kind = settings.payload_type
    if kind in (PayloadType.MULTI_PART, PayloadType.GENDC):
        last = pieces(settings, chunks)[-1]
        return last.begin + last.length
    if kind is PayloadType.CHUNK:
        return max(chunks_alone(chunks), 4)
    if kind in (PayloadType.RAW_DATA, PayloadType.FILE):
        return settings.image_bytes
    reserve = COMPRESSED_RESERVE if kind in _SUFFIX or kind is PayloadType.H264 else 0
    return settings.image_bytes + reserve + chunk_bytes(chunks)


def complete(
    settings: FrameSettings,
    frame_id: int,
    values: NDArray[Any],
    chunk_values: Mapping[Chunk, float],
    out: NDArray[np.uint8],
    video: H264Encoder,
    *,
    little_endian: bool,
) -> int:
    """Write all but the image, which is in `out` already; return the payload's length.

    `values` are those of the image before packing.
    """
    kind, chunks = settings.payload_type, tuple(chunk_values)
    if kind in (PayloadType.RAW_DATA, PayloadType.FILE):
        return settings.image_bytes
    if kind is PayloadType.CHUNK:
        return append_chunks(out, 0, chunk_values, little_endian=little_endian, image=False)
    if kind in (PayloadType.MULTI_PART, PayloadType.GENDC):
        return _write_pieces(settings, frame_id, chunk_values, out, little_endian=little_endian)
    if kind is PayloadType.H264:
        data = video.encode(frame_id, _eight_bits(values, sensor_depth(settings.pixel_format)))
        out[: len(data)] = data
        return len(data)
    length = settings.image_bytes
    if kind in _SUFFIX:
        data = _compressed(values, sensor_depth(settings.pixel_format), kind, length + COMPRESSED_RESERVE)
        length = len(data)
        out[:length] = data
    if not chunks:
        return length
    return append_chunks(out, length, chunk_values, little_endian=little_endian)


def _write_pieces(
    settings: FrameSettings,
    frame_id: int,
    chunk_values: Mapping[Chunk, float],
    out: NDArray[np.uint8],
    *,
    little_endian: bool,
) -> int:
    parts = pieces(settings, tuple(chunk_values))
    for piece in parts:
        data = out[piece.begin : piece.begin + piece.length]
        if piece.kind is ComponentKind.RANGE:
            data.view("<u2").reshape(settings.height, settings.width)[...] = range_image(settings, frame_id)
        elif piece.kind is ComponentKind.CONFIDENCE:
            valid = range_image(settings, frame_id) > 0
            data.reshape(settings.height, settings.width)[...] = valid * np.uint8(255)
        elif piece.kind is ComponentKind.METADATA:
            append_chunks(data, 0, chunk_values, little_endian=little_endian, image=False)
    if settings.payload_type is PayloadType.GENDC:
        descriptor = _container(settings, frame_id, parts).encode()
        out[: len(descriptor)] = np.frombuffer(descriptor, np.uint8)
    return parts[-1].begin + parts[-1].length


def _container(settings: FrameSettings, frame_id: int, parts: tuple[Piece, ...]) -> gendc.Container:
    components = []
    for piece in parts:
        chunks = piece.kind is ComponentKind.METADATA
        header = gendc.PartHeader(
            gendc.HeaderType.CHUNK if chunks else gendc.HeaderType.IMAGE_2D,
            piece.pixel_format.code,
            piece.length,
            piece.begin,
            0 if chunks else settings.width,
            0 if chunks else settings.height,
            flow_offset=piece.begin,
        )
        components.append(
            gendc.ComponentHeader(
                piece.kind,
                piece.pixel_format.code,
                (header,),
                offset_x=settings.offset_x,
                offset_y=settings.offset_y,
            )
        )
    begin = parts[0].begin
    size = parts[-1].begin + parts[-1].length - begin
    return gendc.Container(tuple(components), frame_id, size, begin, begin)


def range_image(settings: FrameSettings, frame_id: int) -> NDArray[np.uint16]:
    """Return distances (height, width) in steps of 0.1 mm: a sloped plane with a ball moving in front of it.

    0 means not measured, in the ball's shadow.
    """
    width, height = settings.width, settings.height
    side = max(min(width, height), 1)
    plane = NEAREST_MM + 400.0 + 300.0 * np.arange(height, dtype=np.float32) / side
    steps = np.repeat(_in_steps(plane)[:, None], width, axis=1)
    # The rest happens near the ball, whose middle is at (middle, height / 2).
    middle = frame_id * 4 % max(width, 1)
    left, right = max(middle - side // 5 - 1, 0), min(middle + 3 * side // 10 + 2, width)
    top, bottom = max((height - 2 * side // 5) // 2 - 1, 0), (height + 2 * side // 5) // 2 + 2
    rows, columns = np.mgrid[top : min(bottom, height), left:right].astype(np.float32)
    x, y = (columns - middle) / side, (rows - height / 2) / side
    apart = np.hypot(x, y)
    ball = apart < 0.2
    part = steps[top:bottom, left:right]
    part[np.hypot(x - 0.1, y) < 0.2] = 0
    part[ball] = _in_steps(NEAREST_MM + 200.0 - 150.0 * np.sqrt(0.04 - apart[ball] ** 2) / 0.2)
    return steps


def _in_steps(millimetres: NDArray[np.floating[Any]]) -> NDArray[np.uint16]:
    steps: NDArray[np.uint16] = np.rint(millimetres / STEP_MM).astype(np.uint16)
    return steps


def _compressed(values: NDArray[Any], depth: int, kind: PayloadType, most: int) -> NDArray[np.uint8]:
    eight = _eight_bits(values, depth)
    image = eight[:, :, ::-1] if eight.ndim == 3 else eight
    jpeg = kind is PayloadType.JPEG
    if not jpeg and min(image.shape[:2]) < _SMALLEST_OF_OPENJPEG:
        return _small_jpeg2000(eight)
    for quality in (90, 60, 20):
        options = (
            [cv2.IMWRITE_JPEG_QUALITY, quality]
            if jpeg
            else [cv2.IMWRITE_JPEG2000_COMPRESSION_X1000, quality * 3]
        )
        encoded, data = cv2.imencode(_SUFFIX[kind], np.ascontiguousarray(image), options)
        found: NDArray[np.uint8] = np.asarray(data).reshape(-1)
        if encoded and len(found) <= most:
            return found
    raise ValueError(f"no {kind.value} image of {image.shape} fits {most} bytes")


def _small_jpeg2000(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    import av

    encoder: Any = av.CodecContext.create("jpeg2000", "w")
    encoder.height, encoder.width = image.shape[:2]
    encoder.pix_fmt = "rgb24" if image.ndim == 3 else "gray"
    encoder.time_base = Fraction(1, 30)
    frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(image), format=encoder.pix_fmt)
    packets = [*encoder.encode(frame), *encoder.encode(None)]
    return np.frombuffer(b"".join(bytes(packet) for packet in packets), np.uint8)


def _eight_bits(values: NDArray[Any], depth: int) -> NDArray[np.uint8]:
    return (values >> (depth - 8)).astype(np.uint8) if depth > 8 else values
