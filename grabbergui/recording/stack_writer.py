"""Writes frames into one file of arrays: a multi-page TIFF (TIFF 6.0), or a NumPy array (`.npy`, format 1.0).

Both are readable after each frame: a page is linked, and the header of the array counts a frame, once its
pixels are in the file. The notes beside it (`name.frames.jsonl`) have the frames' times and pixel formats.
"""

from __future__ import annotations

import struct
from abc import abstractmethod
from io import BufferedRandom
from pathlib import Path
from typing import Any, TextIO, cast

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from grabbergui.core import pfnc
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import Family, PixelFormat
from grabbergui.recording.errors import RecordingError
from grabbergui.recording.file_names import notes_beside
from grabbergui.recording.stored_frames import note_of, unpacked
from grabbergui.recording.writer import RecordingWriter

_LARGEST_TIFF = (1 << 32) - 1
"Bytes. Places in a TIFF have 32 bits."
_FORMATS = {"u": 1, "i": 2, "f": 3}
"TIFF's SampleFormat of NumPy's kinds."
_HEADER = 128
"Bytes of the header of an array, a multiple of 64."


class StackWriter(RecordingWriter):
    """Writes pixels of one frame after the other to a file, and its notes beside it."""

    def __init__(self, path: Path) -> None:
        """Create the files. Raises OSError."""
        self.path = path
        self._notes: TextIO = notes_beside(path).open("x", encoding="utf-8", buffering=1)
        try:
            self._file = cast(BufferedRandom, path.open("xb"))
        except OSError:
            self._notes.close()
            notes_beside(path).unlink()
            raise
        self._end = 0
        "Bytes of complete frames."

    @override
    def write(self, frame: Frame) -> None:
        pixels, pixel_format = self._pixels(frame)
        self._file.seek(self._end)
        self._append(np.ascontiguousarray(pixels))
        self._file.flush()
        self._notes.write(note_of(frame, pixel_format).line())

    @override
    def close(self) -> None:
        try:
            self._file.close()
        finally:
            self._notes.close()

    @override
    def discard(self) -> None:
        notes_beside(self.path).unlink(missing_ok=True)
        super().discard()

    @override
    def size(self) -> int:
        return self._end if not self._file.closed else self.path.stat().st_size

    def _pixels(self, frame: Frame) -> tuple[NDArray[Any], PixelFormat]:
        """Return the pixels to store and their format; colours as R G B. Raises PixelFormatError."""
        pixels, pixel_format = unpacked(frame)
        if pixel_format.family is Family.RGB and not pixel_format.order.startswith("R"):
            order = [2, 1, 0, 3][: pixels.shape[2]]
            return pixels[..., order], pfnc.by_name(pixel_format.name.replace("BGR", "RGB"))
        return pixels, pixel_format

    @abstractmethod
    def _append(self, pixels: NDArray[Any]) -> None:
        """Write the pixels of a frame at the end, and set `_end`. Raises RecordingError, OSError."""


class TiffWriter(StackWriter):
    """Writes a page for each frame, uncompressed. Pages may differ in size and format."""

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self._file.write(struct.pack("<2sHI", b"II", 42, 0))
        self._link = 4
        "Where the place of the next page is to be written."
        self._end = 8

    @override
    def _pixels(self, frame: Frame) -> tuple[NDArray[Any], PixelFormat]:
        pixels, pixel_format = super()._pixels(frame)
        if pixels.ndim == 3 and pixel_format.family is not Family.RGB:
            return frame.rgb(), pfnc.by_name("RGB8")  # TIFF has no YUV of ours, and no coordinates
        return pixels, pixel_format

    @override
    def _append(self, pixels: NDArray[Any]) -> None:
        at, directory = self._end, self._end + pixels.nbytes + pixels.nbytes % 2
        tags = self._tags(pixels, at, directory)
        if directory + len(tags) > _LARGEST_TIFF:
            raise RecordingError(f"{self.path} is full: a TIFF has at most 4 GiB; record a folder or .npy")
        self._file.write(pixels.data)
        self._file.write(bytes(pixels.nbytes % 2) + tags)
        self._file.flush()
        self._file.seek(self._link)
        self._file.write(struct.pack("<I", directory))
        self._link = directory + 2 + 12 * struct.unpack_from("<H", tags)[0]
        self._end = directory + len(tags)

    def _tags(self, pixels: NDArray[Any], at: int, directory: int) -> bytes:
        """Return the directory of a page (TIFF 6.0, section 2), and the values that do not fit into it."""
        height, width = pixels.shape[:2]
        samples = pixels.shape[2] if pixels.ndim == 3 else 1
        bits, sample_format = 8 * pixels.dtype.itemsize, _FORMATS[pixels.dtype.kind]
        entries = [
            (256, 4, [width]),
            (257, 4, [height]),
            (258, 3, [bits] * samples),
            (259, 3, [1]),
            (262, 3, [2 if samples > 1 else 1]),
            (273, 4, [at]),
            (277, 3, [samples]),
            (278, 4, [height]),
            (279, 4, [pixels.nbytes]),
            (284, 3, [1]),
            *([(338, 3, [2])] if samples == 4 else []),
            (339, 3, [sample_format] * samples),
        ]
        content, beyond = struct.pack("<H", len(entries)), b""
        after = directory + 2 + 12 * len(entries) + 4
        for tag, kind, values in entries:
            packed = struct.pack(f"<{len(values)}{'H' if kind == 3 else 'I'}", *values)
            if len(packed) > 4:
                packed, beyond = struct.pack("<I", after + len(beyond)), beyond + packed
            content += struct.pack("<HHI", tag, kind, len(values)) + packed.ljust(4, b"\0")
        return content + bytes(4) + beyond


class NpyWriter(StackWriter):
    """Writes an array of all frames, (frames, height, width[, components]), of one size and type."""

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self._layout: tuple[tuple[int, ...], np.dtype[Any]] | None = None
        self._count = 0

    @override
    def _append(self, pixels: NDArray[Any]) -> None:
        pixels = pixels.astype(pixels.dtype.newbyteorder("<"), copy=False)
        layout = (pixels.shape, pixels.dtype)
        if self._layout is None:
            self._layout = layout
            self._file.write(self._header(0))
            self._end = _HEADER
        if layout != self._layout:
            raise RecordingError(
                f"{self.path}: the frames' size or format changed; an array cannot follow, .mcap can"
            )
        self._file.write(pixels.data)
        self._file.flush()
        self._end += pixels.nbytes
        self._count += 1
        self._file.seek(0)
        self._file.write(self._header(self._count))

    def _header(self, count: int) -> bytes:
        assert self._layout is not None
        shape, dtype = self._layout
        sides = ", ".join(map(str, (f"{count:<12}", *shape)))
        text = f"{{'descr': '{dtype.str}', 'fortran_order': False, 'shape': ({sides}), }}"
        return (
            b"\x93NUMPY\x01\x00" + struct.pack("<H", _HEADER - 10) + text.ljust(_HEADER - 11).encode() + b"\n"
        )
