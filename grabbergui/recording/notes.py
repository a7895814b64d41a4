"""The notes of a recording: the metadata of each frame as a line of JSON."""

from __future__ import annotations

import io
import json
import math
from collections.abc import Iterator
from dataclasses import dataclass, field, fields, replace
from pathlib import Path

from grabbergui.core.component import PayloadType
from grabbergui.core.errors import UsageError
from grabbergui.core.json_text import to_json
from grabbergui.core.regular_files import open_regular
from grabbergui.recording.errors import RecordingError

MAX_LINE = 1 << 16
"Most characters of a note."
MAX_SIDE = 65536
"Largest width and height in pixels."

ChunkValue = bool | int | float | str
_RARE = {"complete": True, "missing_bytes": 0, "chunks": {}}
"Values of a note that are left out, because nearly every frame has them."
_TYPES = {"file": str, "pixel_format": str, "complete": bool, "chunks": dict}
"Types of the values of a note that are no whole numbers."
_WITHOUT_IMAGE = {kind.value: kind for kind in PayloadType if kind is not PayloadType.IMAGE}


@dataclass(frozen=True, kw_only=True)
class FrameNote:
    """The metadata of a recorded frame."""

    file: str = ""
    "Its file in the recording's folder; empty if pixels are elsewhere."
    width: int
    height: int
    pixel_format: str
    "PFNC name of the stored pixels; the payload's type if it has no image, as in `raw data`."
    frame_id: int = 0
    timestamp_ns: int = 0
    "Device clock."
    received_ns: int = 0
    "Host clock, since the epoch."
    offset_x: int = 0
    offset_y: int = 0
    complete: bool = True
    "Whether all of its payload arrived."
    missing_bytes: int = 0
    chunks: dict[str, ChunkValue] = field(default_factory=dict)
    "Chunk data by feature name."

    @property
    def payload_type(self) -> PayloadType:
        """The type of a payload of 0×0 pixels, which has no image; else IMAGE."""
        without_image = not (self.width or self.height)
        return (
            _WITHOUT_IMAGE.get(self.pixel_format, PayloadType.IMAGE) if without_image else PayloadType.IMAGE
        )

    def line(self) -> str:
        """Return a line of JSON, including its end; without chunk data if they would make it too long."""
        values = {
            name: value for name, value in vars(self).items() if name not in _RARE or value != _RARE[name]
        }
        text = to_json(values, compact=True)
        return text + "\n" if len(text) < MAX_LINE else replace(self, chunks={}).line()


def is_chunk_value(value: object) -> bool:
    """Return whether JSON has the value; it has no infinite numbers, and no bytes."""
    return isinstance(value, ChunkValue) and not (isinstance(value, float) and not math.isfinite(value))


def read_notes(path: Path) -> Iterator[FrameNote]:
    """Yield the notes of a file, one per line, without a last line that a crash cut short.

    Raises UsageError, RecordingError.
    """
    try:
        with io.TextIOWrapper(open_regular(path), encoding="utf-8") as file:
            number = 0
            while line := file.readline(MAX_LINE + 1):
                number += 1
                if not line.endswith("\n"):
                    if len(line) > MAX_LINE:
                        raise UsageError(f"{path}, line {number}: longer than {MAX_LINE} characters")
                    return
                yield parse_note(line, f"{path}, line {number}")
    except UnicodeDecodeError:
        raise UsageError(f"{path} is not text; it should hold a line of JSON for each frame") from None
    except OSError as error:
        raise RecordingError(f"{path} could not be read: {error.strerror or error}") from error


def parse_note(line: str, where: str) -> FrameNote:
    """Return the note in a line of JSON; `where` names it in errors. Raises UsageError."""
    try:
        values = json.loads(line)
        known = {field.name: values[field.name] for field in fields(FrameNote) if field.name in values}
        note = FrameNote(**known)
    except (ValueError, TypeError, KeyError, RecursionError):
        raise UsageError(f"{where}: '{line[:60].strip()}' is not the note of a frame") from None
    right = all(type(value) is _TYPES.get(name, int) for name, value in vars(note).items())
    if not right or not all(map(is_chunk_value, note.chunks.values())):
        raise UsageError(f"{where}: a value of the frame's note has the wrong type")
    numbers = [value for value in vars(note).values() if type(value) is int]
    has_size = 0 < note.width <= MAX_SIDE and 0 < note.height <= MAX_SIDE
    if not (has_size or note.payload_type is not PayloadType.IMAGE) or min(numbers) < 0:
        raise UsageError(f"{where}: a frame of {note.width}×{note.height} pixels is impossible")
    if max(numbers) >= 2**64:
        raise UsageError(f"{where}: a number has more than 64 bits")
    return note
