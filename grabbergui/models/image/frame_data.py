"""The metadata of a frame as rows of text: number, times, completeness, chunk data."""

from __future__ import annotations

import time

from grabbergui.core.features import format_value
from grabbergui.core.frame import Frame
from grabbergui.core.visible_text import shortened
from grabbergui.models.language import counted, localized, translate

MOST_TEXT = 200
"Characters of a value; a chunk may be long."


def frame_rows(frame: Frame) -> list[tuple[str, str]]:
    """Return names and values, the chunk data last, under the camera's own names."""
    rows = [
        (translate("FrameData", "Frame id"), str(frame.frame_id)),
        (translate("FrameData", "Exposed or received at"), _time_text(frame.received_ns)),
        (translate("FrameData", "Camera's clock"), _clock_text(frame.timestamp_ns)),
        (translate("FrameData", "Size"), f"{frame.width} × {frame.height}"),
        (translate("FrameData", "Pixel format"), str(frame.pixel_format)),
        (translate("FrameData", "Offset"), f"{frame.offset_x}, {frame.offset_y}"),
        (translate("FrameData", "Payload"), _bytes_text(frame.payload.nbytes)),
        (translate("FrameData", "Completeness"), _completeness(frame)),
    ]
    if frame.stream_channel:
        rows.append((translate("FrameData", "Stream channel"), str(frame.stream_channel)))
    if frame.file_name:
        rows.append((translate("FrameData", "File"), shortened(frame.file_name, MOST_TEXT)))
    return [*rows, *((name, _chunk_text(value)) for name, value in sorted(frame.chunks.items()))]


def _bytes_text(count: int) -> str:
    return counted(count, translate("FrameData", "1 byte"), translate("FrameData", "{0} bytes"))


def _time_text(received_ns: int) -> str:
    """Return a time of day to the microsecond; a dash if it is not known."""
    if not received_ns:
        return "–"
    seconds, rest = divmod(received_ns, 1_000_000_000)
    return time.strftime(f"%Y-%m-%d %H:%M:%S.{rest // 1000:06d}", time.localtime(seconds))


def _clock_text(timestamp_ns: int) -> str:
    return localized(f"{timestamp_ns / 1e9:.6f} s") if timestamp_ns else "–"


def _completeness(frame: Frame) -> str:
    if frame.complete:
        return translate("FrameData", "complete")
    return counted(
        frame.missing_bytes,
        translate("FrameData", "1 byte is missing"),
        translate("FrameData", "{0} bytes are missing"),
    )


def _chunk_text(value: object) -> str:
    if isinstance(value, bool | int | float | str):
        return shortened(format_value(value), MOST_TEXT)
    return shortened(str(value), MOST_TEXT)
