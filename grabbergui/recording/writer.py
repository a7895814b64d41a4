"""Common to writers of recordings: their interface, notes and pixels to store, work on several threads."""

from __future__ import annotations

import shutil
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any, Generic, TypeVar

from numpy.typing import NDArray

from grabbergui.core import pfnc
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import Family, PixelFormat
from grabbergui.recording import FrameNote, is_chunk_value, stored_name


class RecordingWriter(ABC):
    """Writes frames to files. Overwrites no file."""

    path: Path
    keeps_components = False
    "Whether it writes every component of a frame, and not only the frame's own image."

    @abstractmethod
    def write(self, frame: Frame) -> None:
        """Add a frame; wait if too many earlier ones are in progress.

        Raises RecordingError, PixelFormatError, OSError if the disk is full, also for earlier frames.
        """

    @abstractmethod
    def close(self) -> None:
        """Finish the files. May be called twice. Raises OSError if the disk is too full for that."""

    def kept(self, given: int) -> int:
        """Return how many of `given` frames are in the files, once these are closed."""
        return given

    def discard(self) -> None:
        """Remove the files of a writer that was closed without a frame. Raises OSError."""
        self.path.unlink(missing_ok=True)

    @abstractmethod
    def size(self) -> int:
        """Return the bytes written so far."""

    def free(self) -> int:
        """Return the free bytes on its disk."""
        folder = self.path if self.path.is_dir() else self.path.parent
        return shutil.disk_usage(folder).free


# -- frames to store ----------------------------------------------------------------------------
def note_of(frame: Frame, pixel_format: PixelFormat, file: str = "") -> FrameNote:
    """Return the note of a frame that is stored in a pixel format."""
    return FrameNote(
        file=file,
        width=frame.width,
        height=frame.height,
        pixel_format=stored_name(pixel_format),
        frame_id=frame.frame_id,
        timestamp_ns=frame.timestamp_ns,
        received_ns=frame.received_ns,
        offset_x=frame.offset_x,
        offset_y=frame.offset_y,
        complete=frame.complete,
        missing_bytes=frame.missing_bytes,
        chunks={name: value for name, value in frame.chunks.items() if is_chunk_value(value)},
    )


def unpacked(frame: Frame) -> tuple[NDArray[Any], PixelFormat]:
    """Return the pixels to store and their unpacked format. Raises PixelFormatError.

    They are those of `Frame.raw` if PFNC has a format for them, else the displayed ones in Mono8 or RGB8.
    """
    if not frame.pixel_format.convertible:
        frame.raw()
    pixel_format = pfnc.unpacked(frame.pixel_format)
    if pixel_format is not None:
        return frame.raw(), pixel_format
    if frame.pixel_format.family in (Family.MONO, Family.COORDINATES):
        return frame.mono(), pfnc.by_name("Mono8")
    return frame.rgb(), pfnc.by_name("RGB8")


# -- work on several threads, in order -----------------------------------------------------------
Result = TypeVar("Result")


class OrderedWork(Generic[Result]):
    """Runs tasks that release the GIL (compressing, writing) on several threads, with results in order.

    Use from one thread, which also calls `done` with the results. When `add` returns, at most `waiting` tasks
    are unfinished; with 0 it returns when the task is done.
    """

    def __init__(self, name: str, threads: int, waiting: int, done: Callable[[Result], object]) -> None:
        self._pool = ThreadPoolExecutor(threads, thread_name_prefix=name)
        self._waiting = waiting
        self._done = done
        self._begun: deque[Future[Result]] = deque()

    @property
    def held(self) -> int:
        """Tasks whose results were not yet passed to `done`."""
        return len(self._begun)

    def add(self, work: Callable[[], Result]) -> None:
        """Add a task; wait if too many are held. Raises the error of this task or an earlier one."""
        self._begun.append(self._submitted(work))
        while self._begun and (self._begun[0].done() or len(self._begun) > self._waiting):
            self._done(self._begun.popleft().result())

    def _submitted(self, work: Callable[[], Result]) -> Future[Result]:
        try:
            return self._pool.submit(work)
        except RuntimeError:  # the interpreter is shutting down, and its pools accept no more tasks
            done: Future[Result] = Future()
            try:
                done.set_result(work())
            except Exception as error:
                done.set_exception(error)
            return done

    def finish(self) -> None:
        """Wait for all tasks and end the threads; then raise the first error. May be called twice."""
        failure: BaseException | None = None
        while self._begun:
            try:
                self._done(self._begun.popleft().result())
            except Exception as error:
                failure = failure or error
        self._pool.shutdown()
        if failure is not None:
            raise failure
