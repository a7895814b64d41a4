"""Folders of image files, with or without a recorder's notes."""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, TextIO

import cv2
import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from grabbergui.core import encoded_image, pfnc
from grabbergui.core.errors import RemoteProtocolError, UsageError
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import Family, PixelFormat
from grabbergui.core.regular_files import read_bounded
from grabbergui.core.ros_pictures import of_file
from grabbergui.recording import tiff_pages, yarp_dump
from grabbergui.recording.errors import RecordingError
from grabbergui.recording.file_names import natural, notes_beside
from grabbergui.recording.notes import FrameNote, read_notes
from grabbergui.recording.ordered_work import OrderedWork
from grabbergui.recording.reader import RecordingReader
from grabbergui.recording.stored_frames import format_named, note_of, rebuilt, unpacked
from grabbergui.recording.times import DEFAULT_RATE, rising
from grabbergui.recording.writer import RecordingWriter

NOTES_NAME = "frames.jsonl"
IMAGE_SUFFIXES = (".png", *tiff_pages.SUFFIXES, ".jpg", ".jpeg", ".bmp", ".ppm", ".pgm")
MAX_FILE_BYTES = 1 << 30
_PNG = [cv2.IMWRITE_PNG_COMPRESSION, 1, cv2.IMWRITE_PNG_STRATEGY, cv2.IMWRITE_PNG_STRATEGY_HUFFMAN_ONLY]
_TIFF = [cv2.IMWRITE_TIFF_COMPRESSION, 1]
"""No compression."""
_FOLDER_THREADS = min(4, os.cpu_count() or 2)


@dataclass(frozen=True)
class _RecordedImage:
    """A frame: a file or one of its pages, and what is known about it."""

    file: Path
    page: tiff_pages.Page | None = None
    note: FrameNote | None = None
    number: int = 0
    "Its frame id, without a note."


class FolderRecording(RecordingReader):
    """Images in the order of the notes, of yarpdatadumper's log, or of their names."""

    def __init__(self, path: Path) -> None:
        """Open a folder, or a single file of several pages. Raises UsageError, RecordingError, OSError."""
        self.path = path
        self.title = path.name
        notes_file = path / NOTES_NAME if path.is_dir() else notes_beside(path)
        if notes_file.is_file() and not path.is_dir():
            self._entries = self._noted_pages(list(read_notes(notes_file)))
            self.times_ns = rising([each.note.received_ns for each in self._entries if each.note is not None])
        elif notes_file.is_file():
            notes = list(read_notes(notes_file))
            self._entries = [_RecordedImage(self._inside(note.file), note=note) for note in notes]
            self.times_ns = rising([note.received_ns for note in notes])
        elif dumped := yarp_dump.read_log(path) if path.is_dir() else []:
            self._entries = [_RecordedImage(path / each.file, number=each.number) for each in dumped]
            self.times_ns = rising([each.time_ns for each in dumped])
        else:
            self._entries = self._listed()
            self.times_ns = [round(index * 1e9 / DEFAULT_RATE) for index in range(len(self._entries))]
        if not self._entries:
            raise UsageError(
                f"{path} holds no images; a recording has {NOTES_NAME} or {', '.join(IMAGE_SUFFIXES)}"
            )

    def _noted_pages(self, notes: list[FrameNote]) -> list[_RecordedImage]:
        """Return the pages of a stack that was recorded; after a crash there may be more or fewer notes."""
        pages = tiff_pages.pages_of(self.path)
        return [_RecordedImage(self.path, page, note) for page, note in zip(pages, notes, strict=False)]

    def _listed(self) -> list[_RecordedImage]:
        """Return the images by their names, in natural order, without the hidden files of other systems."""
        files = [self.path]
        if self.path.is_dir():
            names = [path for path in self.path.iterdir() if not path.name.startswith(".")]
            files = sorted((p for p in names if p.suffix.lower() in IMAGE_SUFFIXES), key=natural)
        found: list[_RecordedImage] = []
        for file in files:
            pages = self._pages_of(file) if file.suffix.lower() in tiff_pages.SUFFIXES else []
            found += [_RecordedImage(file, page, number=len(found) + page.number) for page in pages]
            if not pages:
                found.append(_RecordedImage(file, number=len(found)))
        return found

    def _pages_of(self, file: Path) -> list[tiff_pages.Page]:
        """Return the pages of a file; none if it has one, or cannot be read, which its frame then reports."""
        try:
            pages = tiff_pages.pages_of(file)
        except (UsageError, OSError):
            return []
        huge = any(page.width * page.height > encoded_image.MOST_PIXELS for page in pages)  # is refused
        return pages if len(pages) > 1 or huge or file == self.path else []

    @override
    def frame(self, index: int, received_ns: int) -> Frame:
        entry = self._entries[index]
        file, note = entry.file, entry.note
        try:
            if note is not None and file.suffix == ".raw":
                content = np.frombuffer(read_bounded(file, MAX_FILE_BYTES, "image"), np.uint8)
                return rebuilt(content, note, received_ns)
            pixels = _pixels_of(entry)
        except OSError as error:
            raise RecordingError(f"{file} could not be read: {error.strerror or error}") from error
        except UsageError as error:
            raise RecordingError(str(error)) from error
        except RemoteProtocolError as error:
            raise RecordingError(f"{file}: {error}") from None
        if note is None:
            note = _foreign(pixels, entry.number, file)
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


def _pixels_of(entry: _RecordedImage) -> NDArray[Any]:
    """Return the pixels of a file in OpenCV's layout. Raises RemoteProtocolError, UsageError, OSError."""
    if entry.page is not None:
        return tiff_pages.read_page(entry.file, entry.page)
    content = read_bounded(entry.file, MAX_FILE_BYTES, "image")
    suffix = entry.file.suffix.lower()
    if suffix in yarp_dump.FLOAT_SUFFIXES:
        return yarp_dump.read_float(content, compressed=suffix == ".floatzip")
    return encoded_image.decode(np.frombuffer(content, np.uint8))


def _foreign(pixels: NDArray[Any], number: int, file: Path) -> FrameNote:
    """Return the note of an image without one. Raises RecordingError for values that cannot be shown."""
    name = of_file(pixels)
    if not name:
        components = pixels.shape[2] if pixels.ndim == 3 else 1
        raise RecordingError(
            f"{file} has {components} components of {pixels.dtype} and cannot be played; "
            "images of 1, 3 or 4 components of uint8 or uint16 can, and of one component of other types"
        )
    height, width = pixels.shape[:2]
    return FrameNote(width=width, height=height, pixel_format=name, frame_id=number)


_PNG += [cv2.IMWRITE_PNG_FILTER, cv2.IMWRITE_PNG_FILTER_UP]
"""For images of a noisy sensor, searching repetitions takes three times as long and makes larger files."""


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
