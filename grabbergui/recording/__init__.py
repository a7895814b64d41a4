"""Recordings: writing frames to files, and playing files back as a source (`file:`).

A recording has frames with times, and a note with the metadata of each. Pixels are kept as `Frame.raw` gives
them: packed formats in words of 16 bits, a Bayer pattern as it is, so that playback shows what the sensor
saw. A note is one line of JSON.
"""

from __future__ import annotations

import json
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, fields
from enum import Enum
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from grabbergui.core import pfnc
from grabbergui.core.errors import GrabberError, MissingFileError, UsageError
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import Family, PixelFormat
from grabbergui.core.scan3d import Scan3d

DEFAULT_RATE = 25.0
"Frames per second where nothing was noted."


# -- kinds of recordings -------------------------------------------------------------------------
class RecordingKind(Enum):
    """The kind of a recording's files."""

    PNG = "png"
    "A folder of PNG: compressed without loss, on several threads."
    TIFF = "tiff"
    "A folder of TIFF: as fast as the disk."
    H264 = "h264"
    "A movie that every player opens: 8 bits, with losses."
    HEVC = "hevc"
    "A movie (H.265): smaller, and slower to write."
    AV1 = "av1"
    "A movie (AV1): the smallest."
    LOSSLESS = "lossless"
    "A movie (H.264 without losses): 8 bits exactly, as fast as a camera of 8.8 MP."
    FFV1 = "ffv1"
    "A movie (FFV1): Mono of up to 16 bits and 8-bit colour exactly; smaller, and slower to write."
    MCAP = "mcap"
    "ROS 2 messages, as they come; opens in Foxglove and `ros2 bag`."

    @property
    def suffix(self) -> str:
        """The ending of its files; empty for a folder."""
        return ".mcap" if self is RecordingKind.MCAP else ".mp4" if self in MOVIE_KINDS else ""


MOVIE_KINDS = (
    RecordingKind.H264,
    RecordingKind.HEVC,
    RecordingKind.AV1,
    RecordingKind.LOSSLESS,
    RecordingKind.FFV1,
)


def kind_of(path: Path, *, movie: RecordingKind = RecordingKind.H264) -> RecordingKind:
    """Return the kind that a path's ending asks for: a movie, MCAP, or a folder of PNG.

    Raises UsageError.
    """
    suffix = path.suffix.lower()
    if suffix == ".mcap":
        return RecordingKind.MCAP
    if suffix == ".mp4":
        return movie
    if suffix in (".mkv", ".avi", ".mov", ".bag", ".db3"):
        raise UsageError(f"{path}: recordings are .mp4, .mcap, or a folder (no ending)")
    return RecordingKind.PNG


# -- errors --------------------------------------------------------------------------------------
class RecordingError(GrabberError):
    """A recording could not be written or read."""


class DiskFullError(RecordingError):
    """A recording ended because its disk is full. The frames written before are kept."""

    def __init__(self, path: Path, free: int) -> None:
        super().__init__(f"the disk of {path} is full ({free >> 20} MiB left)")
        self.path = path
        self.free = free
        "Bytes that are left, too few for another frame and the end of the file."


class SourceClosedError(RecordingError):
    """A recording ended because its source was closed."""

    def __init__(self) -> None:
        super().__init__("the source was closed")


class UnfinishedFileError(RecordingError):
    """The end of a recording could not be written."""

    def __init__(self, path: Path, cause: Exception) -> None:
        super().__init__(f"{path} could not be finished: {cause}")
        self.path = path
        self.cause = cause


# -- what every recording is ---------------------------------------------------------------------
class Recording(ABC):
    """Frames with times, in any order of access. One thread at a time."""

    path: Path
    title: str = ""
    "Display text: the source that was recorded."
    scan: Scan3d | None = None
    "The meaning of its 3D data; None if that was not recorded."
    times_ns: list[int]
    "Of each frame, never falling; only differences matter."

    def __len__(self) -> int:
        return len(self.times_ns)

    @abstractmethod
    def frame(self, index: int, received_ns: int) -> Frame:
        """A frame, as though it had arrived at `received_ns`. Raises RecordingError."""

    @abstractmethod
    def close(self) -> None:
        """Close its files. May be called twice."""

    @property
    def duration(self) -> float:
        """Seconds from the first frame to the last."""
        return (self.times_ns[-1] - self.times_ns[0]) / 1e9 if self.times_ns else 0.0


# -- times ---------------------------------------------------------------------------------------
_CLOCK_SET = 1_000_000_000
"Nanoseconds: a longer way back is a clock that was set."


class Rising:
    """Times of frames, one after the other, on a clock that is never set back."""

    def __init__(self) -> None:
        self._highest = 0
        self._shift = 0

    def next(self, time_ns: int) -> int:
        """Return a time that is no earlier than those before it.

        One a little earlier is held at the highest so far; after a longer way back, which is a clock that was
        set, time goes on from there.
        """
        if time_ns + self._shift < self._highest - _CLOCK_SET:
            self._shift = self._highest - time_ns
        self._highest = max(self._highest, time_ns + self._shift)
        return self._highest


def rising(times: list[int]) -> list[int]:
    """Return the times of frames as `Rising` has them."""
    clock = Rising()
    return [clock.next(time) for time in times]


T = TypeVar("T")


def in_order_of_receipt(items: list[T], time: Callable[[T], int]) -> list[T]:
    """Return items that lie roughly in the order of receipt, sorted by time up to where a clock was set."""
    stretches: list[list[T]] = [[]]
    latest = 0
    for item in items:
        if time(item) < latest - _CLOCK_SET:
            stretches.append([])
            latest = 0
        stretches[-1].append(item)
        latest = max(latest, time(item))
    return [item for stretch in stretches for item in sorted(stretch, key=time)]


# -- opening -------------------------------------------------------------------------------------
VIDEO_SUFFIXES = (".mp4", ".mkv", ".avi", ".mov", ".m4v", ".webm")
"Endings of movies that are played."


def open_recording(path: Path) -> Recording:
    """The recording in a folder or file. Raises MissingFileError, UsageError, RecordingError."""
    try:
        return _opened(path)
    except OSError as error:
        raise RecordingError(f"{path} could not be read: {error.strerror or error}") from error


def _opened(path: Path) -> Recording:
    # On demand: each kind needs another library.
    if not path.exists():
        raise MissingFileError(f"there is no recording {path}; write file: and a folder, a movie or an .mcap")
    if path.is_dir():
        from grabbergui.recording.folder import FolderRecording

        return FolderRecording(path)
    if path.suffix.lower() == ".mcap":
        from grabbergui.recording.mcap_file import McapRecording

        return McapRecording(path)
    if path.suffix.lower() in VIDEO_SUFFIXES:
        from grabbergui.recording.movie_file import MovieRecording

        return MovieRecording(path)
    raise UsageError(
        f"{path} is no recording; there are folders of images, .mcap and {', '.join(VIDEO_SUFFIXES)}"
    )


# -- notes, and frames made of them --------------------------------------------------------------
MAX_LINE = 4096
"Characters of one note."
MAX_SIDE = 65536
"Pixels; more is no image."


@dataclass(frozen=True, kw_only=True)
class FrameNote:
    """The metadata of a recorded frame."""

    file: str = ""
    "Its file in the recording's folder; empty where pixels are elsewhere."
    width: int
    height: int
    pixel_format: str
    "PFNC name of the pixels as they are kept."
    frame_id: int = 0
    timestamp_ns: int = 0
    "Device clock."
    received_ns: int = 0
    "Host clock, since the epoch."
    offset_x: int = 0
    offset_y: int = 0

    def line(self) -> str:
        """One line of JSON, its end included."""
        return json.dumps(asdict(self), separators=(",", ":")) + "\n"


def note_of(frame: Frame, pixel_format: PixelFormat, file: str = "") -> FrameNote:
    """The note of a frame that is kept in a pixel format."""
    return FrameNote(
        file=file,
        width=frame.width,
        height=frame.height,
        pixel_format=pixel_format.name,
        frame_id=frame.frame_id,
        timestamp_ns=frame.timestamp_ns,
        received_ns=frame.received_ns,
        offset_x=frame.offset_x,
        offset_y=frame.offset_y,
    )


def unpacked(frame: Frame) -> tuple[NDArray[Any], PixelFormat]:
    """Return the pixels to keep and the unpacked format they are in. Raises PixelFormatError.

    They are `Frame.raw`'s wherever the convention has a format for them, and else what is displayed, in
    Mono8 or RGB8.
    """
    if not frame.pixel_format.convertible:
        frame.raw()
    pixel_format = pfnc.unpacked(frame.pixel_format)
    if pixel_format is not None:
        return frame.raw(), pixel_format
    if frame.pixel_format.family in (Family.MONO, Family.COORDINATES):
        return frame.mono(), pfnc.by_name("Mono8")
    return frame.rgb(), pfnc.by_name("RGB8")


def format_named(name: str) -> PixelFormat:
    """The format of a note: PFNC's name, or the code of one without a name. Raises RecordingError."""
    if re.fullmatch(r"0x[0-9A-F]{8}", name, re.ASCII):
        return pfnc.by_code(int(name, 16))
    try:
        return pfnc.by_name(name)
    except KeyError:
        raise RecordingError(f"a recorded frame is of unknown pixel format '{name[:40]}'") from None


def rebuilt(pixels: NDArray[Any], note: FrameNote, received_ns: int) -> Frame:
    """A frame of kept pixels. Raises RecordingError where they are not what the note says."""
    pixel_format = format_named(note.pixel_format)
    pixels = pixels.astype(pixels.dtype.newbyteorder("<"), copy=False)
    payload = np.ascontiguousarray(pixels).reshape(-1).view(np.uint8)
    if payload.nbytes < pixel_format.image_bytes(note.width, note.height):
        raise RecordingError(
            f"a recorded frame of {note.width}×{note.height} {pixel_format} has {payload.nbytes} bytes only"
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
    )


def read_notes(path: Path) -> Iterator[FrameNote]:
    """The notes of a file, one a line; a last line cut short by a crash is left out. Raises UsageError."""
    try:
        with path.open(encoding="utf-8") as file:
            number = 0
            while line := file.readline(MAX_LINE + 1):
                number += 1
                if not line.endswith("\n"):
                    if len(line) > MAX_LINE:
                        raise UsageError(f"{path}, line {number}: longer than {MAX_LINE} characters")
                    return
                yield _note(line, f"{path}, line {number}")
    except UnicodeDecodeError:
        raise UsageError(f"{path} is not text; it should hold a line of JSON for each frame") from None
    except OSError as error:
        raise RecordingError(f"{path} could not be read: {error.strerror or error}") from error


def _note(line: str, where: str) -> FrameNote:
    try:
        values = json.loads(line)
        known = {field.name: values[field.name] for field in fields(FrameNote) if field.name in values}
        note = FrameNote(**known)
    except (ValueError, TypeError, KeyError, RecursionError):
        raise UsageError(f"{where}: '{line[:60].strip()}' is not the note of a frame") from None
    texts = (note.file, note.pixel_format)
    numbers = [getattr(note, f.name) for f in fields(FrameNote) if f.name not in ("file", "pixel_format")]
    if not all(isinstance(text, str) for text in texts) or not all(type(number) is int for number in numbers):
        raise UsageError(f"{where}: a number or a text of the frame's note is of the wrong kind")
    if not (0 < note.width <= MAX_SIDE and 0 < note.height <= MAX_SIDE) or min(numbers) < 0:
        raise UsageError(f"{where}: a frame of {note.width}×{note.height} pixels is impossible")
    if max(numbers) >= 2**64:
        raise UsageError(f"{where}: a number has more than 64 bits")
    return note
