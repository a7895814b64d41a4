"""Recordings: writing frames to files, and playing files back as a source (`file:`).

A recording has frames with times, and a note with the metadata of each. Pixels are stored as in `Frame.raw`:
packed formats in 16-bit words, a Bayer pattern unconverted, so that playback delivers the sensor's values. A
note is a line of JSON.
"""

from __future__ import annotations

import io
import json
import math
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import dataclass, field, fields, replace
from enum import Enum
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from grabbergui.core import pfnc, vendor_formats
from grabbergui.core.calibration import Scan3d
from grabbergui.core.component import PayloadType
from grabbergui.core.errors import GrabberError, MissingFileError, UsageError
from grabbergui.core.frame import Frame, FrameStatus
from grabbergui.core.json_text import to_json
from grabbergui.core.pfnc import PixelFormat
from grabbergui.core.regular_files import open_regular

DEFAULT_RATE = 25.0
"Frames per second of a recording without times."


# -- kinds of recordings -------------------------------------------------------------------------
class RecordingKind(Enum):
    """The kind of files of a recording."""

    PNG = "png"
    "A folder of PNG: lossless compression, on several threads."
    TIFF = "tiff"
    "A folder of TIFF: as fast as the disk."
    H264 = "h264"
    "A movie that every player opens: 8 bits, lossy."
    HEVC = "hevc"
    "A movie (H.265): smaller, and slower to write."
    AV1 = "av1"
    "A movie (AV1): the smallest."
    LOSSLESS = "lossless"
    "A movie (lossless H.264): 8 bits exactly, as fast as a camera of 8.8 MP."
    FFV1 = "ffv1"
    "A movie (FFV1): Mono of up to 16 bits and 8-bit colour exactly; smaller, and slower to write."
    STACK = "stack"
    "One TIFF with a page for each frame, uncompressed; up to 4 GiB."
    NUMPY = "npy"
    "One NumPy array of all frames."
    MCAP = "mcap"
    "Uncompressed ROS 2 messages, for Foxglove and `ros2 bag`."

    @property
    def suffix(self) -> str:
        """The suffix of its files; empty for a folder."""
        return _SUFFIXES.get(self, ".mp4" if self in MOVIE_KINDS else "")


_SUFFIXES = {RecordingKind.MCAP: ".mcap", RecordingKind.STACK: ".tiff", RecordingKind.NUMPY: ".npy"}
MOVIE_KINDS = (
    RecordingKind.H264,
    RecordingKind.HEVC,
    RecordingKind.AV1,
    RecordingKind.LOSSLESS,
    RecordingKind.FFV1,
)


CODECS = {
    kind.value: kind
    for kind in (RecordingKind.H264, RecordingKind.HEVC, RecordingKind.AV1, RecordingKind.FFV1)
}
"""Codecs of a movie by their names; lossless H.264 has none of its own."""


_BY_SUFFIX = {
    ".mcap": RecordingKind.MCAP,
    ".tif": RecordingKind.STACK,
    ".tiff": RecordingKind.STACK,
    ".npy": RecordingKind.NUMPY,
}
_NOT_WRITTEN = frozenset(
    [
        ".mkv",
        ".avi",
        ".mov",
        ".webm",
        ".bag",
        ".db3",
        ".npz",
        ".png",
        ".jpg",
        ".jpeg",
        ".bmp",
        ".gif",
        ".raw",
        ".h5",
        ".hdf5",
    ]
)
"Endings of files that are not written, and that a folder would be mistaken for."


def kind_of(
    path: Path, *, codec: str | None = None, lossless: bool = False, tiff: bool = False
) -> RecordingKind:
    """Return the kind for a path's suffix: a movie, MCAP, one TIFF or NumPy array, or a folder of PNG.

    `codec` is one of CODECS, h264 by default; `codec` and `lossless` are for a movie, `tiff` for a folder.
    Raises UsageError.
    """
    suffix = path.suffix.lower()
    if suffix in _NOT_WRITTEN:
        raise UsageError(f"{path}: recordings are .mp4, .mcap, .tiff, .npy, or a folder (no ending)")
    if tiff and suffix in (".mp4", ".mcap", ".npy"):
        raise UsageError(f"tiff is for a folder of images, not for {path.name}")
    if suffix == ".mp4":
        return _movie_kind(codec or RecordingKind.H264.value, lossless=lossless)
    if codec is not None or lossless:
        raise UsageError(f"codec and lossless are for a movie (.mp4), not for {path.name}")
    if suffix in _BY_SUFFIX:
        return _BY_SUFFIX[suffix]
    return RecordingKind.TIFF if tiff else RecordingKind.PNG


def _movie_kind(codec: str, *, lossless: bool) -> RecordingKind:
    if codec not in CODECS:
        raise UsageError(f"'{codec}' is no codec of a movie; there are {', '.join(CODECS)}")
    kind = CODECS[codec]
    if not lossless or kind is RecordingKind.FFV1:
        return kind
    if kind is not RecordingKind.H264:
        raise UsageError(f"{codec} is not lossless here; h264 and ffv1 are")
    return RecordingKind.LOSSLESS


# -- errors --------------------------------------------------------------------------------------
class RecordingError(GrabberError):
    """A recording could not be written or read."""


# -- the interface of recordings -----------------------------------------------------------------
class Recording(ABC):
    """Frames with times, with random access. One thread at a time."""

    path: Path
    title: str = ""
    "The recorded source, as display text."
    scan: Scan3d | None = None
    "The meaning of its 3D data; None if that was not recorded."
    remark: str = ""
    "What a user should know about it, such as further topics; empty if there is nothing."
    times_ns: list[int]
    "The time of each frame, never decreasing; only differences are meaningful."

    def __len__(self) -> int:
        return len(self.times_ns)

    @abstractmethod
    def frame(self, index: int, received_ns: int) -> Frame:
        """Return a frame with the time of receipt `received_ns`. Raises RecordingError."""

    @abstractmethod
    def close(self) -> None:
        """Close its files. May be called twice."""

    @property
    def duration(self) -> float:
        """Seconds from the first frame to the last."""
        return (self.times_ns[-1] - self.times_ns[0]) / 1e9 if self.times_ns else 0.0


# -- times ---------------------------------------------------------------------------------------
_CLOCK_SET = 1_000_000_000
"Nanoseconds. If the time decreases by more, the clock was set back."


class Rising:
    """Converts the times of successive frames to a clock that is never set back."""

    def __init__(self) -> None:
        self._highest = 0
        self._shift = 0

    def next(self, time_ns: int) -> int:
        """Return a time that is not earlier than those before it.

        A slightly earlier time becomes the highest so far; if the clock was set back, time continues there.
        """
        if time_ns + self._shift < self._highest - _CLOCK_SET:
            self._shift = self._highest - time_ns
        self._highest = max(self._highest, time_ns + self._shift)
        return self._highest


def rising(times: list[int]) -> list[int]:
    """Return the times of frames as converted by `Rising`."""
    clock = Rising()
    return [clock.next(time) for time in times]


T = TypeVar("T")


def in_order_of_receipt(items: list[T], time: Callable[[T], int]) -> list[T]:
    """Sort items that are roughly in order by time, but not across a point where the clock was set back."""
    sections: list[list[T]] = [[]]
    latest = 0
    for item in items:
        if time(item) < latest - _CLOCK_SET:
            sections.append([])
            latest = 0
        sections[-1].append(item)
        latest = max(latest, time(item))
    return [item for section in sections for item in sorted(section, key=time)]


def natural(path: Path) -> list[tuple[int, int, str]]:
    """Return a key that sorts names as people count: `frame_2.png` before `frame_10.png`."""
    parts = re.split(r"([0-9]{1,18})", path.name)
    return [(0, int(part), "") if part.isascii() and part.isdigit() else (1, 0, part) for part in parts]


def notes_beside(path: Path) -> Path:
    """Return the file with the notes of a file: `movie.frames.jsonl` beside `movie.mp4`."""
    return path.with_name(path.stem + ".frames.jsonl")


# -- opening -------------------------------------------------------------------------------------
VIDEO_SUFFIXES = (".mp4", ".mkv", ".avi", ".mov", ".m4v", ".webm")
"Suffixes of movies that are played."


def open_recording(path: Path, *, topic: str = "") -> Recording:
    """Open the recording in a folder or file. Raises MissingFileError, UsageError, RecordingError.

    `topic` chooses the images in a ROS recording; `all` are played at once, as components of a frame.
    """
    try:
        return _opened(path, topic)
    except OSError as error:
        raise RecordingError(f"{path} could not be read: {error.strerror or error}") from error


def _opened(path: Path, topic: str) -> Recording:
    # Imported on demand, as each kind needs another library.
    if not path.exists():
        raise MissingFileError(f"there is no recording {path}; write file: and a folder, a movie or an .mcap")
    from grabbergui.recording import bag_folder

    files = bag_folder.bag_files(path) if path.is_dir() else [path]
    if files and files[0].suffix.lower() in (".mcap", ".db3"):
        from grabbergui.recording.ros_recording import RosRecording

        return RosRecording(path, bag_folder.opened(files), topic)
    if topic:
        raise UsageError(f"{path} has no topics; topic= is for .mcap, .db3 and folders of rosbag2")
    if path.suffix.lower() == ".npy":
        from grabbergui.recording.npy_file import NpyRecording

        return NpyRecording(path)
    if path.is_dir() or path.suffix.lower() in (".tif", ".tiff"):
        from grabbergui.recording.folder import FolderRecording

        return FolderRecording(path)
    if path.suffix.lower() in VIDEO_SUFFIXES:
        from grabbergui.recording.movie_file import MovieRecording

        return MovieRecording(path)
    raise UsageError(
        f"{path} is no recording; there are folders of images, .mcap, .db3, .tiff, .npy "
        f"and {', '.join(VIDEO_SUFFIXES)}"
    )


def playable_frames(path: Path) -> int:
    """Return how many frames of a recording that ended early can be played, up to the last readable one."""
    try:
        with closing(open_recording(path)) as recording:
            for index in reversed(range(len(recording))):
                try:
                    recording.frame(index, 0)
                except GrabberError:
                    continue
                return index + 1
    except GrabberError:
        pass
    return 0


# -- notes, and frames built from them -----------------------------------------------------------
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
