"""Folders of image files, with or without a recorder's notes."""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TextIO

import cv2
import numpy as np
from typing_extensions import override

from grabbergui.core import encoded_image, pfnc
from grabbergui.core.errors import RemoteProtocolError, UsageError
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import Family, PixelFormat
from grabbergui.core.regular_files import read_bounded
from grabbergui.recording import (
    DEFAULT_RATE,
    FrameNote,
    Recording,
    RecordingError,
    format_named,
    read_notes,
    rebuilt,
    rising,
)
from grabbergui.recording.writer import OrderedWork, RecordingWriter, note_of, unpacked

NOTES_NAME = "frames.jsonl"
IMAGE_SUFFIXES = (".png", ".tif", ".tiff", ".jpg", ".jpeg", ".bmp")
MAX_FILE_BYTES = 1 << 30


class FolderRecording(Recording):
    """Images in the order of the notes, or of their names."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.title = path.name
        notes_file = path / NOTES_NAME
        if notes_file.is_file():
            self._notes: list[FrameNote | None] = list(read_notes(notes_file))
            self._files = [self._inside(note.file) for note in self._notes if note is not None]
            self.times_ns = rising([note.received_ns for note in self._notes if note is not None])
        else:
            self._files = sorted(p for p in path.iterdir() if p.suffix.lower() in IMAGE_SUFFIXES)
            self._notes = [None] * len(self._files)
            self.times_ns = [round(index * 1e9 / DEFAULT_RATE) for index in range(len(self._files))]
        if not self._files:
            raise UsageError(
                f"{path} holds no images; a recording has {NOTES_NAME} or {', '.join(IMAGE_SUFFIXES)}"
            )

    @override
    def frame(self, index: int, received_ns: int) -> Frame:
        file, note = self._files[index], self._notes[index]
        try:
            content = np.frombuffer(read_bounded(file, MAX_FILE_BYTES, "image"), np.uint8)
        except OSError as error:
            raise RecordingError(f"{file} could not be read: {error.strerror or error}") from error
        except UsageError as error:
            raise RecordingError(str(error)) from error
        if note is not None and file.suffix == ".raw":
            return rebuilt(content, note, received_ns)
        try:
            pixels = encoded_image.decode(content)
        except RemoteProtocolError as error:
            raise RecordingError(f"{file}: {error}") from None
        if note is None:
            note = _foreign(pixels, index, file)
        elif (pixel_format := format_named(note.pixel_format)).family is Family.RGB and pixels.ndim == 3:
            channels = file_channels(pixel_format)
            if len(channels) > pixels.shape[2]:
                raise RecordingError(f"{file} has no alpha, which {note.pixel_format} in {NOTES_NAME} has")
            pixels = pixels[..., channels]
        if pixels.shape[:2] != (note.height, note.width):
            raise RecordingError(
                f"{file} does not have {note.width}×{note.height} pixels as {NOTES_NAME} says"
            )
        return rebuilt(pixels, note, received_ns)

    @override
    def close(self) -> None:
        pass

    def _inside(self, name: str) -> Path:
        """Return a file of this folder. Raises UsageError for any other, as notes must not read those."""
        if not name or name != Path(name).name or name in (".", ".."):
            raise UsageError(f"{self.path / NOTES_NAME} names '{name[:60]}', which is not in its folder")
        return self.path / name


def file_channels(pixel_format: PixelFormat) -> list[int]:
    """Return the indices of a format's components in an image file, which OpenCV orders as B G R A.

    The same indices convert back, as they only swap red and blue.
    """
    order = pixel_format.order
    return [2, 1, 0, 3][: len(order)] if order.startswith("R") else [0, 1, 2, 3][: len(order)]


_FOREIGN = {(1, "u1"): "Mono8", (1, "u2"): "Mono16", (3, "u1"): "BGR8", (3, "u2"): "BGR16",
            (4, "u1"): "BGRa8", (4, "u2"): "BGRa16"}  # fmt: skip
"Pixel formats of images without a note, by number of components and type of values."


def _foreign(pixels: np.ndarray, index: int, file: Path) -> FrameNote:
    """Return the note of an image without one. Raises RecordingError for values that no sensor has."""
    components = pixels.shape[2] if pixels.ndim == 3 else 1
    name = _FOREIGN.get((components, pixels.dtype.str[1:]))
    if name is None:
        raise RecordingError(
            f"{file} has {components} components of {pixels.dtype} and cannot be played; "
            "images of 1, 3 or 4 components of uint8 or uint16 can"
        )
    height, width = pixels.shape[:2]
    return FrameNote(width=width, height=height, pixel_format=name, frame_id=index)


_PNG = [cv2.IMWRITE_PNG_COMPRESSION, 1, cv2.IMWRITE_PNG_STRATEGY, cv2.IMWRITE_PNG_STRATEGY_HUFFMAN_ONLY]
_PNG += [cv2.IMWRITE_PNG_FILTER, cv2.IMWRITE_PNG_FILTER_UP]
"""For images of a noisy sensor, searching repetitions takes three times as long and makes larger files."""
_TIFF = [cv2.IMWRITE_TIFF_COMPRESSION, 1]
"""No compression."""
_FOLDER_THREADS = min(4, os.cpu_count() or 2)


@dataclass(frozen=True)
class _WrittenImage:
    """An image that is complete on the disk."""

    line: str
    size: int


class FolderWriter(RecordingWriter):
    """Writes an image file per frame, and then its line of `frames.jsonl`.

    Several threads compress PNG, as a core takes much longer than a frame.
    """

    def __init__(self, path: Path, *, tiff: bool = False) -> None:
        self.path = path
        self._was_there = path.exists()
        path.mkdir(parents=True, exist_ok=True)
        self._suffix = ".tiff" if tiff else ".png"
        self._parameters = _TIFF if tiff else _PNG
        self._notes: TextIO = (path / NOTES_NAME).open("x", encoding="utf-8", buffering=1)
        self._count = 0
        self._noted = 0
        self._size = 0
        self._work = OrderedWork("image files", _FOLDER_THREADS, 0 if tiff else _FOLDER_THREADS, self._note)

    @override
    def write(self, frame: Frame) -> None:
        """Add a frame; formats that no image file can have (YUV, unknown ones) are saved as bytes."""
        self._work.add(partial(self._save, self._count, frame))
        self._count += 1

    @override
    def close(self) -> None:
        try:
            self._work.finish()
        finally:
            self._notes.close()

    @override
    def kept(self, given: int) -> int:
        return self._noted

    @override
    def discard(self) -> None:
        (self.path / NOTES_NAME).unlink(missing_ok=True)
        if not self._was_there:
            self.path.rmdir()

    @override
    def size(self) -> int:
        """Return the bytes written; images in progress are estimated by the average of those before."""
        return self._size + (self._size * self._work.held // self._noted if self._noted else 0)

    def _note(self, written: _WrittenImage) -> None:
        self._notes.write(written.line)
        self._noted += 1
        self._size += written.size + len(written.line)

    # -- the threads -----------------------------------------------------------------------------
    def _save(self, number: int, frame: Frame) -> _WrittenImage:
        suffix, content, pixel_format = self._encoded(frame)
        file = self.path / f"{number:08d}{suffix}"
        try:
            file.write_bytes(content)
        except OSError:
            file.unlink(missing_ok=True)  # an incomplete image
            raise
        return _WrittenImage(note_of(frame, pixel_format, file.name).line(), len(content))

    def _encoded(self, frame: Frame) -> tuple[str, memoryview, PixelFormat]:
        if not frame.pixel_format.convertible:
            return ".raw", frame.payload.data, frame.pixel_format
        if pfnc.unpacked(frame.pixel_format) is None and not (frame.padding_x or frame.big_endian):
            size = frame.pixel_format.image_bytes(frame.width, frame.height)
            return ".raw", np.ascontiguousarray(frame.payload[:size]).data, frame.pixel_format
        pixels, pixel_format = unpacked(frame)
        is_image = pixel_format.family not in (Family.YUV, Family.BICOLOR, Family.COORDINATES)
        if not is_image or pixels.dtype not in (np.uint8, np.uint16):
            return ".raw", np.ascontiguousarray(pixels).data, pixel_format
        if pixel_format.family is Family.RGB:
            pixels = pixels[..., file_channels(pixel_format)]
        done, content = cv2.imencode(self._suffix, pixels, self._parameters)
        if not done:
            raise RecordingError(f"an image of shape {pixels.shape} could not be encoded as {self._suffix}")
        return self._suffix, content.data, pixel_format
