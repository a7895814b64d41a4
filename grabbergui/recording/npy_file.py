"""NumPy arrays (`.npy`) of frames, of this program and of others; each frame is read on demand."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from io import BufferedReader
from pathlib import Path
from typing import Any

import numpy as np
from typing_extensions import override

from grabbergui.core.encoded_image import LARGEST_SIDE, MOST_PIXELS
from grabbergui.core.errors import UsageError
from grabbergui.core.frame import Frame
from grabbergui.core.regular_files import open_regular
from grabbergui.recording.errors import RecordingError
from grabbergui.recording.file_names import notes_beside
from grabbergui.recording.notes import FrameNote, read_notes
from grabbergui.recording.reader import RecordingReader
from grabbergui.recording.stored_frames import rebuilt
from grabbergui.recording.times import DEFAULT_RATE, rising

MOST_FRAMES = 10_000_000
_MOST_HEADER = 1 << 14
_NAMES = {(1, "u1"): "Mono8", (1, "u2"): "Mono16", (3, "u1"): "RGB8", (3, "u2"): "RGB16", (4, "u1"): "RGBa8",
          (1, "i1"): "Data8s", (1, "i2"): "Data16s", (1, "u4"): "Data32", (1, "i4"): "Data32s",
          (1, "f4"): "Coord3D_C32f", (3, "f4"): "Coord3D_ABC32f", (1, "f8"): "Data64f"}  # fmt: skip
"Pixel formats of arrays without notes, by number of components and type of values; colours are R G B."
_MAGIC = b"\x93NUMPY"
_DESCRIBED = re.compile(r"'descr':\s*(?:'([^']{1,40})'|([^,]{1,60}))")
_ORDER = re.compile(r"'fortran_order':\s*(True|False)\b")
_SHAPE = re.compile(r"'shape':\s*\(((?:\s*\d{1,18}\s*,?)*)\s*\)")
_NUMBERS = re.compile(r"[<>|=]?[uif][1248]")


class NpyRecording(RecordingReader):
    """An array (frames, height, width[, 3 or 4]); (height, width[, 3 or 4]) is one frame."""

    def __init__(self, path: Path) -> None:
        """Open a file and check its header. Raises UsageError, RecordingError, OSError."""
        self.path = path
        self.title = path.name
        self._file = open_regular(path)
        try:
            self._index()
        except BaseException:
            self._file.close()
            raise

    @override
    def frame(self, index: int, received_ns: int) -> Frame:
        length = math.prod(self._shape) * self._dtype.itemsize
        self._file.seek(self._begin + index * length)
        content = self._file.read(length)
        if len(content) < length:
            raise RecordingError(f"{self.path} was cut short while it was played")
        pixels = np.frombuffer(content, self._dtype).reshape(self._shape)
        height, width = self._shape[:2]
        if self._notes:
            note = self._notes[index]
            if (note.width, note.height) != (width, height):
                raise RecordingError(f"{self.path} does not have {note.width}×{note.height} pixels as noted")
        else:
            note = replace(self._unnoted, frame_id=index)
        return rebuilt(pixels.astype(self._dtype.newbyteorder("<"), copy=False), note, received_ns)

    @override
    def close(self) -> None:
        self._file.close()

    def _index(self) -> None:
        shape, self._dtype = _header_of(self._file, self.path)
        self._begin = self._file.tell()
        if len(shape) == 2 or (len(shape) == 3 and shape[2] in (3, 4) and shape[0] > 4):
            shape = (1, *shape)  # one image
        self._shape = shape[1:]
        name = _NAMES.get((shape[3] if len(shape) == 4 else 1, self._dtype.str[1:]))
        sides_fit = all(0 < side <= LARGEST_SIDE for side in self._shape[:2])
        if len(shape) not in (3, 4) or not sides_fit or self._shape[0] * self._shape[1] > MOST_PIXELS:
            raise UsageError(
                f"{self.path} is an array of the shape {shape}, but (frames, height, width) or "
                "(frames, height, width, 3) can be played"
            )
        length = math.prod(self._shape) * self._dtype.itemsize
        count = min(shape[0], (self._file.seek(0, 2) - self._begin) // length, MOST_FRAMES)
        notes = notes_beside(self.path)
        self._notes = list(read_notes(notes))[:count] if notes.is_file() else []
        if self._notes:
            self.times_ns = rising([note.received_ns for note in self._notes])
        else:
            self.times_ns = [round(index * 1e9 / DEFAULT_RATE) for index in range(count)]
            if name is None:
                raise UsageError(f"{self.path} has values of {self._dtype} of {shape}, which cannot be shown")
            self._unnoted = FrameNote(width=self._shape[1], height=self._shape[0], pixel_format=name)
        if not self.times_ns:
            raise UsageError(f"{self.path} holds no frames")


def _header_of(file: BufferedReader, path: Path) -> tuple[tuple[int, ...], np.dtype[Any]]:
    """Return shape and type; leaves the file where the values begin. Raises UsageError.

    The header is the text of a Python dictionary (NEP 1). It is searched, not evaluated, as numpy does.
    """
    head = file.read(8)
    if len(head) < 8 or head[:6] != _MAGIC or head[6] not in (1, 2, 3):
        raise UsageError(f"{path} is no NumPy array (.npy)")
    length = int.from_bytes(file.read(2 if head[6] == 1 else 4), "little")
    text = file.read(length).decode("latin-1") if length <= _MOST_HEADER else ""
    described, order, shape = _DESCRIBED.search(text), _ORDER.search(text), _SHAPE.search(text)
    if described is None or order is None or shape is None:
        raise UsageError(f"{path} is a NumPy array without a header that can be read")
    name = described[1] or described[2]
    if not _NUMBERS.fullmatch(name):
        raise UsageError(f"{path} is an array of {name[:40]}, not of numbers")
    sides = tuple(int(side) for side in shape[1].replace(" ", "").split(",") if side)
    if order[1] == "True" and len(sides) > 1:
        raise UsageError(f"{path} has its values in Fortran's order; save np.ascontiguousarray of it")
    try:
        return sides, np.dtype(name)
    except TypeError:
        raise UsageError(f"{path} is an array of {name}, which is not known") from None
