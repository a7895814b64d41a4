"""Frames into files: a folder of pictures, a movie, an MCAP file. One thread at a time calls a writer.

Each writer notes the time of every frame, and can be closed at any moment with what was written so far
readable. `driver.playback` reads them all.
"""

from __future__ import annotations

import contextlib
import logging
import os
import shutil
import sys
from abc import ABC, abstractmethod
from dataclasses import dataclass
from enum import Enum
from functools import partial
from io import BufferedWriter
from pathlib import Path
from typing import Any, TextIO

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.core import pfnc
from grabbergui.core.errors import PixelFormatError, UsageError
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import DeviceInfo
from grabbergui.core.pfnc import Family, PixelFormat
from grabbergui.recording import ros_image
from grabbergui.recording.folder import NOTES_NAME, file_channels
from grabbergui.recording.movie import notes_beside
from grabbergui.recording.ordered_work import OrderedWork
from grabbergui.recording.ros_image import RosImage
from grabbergui.recording.stored import RecordingError, note_of, unpacked

MOVIE_RATE = 25.0
"Frames per second that a movie's own clock gets where the camera's rate is not known; notes have the times."
INDEX_BYTES = 8 << 20
"Enough for the index of 400,000 frames."
log = logging.getLogger(__name__)


class RecordingKind(Enum):
    """What a recording is made of."""

    PNG = "png"
    "A folder of PNG: compressed without loss, on several threads."
    TIFF = "tiff"
    "A folder of TIFF: as fast as the disk."
    MP4 = "mp4"
    "A movie (MPEG-4 part 2), 8 bits, with losses."
    LOSSLESS = "lossless"
    "A movie (FFV1) in MP4, 8 bits, without losses."
    MCAP = "mcap"
    "ROS 2 messages, as they come; opens in Foxglove and `ros2 bag`."


def kind_of(path: Path, *, lossless: bool = False) -> RecordingKind:
    """The kind that a path's ending asks for: a movie, MCAP, else a folder of PNG. Raises UsageError."""
    suffix = path.suffix.lower()
    if suffix == ".mcap":
        return RecordingKind.MCAP
    if suffix == ".mp4":
        return RecordingKind.LOSSLESS if lossless else RecordingKind.MP4
    if suffix in (".mkv", ".avi", ".mov", ".bag", ".db3"):
        raise UsageError(f"{path}: recordings are .mp4, .mcap, or a folder (no ending)")
    return RecordingKind.PNG


class RecordingWriter(ABC):
    """Where recorded frames go. A writer overwrites nothing."""

    path: Path

    @abstractmethod
    def write(self, frame: Frame) -> None:
        """Add a frame, and wait where earlier ones are not done.

        Raises RecordingError, PixelFormatError, OSError when the disk is full; also for the frames before.
        """

    @abstractmethod
    def close(self) -> None:
        """Finish the files. May be called twice. Raises OSError where even that does not fit."""

    def discard(self) -> None:
        """Take away what it made, closed without a frame: the name is free again. Raises OSError."""
        self.path.unlink(missing_ok=True)

    @abstractmethod
    def size(self) -> int:
        """Bytes written so far."""

    def free(self) -> int:
        """Bytes free where it writes."""
        folder = self.path if self.path.is_dir() else self.path.parent
        return shutil.disk_usage(folder).free


def create_writer(kind: RecordingKind, path: Path, info: DeviceInfo, rate: float = 0.0) -> RecordingWriter:
    """A writer of a kind; `rate` is the camera's frames per second, 0 where unknown.

    Raises RecordingError where the path is taken or cannot be made.
    """
    if path.exists() and not (path.is_dir() and not any(path.iterdir())):
        raise RecordingError(f"{path} is there already; a recording overwrites nothing, choose another name")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        if kind is RecordingKind.MCAP:
            return McapWriter(path, info)
        if kind in (RecordingKind.MP4, RecordingKind.LOSSLESS):
            return MovieWriter(path, rate, lossless=kind is RecordingKind.LOSSLESS)
        return FolderWriter(path, tiff=kind is RecordingKind.TIFF)
    except OSError as error:
        raise RecordingError(f"{path} could not be made: {error.strerror or error}") from error


_PNG = [cv2.IMWRITE_PNG_COMPRESSION, 1, cv2.IMWRITE_PNG_STRATEGY, cv2.IMWRITE_PNG_STRATEGY_HUFFMAN_ONLY]
if hasattr(cv2, "IMWRITE_PNG_FILTER"):  # of OpenCV 4.11
    _PNG += [cv2.IMWRITE_PNG_FILTER, cv2.IMWRITE_PNG_FILTER_UP]
"""Of a noisy sensor's pictures, looking for repetitions makes larger files and takes three times as long."""
_TIFF = [cv2.IMWRITE_TIFF_COMPRESSION, 1]
"""None."""
_FOLDER_THREADS = min(4, os.cpu_count() or 2)


@dataclass(frozen=True)
class _Kept:
    """A picture that is whole on the disk."""

    line: str
    size: int


class FolderWriter(RecordingWriter):
    """A picture a frame, and a line of `frames.jsonl` for each, written once the picture is whole.

    Compressing PNG takes one core much longer than a frame: several threads do it.
    """

    def __init__(self, path: Path, *, tiff: bool = False) -> None:
        self.path = path
        self._was_there = path.exists()
        path.mkdir(parents=True, exist_ok=True)
        self._suffix = ".tiff" if tiff else ".png"
        self._parameters = _TIFF if tiff else _PNG
        self._notes: TextIO = (path / NOTES_NAME).open("x", encoding="utf-8", buffering=1)
        self._count = 0
        self._size = 0
        self._work = OrderedWork("picture files", _FOLDER_THREADS, 0 if tiff else _FOLDER_THREADS, self._note)

    def write(self, frame: Frame) -> None:
        """See RecordingWriter. What no picture file holds (YUV, unknown formats) is kept as its bytes."""
        self._work.add(partial(self._keep, self._count, frame))
        self._count += 1

    def close(self) -> None:
        """See RecordingWriter."""
        try:
            self._work.finish()
        finally:
            self._notes.close()

    def discard(self) -> None:
        """See RecordingWriter."""
        (self.path / NOTES_NAME).unlink(missing_ok=True)
        if not self._was_there:
            self.path.rmdir()

    def size(self) -> int:
        """See RecordingWriter. Pictures that are being compressed count as much as those before."""
        noted = self._count - self._work.held
        return self._size + (self._size * self._work.held // noted if noted else 0)

    def _note(self, kept: _Kept) -> None:
        self._notes.write(kept.line)
        self._size += kept.size + len(kept.line)

    # -- a thread of its own -----------------------------------------------------------------------
    def _keep(self, number: int, frame: Frame) -> _Kept:
        suffix, content, pixel_format = self._encoded(frame)
        file = self.path / f"{number:08d}{suffix}"
        try:
            file.write_bytes(content)
        except OSError:
            file.unlink(missing_ok=True)  # half a picture is none
            raise
        return _Kept(note_of(frame, pixel_format, file.name).line(), len(content))

    def _encoded(self, frame: Frame) -> tuple[str, memoryview, PixelFormat]:
        if not frame.pixel_format.convertible:
            return ".raw", frame.payload.data, frame.pixel_format
        pixels, pixel_format = unpacked(frame)
        if pixel_format.family is Family.YUV:
            return ".raw", np.ascontiguousarray(pixels).data, pixel_format
        if pixel_format.family is Family.RGB:
            pixels = pixels[..., file_channels(pixel_format.name)]
        done, content = cv2.imencode(self._suffix, pixels, self._parameters)
        if not done:
            raise RecordingError(f"a picture of shape {pixels.shape} could not be encoded as {self._suffix}")
        return self._suffix, content.data, pixel_format


class DiskReserve:
    """Room for a movie's index, which is written last and without which nothing can be read.

    Other programs may fill the disk meanwhile. The file has no name, so it ends with this program.
    """

    def __init__(self, folder: Path, size: int = INDEX_BYTES) -> None:
        self._file = -1
        try:
            if sys.platform != "linux":
                raise OSError("only Linux has files without a name")
            self._file = os.open(folder, os.O_TMPFILE | os.O_RDWR)
            os.posix_fallocate(self._file, 0, size)
        except OSError as error:  # a file system or a system that has none
            log.info("nothing is reserved in %s for the end of a movie: %s", folder, error)

    def release(self) -> None:
        """Give the room back to the disk. May be called twice."""
        if self._file >= 0:
            os.close(self._file)
            self._file = -1


class MovieWriter(RecordingWriter):
    """A movie of 8-bit pictures by OpenCV, and the times of its frames beside it.

    One thread encodes while the caller's makes the next picture.
    """

    def __init__(self, path: Path, rate: float, *, lossless: bool) -> None:
        self.path = path
        self._rate = rate if rate > 0 else MOVIE_RATE
        self._code = cv2.VideoWriter.fourcc(*("FFV1" if lossless else "mp4v"))
        self._notes: TextIO = notes_beside(path).open("x", encoding="utf-8", buffering=1)
        self._movie: cv2.VideoWriter | None = None
        self._shape: tuple[int, int, bool] | None = None
        self._reserve = DiskReserve(path.parent)
        self._work = OrderedWork(f"encode {path.name}", 1, 2, self._notes.write)

    def write(self, frame: Frame) -> None:
        """See RecordingWriter."""
        mono = frame.pixel_format.family is Family.MONO
        pixels = frame.mono() if mono else cv2.cvtColor(frame.rgb(), cv2.COLOR_RGB2BGR)
        shape = (frame.width, frame.height, mono)
        if self._movie is None:
            self._movie, self._shape = self._begun(shape), shape
        if shape != self._shape:
            raise RecordingError(
                f"{self.path}: the picture's size or kind changed; a movie cannot follow, .mcap can"
            )
        line = note_of(frame, pfnc.by_name("Mono8" if mono else "BGR8")).line()
        self._work.add(partial(_encode, self._movie, pixels, line))

    def close(self) -> None:
        """See RecordingWriter."""
        try:
            self._work.finish()
        finally:
            movie, self._movie = self._movie, None
            self._reserve.release()
            if movie is not None:
                movie.release()
            self._notes.close()

    def discard(self) -> None:
        """See RecordingWriter."""
        notes_beside(self.path).unlink(missing_ok=True)
        super().discard()

    def size(self) -> int:
        """See RecordingWriter."""
        return self.path.stat().st_size if self.path.exists() else 0

    def _begun(self, shape: tuple[int, int, bool]) -> cv2.VideoWriter:
        width, height, mono = shape
        colour = [cv2.VIDEOWRITER_PROP_IS_COLOR, int(not mono)]
        movie = cv2.VideoWriter(
            str(self.path), cv2.CAP_FFMPEG, self._code, self._rate, (width, height), colour
        )
        if not movie.isOpened():
            raise RecordingError(
                f"{self.path}: OpenCV cannot begin a movie of {width}×{height} here; try .mcap"
            )
        return movie


def _encode(movie: cv2.VideoWriter, pixels: NDArray[Any], line: str) -> str:
    """Add a picture to a movie; its note, for when that is done."""
    movie.write(np.ascontiguousarray(pixels))
    return line


class McapWriter(RecordingWriter):
    """`sensor_msgs/msg/Image`, a chunk a frame, not compressed; the camera's clock on a topic beside."""

    TOPIC = "/grabbergui/image_raw"
    FRAME_ID = "camera"

    def __init__(self, path: Path, info: DeviceInfo) -> None:
        # On demand: only this kind of recording needs the package.
        try:
            from mcap.writer import CompressionType, Writer
        except ImportError as error:
            raise RecordingError(f"recording .mcap needs the package mcap: {error}") from error
        self.path = path
        self._source = info.title
        self._file: BufferedWriter = path.open("xb")
        # A chunk ends behind each image: what is on the disk is readable, and nothing is copied twice.
        self._writer = Writer(self._file, chunk_size=1, compression=CompressionType.NONE)
        self._writer.start(profile="ros2", library="grabbergui")
        self._writer.add_metadata("grabbergui", info.as_dict())
        self._image_schema = self._schema(ros_image.IMAGE_NAME, ros_image.IMAGE_DEFINITION)
        self._time_schema = self._schema(ros_image.TIME_NAME, ros_image.TIME_DEFINITION)
        self._channels: dict[str, int] = {}
        self._clock: int | None = None
        self._broken = False

    def write(self, frame: Frame) -> None:
        """See RecordingWriter."""
        pixels, pixel_format = unpacked(frame)
        encoding = ros_image.encoding_of(pixel_format)
        if encoding is None:
            raise PixelFormatError(f"ROS has no encoding for {pixel_format}; record a folder instead")
        pixels = np.ascontiguousarray(pixels)
        step = pixels.nbytes // frame.height
        image = RosImage(
            frame.received_ns,
            self.FRAME_ID,
            frame.height,
            frame.width,
            encoding,
            0,
            step,
            pixels.data.cast("B"),
        )
        whole = self._file.tell()
        try:
            if frame.timestamp_ns:
                self._add(self._clock_channel(), frame, self._time_of(frame))
            self._add(self._image_channel(pixel_format), frame, image.encode())
            self._writer.flush()  # type: ignore[no-untyped-call]
        except OSError:
            self._abandon(whole)
            raise

    def close(self) -> None:
        """See RecordingWriter. After a failed write the summary is left out; readers do without."""
        if self._file.closed:
            return
        try:
            if not self._broken:
                self._writer.finish()  # type: ignore[no-untyped-call]
        finally:
            self._file.close()

    def size(self) -> int:
        """See RecordingWriter."""
        return self._file.tell() if not self._file.closed else self.path.stat().st_size

    def _add(self, channel: int, frame: Frame, message: bytes) -> None:
        sequence = frame.frame_id & 0xFFFF_FFFF
        self._writer.add_message(channel, frame.received_ns, message, frame.received_ns, sequence)

    def _time_of(self, frame: Frame) -> bytes:
        return ros_image.encode_time_reference(
            frame.received_ns, self.FRAME_ID, frame.timestamp_ns, self._source
        )

    def _schema(self, name: str, definition: str) -> int:
        return int(self._writer.register_schema(name, "ros2msg", definition.encode()))

    def _image_channel(self, pixel_format: PixelFormat) -> int:
        if pixel_format.name not in self._channels:
            metadata = {"offered_qos_profiles": "", "pixel_format": pixel_format.name}
            channel = self._writer.register_channel(self.TOPIC, "cdr", self._image_schema, metadata)
            self._channels[pixel_format.name] = int(channel)
        return self._channels[pixel_format.name]

    def _clock_channel(self) -> int:
        if self._clock is None:
            metadata = {"offered_qos_profiles": ""}
            topic = f"{self.TOPIC}/device_time"
            self._clock = int(self._writer.register_channel(topic, "cdr", self._time_schema, metadata))
        return self._clock

    def _abandon(self, size: int) -> None:
        """Take away the half of a frame that did not fit any more."""
        self._broken = True
        with contextlib.suppress(OSError):
            self._file.close()  # tries to write what is left once more
        os.truncate(self.path, size)
