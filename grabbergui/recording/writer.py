"""Frames into files: what every writer is, which there are, and work shared by several threads.

One thread at a time calls a writer. Each writer notes the time of every frame, and can be closed at any
moment with what was written so far readable.
"""

from __future__ import annotations

import shutil
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from enum import Enum
from pathlib import Path
from typing import Generic, TypeVar

from grabbergui.core.errors import UsageError
from grabbergui.core.frame import Frame
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.scan3d import Scan3d
from grabbergui.recording.recording import RecordingError

Result = TypeVar("Result")


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


class RecordingWriter(ABC):
    """Where recorded frames go. A writer overwrites nothing."""

    path: Path
    keeps_components = False
    "Whether it writes every component of a frame, and not only the frame's own image."

    @abstractmethod
    def write(self, frame: Frame) -> None:
        """Add a frame, and wait where earlier ones are not done.

        Raises RecordingError, PixelFormatError, OSError when the disk is full; also for the frames before.
        """

    @abstractmethod
    def close(self) -> None:
        """Finish the files. May be called twice. Raises OSError where even that does not fit."""

    def discard(self) -> None:
        """Remove the files of a writer that was closed without a frame. Raises OSError."""
        self.path.unlink(missing_ok=True)

    @abstractmethod
    def size(self) -> int:
        """Bytes written so far."""

    def free(self) -> int:
        """Bytes free where it writes."""
        folder = self.path if self.path.is_dir() else self.path.parent
        return shutil.disk_usage(folder).free


def create_writer(
    kind: RecordingKind, path: Path, info: DeviceInfo, rate: float = 0.0, scan: Scan3d | None = None
) -> RecordingWriter:
    """A writer of a kind; `rate` is the camera's frames per second, 0 where unknown; `scan` of 3D data.

    Raises RecordingError where the path is taken or cannot be made.
    """
    if path.exists() and not (path.is_dir() and not any(path.iterdir())):
        raise RecordingError(f"{path} is there already; a recording overwrites nothing, choose another name")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        # On demand: each kind needs another library.
        if kind is RecordingKind.MCAP:
            from grabbergui.recording.mcap_writer import McapWriter

            return McapWriter(path, info, scan)
        if kind in (RecordingKind.PNG, RecordingKind.TIFF):
            from grabbergui.recording.folder import FolderWriter

            return FolderWriter(path, tiff=kind is RecordingKind.TIFF)
        from grabbergui.recording.movie_writer import MovieWriter

        return MovieWriter(path, kind, rate)
    except ImportError as error:
        raise RecordingError(f"recording {path.name} needs the package {error.name}: {error}") from error
    except OSError as error:
        raise RecordingError(f"{path} could not be made: {error.strerror or error}") from error


class OrderedWork(Generic[Result]):
    """A few pieces of work at a time, for what releases the GIL: compressing, writing.

    Used from one thread; `done` is called on that thread. However slow the work is, no more than `waiting`
    pieces are held when `add` returns: with 0 it returns when the work is done.
    """

    def __init__(self, name: str, threads: int, waiting: int, done: Callable[[Result], object]) -> None:
        self._pool = ThreadPoolExecutor(threads, thread_name_prefix=name)
        self._waiting = waiting
        self._done = done
        self._begun: deque[Future[Result]] = deque()

    @property
    def held(self) -> int:
        """Pieces that were given and whose results were not taken up yet."""
        return len(self._begun)

    def add(self, work: Callable[[], Result]) -> None:
        """Give a piece of work; waits while too many are held. Raises what it or an earlier piece raised."""
        self._begun.append(self._pool.submit(work))
        while self._begun and (self._begun[0].done() or len(self._begun) > self._waiting):
            self._done(self._begun.popleft().result())

    def finish(self) -> None:
        """Wait for all and end the threads; then raises the first error there was. May be called twice."""
        failure: BaseException | None = None
        while self._begun:
            try:
                self._done(self._begun.popleft().result())
            except Exception as error:
                failure = failure or error
        self._pool.shutdown()
        if failure is not None:
            raise failure
