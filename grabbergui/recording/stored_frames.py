"""Frames as recordings store them, and as they are built again from pixels and a note."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grabbergui.core import pfnc, vendor_formats
from grabbergui.core.component import PayloadType
from grabbergui.core.frame import Frame, FrameStatus
from grabbergui.core.pfnc import Family, PixelFormat
from grabbergui.recording.errors import RecordingError
from grabbergui.recording.notes import FrameNote, is_chunk_value


def note_of(frame: Frame, pixel_format: PixelFormat, file: str = "") -> FrameNote:
    """Return the note of a frame that is stored in a pixel format."""
    return FrameNote(
        file=file,
        width=frame.width,
        height=frame.height,
        pixel_format=stored_name(pixel_format),
        frame_id=frame.frame_id,
        timestamp_ns=frame.timestamp_ns,
        received_ns=frame.received_ns,
        offset_x=frame.offset_x,
        offset_y=frame.offset_y,
        complete=frame.complete,
        missing_bytes=frame.missing_bytes,
        chunks={name: value for name, value in frame.chunks.items() if is_chunk_value(value)},
    )


def unpacked(frame: Frame) -> tuple[NDArray[Any], PixelFormat]:
    """Return the pixels to store and their unpacked format. Raises PixelFormatError.

    They are those of `Frame.raw` if PFNC has a format for them, else the displayed ones in Mono8 or RGB8.
    """
    if not frame.pixel_format.convertible:
        frame.raw()
    pixel_format = pfnc.unpacked(frame.pixel_format)
    if pixel_format is not None:
        return frame.raw(), pixel_format
    if frame.pixel_format.family in (Family.MONO, Family.COORDINATES):
        return frame.mono(), pfnc.by_name("Mono8")
    return frame.rgb(), pfnc.by_name("RGB8")


def stored_name(pixel_format: PixelFormat) -> str:
    """Return a format's name for recordings: PFNC's; of any other the code, and the camera's name for it."""
    code = f"0x{pixel_format.code:08X}"
    if pfnc.is_known(pixel_format.code) or not pixel_format.code or pixel_format.name == code:
        return pixel_format.name
    return f"{code} {pixel_format.name}"


def format_named(name: str) -> PixelFormat:
    """Return the format that `stored_name` named. Raises RecordingError."""
    if code := re.match(r"(0x[0-9A-F]{8})(?: (\w{1,64}))?$", name, re.ASCII):
        return vendor_formats.of_camera(int(code[1], 16), code[2] or "")
    try:
        return pfnc.by_name(name)
    except KeyError:
        raise RecordingError(f"a recorded frame has the unknown pixel format '{name[:40]}'") from None


def rebuilt(pixels: NDArray[Any], note: FrameNote, received_ns: int) -> Frame:
    """Return a frame with stored pixels, or with the bytes of a payload that had no image.

    Raises RecordingError if the pixels do not match the note.
    """
    has_image = note.payload_type is PayloadType.IMAGE
    pixel_format = format_named(note.pixel_format) if has_image else PixelFormat(note.pixel_format, 0)
    pixels = pixels.astype(pixels.dtype.newbyteorder("<"), copy=False)
    payload = np.ascontiguousarray(pixels).reshape(-1).view(np.uint8)
    if pixel_format.convertible and payload.nbytes < pixel_format.image_bytes(note.width, note.height):
        raise RecordingError(
            f"a recorded frame of {note.width}×{note.height} {pixel_format} has only {payload.nbytes} bytes"
        )
    return Frame(
        payload,
        note.width,
        note.height,
        pixel_format,
        frame_id=note.frame_id,
        timestamp_ns=note.timestamp_ns,
        received_ns=received_ns,
        offset_x=note.offset_x,
        offset_y=note.offset_y,
        status=FrameStatus.COMPLETE if note.complete else FrameStatus.INCOMPLETE,
        missing_bytes=note.missing_bytes,
        chunks=dict(note.chunks),
        payload_type=note.payload_type,
    )
