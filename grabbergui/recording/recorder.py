"""Records a grabber's stream: the recorder, and the choice of its writer.

A recorder runs on a thread of its own until it is stopped, reaches a limit or fails. Only that thread calls
its writer. A writer stores the time of every frame, and can be closed at any time; its files are then
readable.
"""

from __future__ import annotations

import logging
import threading
import time
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from psygnal import Signal

from grabbergui.core.calibration import FrameCalibration
from grabbergui.core.coord3d import Scan3d
from grabbergui.core.errors import (
    ExistingFileError,
    FrameTimeoutError,
    GrabberError,
    StreamEndedError,
    UsageError,
)
from grabbergui.core.frame import Frame
from grabbergui.core.frame_period import frame_rate
from grabbergui.core.frame_queue import FrameQueue, FrameSource
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.missing_packages import explained
from grabbergui.core.scan3d import read_scan3d
from grabbergui.recording.errors import DiskFullError, RecordingError, SourceClosedError, UnfinishedFileError
from grabbergui.recording.kinds import RecordingKind
from grabbergui.recording.opening import playable_frames
from grabbergui.recording.thinning import ALL_FRAMES, ThinnedFrames, Thinning
from grabbergui.recording.writer import CalibrationOf, RecordingWriter

log = logging.getLogger(__name__)


QUEUE_DEPTH = 16
"Most frames that wait for the disk: half the buffers of a stream, so that enough are left for others."
RESERVE_BYTES = 32 << 20
"Bytes kept free on the disk, so that any file can be finished."
RESERVE_FRAMES = 4
"Frames that must fit on the disk in addition to the reserve."
ON_ITS_WAY = 1.0
"Seconds after the time limit within which its last frame must arrive, or the recording ends without it."
NOTICE_PERIOD = 0.2
"Seconds between signals of progress."
LEAST_SECONDS = 2.0
"Seconds of a recording from which its rate is known well enough to foretell its end."


@dataclass(frozen=True)
class RecordingLimits:
    """The limits at which a recording ends; None for no limit."""

    frames: int | None = None
    seconds: float | None = None
    "From the first frame to the last."
    size: float | None = None
    "Bytes; the frame that reaches them is the last."

    def __post_init__(self) -> None:
        """Raise UsageError for a limit that no recording can have."""
        for unit, limit in (("frames", self.frames), ("seconds", self.seconds), ("bytes", self.size)):
            if limit is not None and not limit > 0:
                raise UsageError(f"a recording cannot end after {limit} {unit}; write more than 0")


UNLIMITED = RecordingLimits()


@dataclass(frozen=True)
class RecordingProgress:
    """The progress of a recording."""

    frames: int = 0
    "Frames written."
    dropped: int = 0
    "Frames lost because the disk or the compression was too slow."
    seconds: float = 0.0
    "From the first frame written to the last."
    size: int = 0
    "Bytes written."
    free: int = 0
    "Free bytes on the disk."
    left_out: int = 0
    "Components of the last frame that this kind of recording does not store."
    ended: bool = False
    error: Exception | None = None
    "Why it ended early; None if it was stopped or reached a limit."

    @property
    def left(self) -> float | None:
        """Seconds until the disk is full at the present rate; None if it is not known yet, or has ended."""
        if self.ended or self.free <= 0 or self.size <= 0 or self.seconds < LEAST_SECONDS:
            return None
        return self.free * self.seconds / self.size

    @property
    def reason(self) -> str:
        """Why it ended early, as display text; empty if it was stopped or reached a limit."""
        if self.error is None:
            return ""
        if isinstance(self.error, DiskFullError | OSError):
            if not self.frames:
                return f"{self.error}; nothing was recorded"
            one = self.frames == 1
            kept = "1 frame recorded by then is" if one else f"{self.frames} frames recorded by then are"
            return f"{self.error}; {kept} kept"
        if isinstance(self.error, GrabberError):
            return str(self.error)
        return f"internal error, see the log: {self.error}"


class Recorder:
    """Writes all or some frames of a source from `start` on. Any thread; its own emits the signal."""

    changed = Signal(RecordingProgress)
    """The progress, a few times a second and once at the end."""

    def __init__(
        self,
        source: FrameSource,
        writer: RecordingWriter,
        limits: RecordingLimits = UNLIMITED,
        *,
        reserve: int = RESERVE_BYTES,
        thinning: Thinning = ALL_FRAMES,
    ) -> None:
        self.writer = writer
        self._limits = limits
        self._reserve = reserve
        self._thinned = ThinnedFrames(thinning)
        self._queue: FrameQueue = source.open_queue(QUEUE_DEPTH)
        self._queue.needs_all = True
        self._progress = RecordingProgress()
        self._first = 0.0
        "`captured` of the first frame."
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name=f"record {writer.path.name}", daemon=True)

    @property
    def progress(self) -> RecordingProgress:
        """The current progress."""
        return self._progress

    def start(self) -> None:
        """Begin with the next frame. Call only once."""
        self._thread.start()

    def stop(self) -> None:
        """End after the current frame; the recorder's thread finishes the files. Never waits."""
        self._stopping.set()

    def wait(self, timeout: float | None = None) -> bool:
        """Wait for the end; return whether the files are finished within `timeout` seconds."""
        self._thread.join(timeout)
        return not self._thread.is_alive()

    def _run(self) -> None:
        problem: Exception | None = None
        try:
            self._record()
        except GrabberError as error:
            problem = error
        except OSError as error:
            problem = OSError(f"{self.writer.path}: {error.strerror or error}")
        except Exception as error:
            log.exception("recording %s", self.writer.path)
            problem = error
        finally:
            self._queue.close()
            self._finish(problem)

    def _record(self) -> None:
        """Write frames until the stream ends, the recording is stopped or reaches a limit.

        Raises any other reason to end.
        """
        noticed = 0.0
        while not self._stopping.is_set():
            try:
                frame = self._queue.get(NOTICE_PERIOD)
            except StreamEndedError:
                return
            except FrameTimeoutError:
                if self._queue.closed and not self._stopping.is_set():
                    raise SourceClosedError from None
                frame = None
            if self._beyond_limit(frame.captured if frame is not None else time.monotonic() - ON_ITS_WAY):
                return
            if frame is not None and self._thinned.take(frame.captured):
                self._check_room(frame)
                self.writer.write(frame)
                self._count(frame)
                if self._reached_limit():
                    return
            if time.monotonic() - noticed >= NOTICE_PERIOD:
                noticed = time.monotonic()
                self.changed.emit(self._progress)

    def _beyond_limit(self, now: float) -> bool:
        seconds = self._limits.seconds
        if seconds is None or not self._progress.frames:
            return False
        return now - self._first > seconds

    def _reached_limit(self) -> bool:
        frames, size = self._limits.frames, self._limits.size
        by_count = frames is not None and self._progress.frames >= frames
        return by_count or (size is not None and self._progress.size >= size)

    def _check_room(self, frame: Frame) -> None:
        free = self.writer.free()
        self._progress = replace(self._progress, free=free)
        if free < self._reserve + RESERVE_FRAMES * frame.nbytes:
            raise DiskFullError(self.writer.path, free)

    def _count(self, frame: Frame) -> None:
        before = self._progress
        if not before.frames:
            self._first = frame.captured
        self._progress = replace(
            before,
            frames=before.frames + 1,
            dropped=self._queue.dropped,
            seconds=max(0.0, frame.captured - self._first),
            size=self.writer.size(),
            left_out=0 if self.writer.keeps_components else max(0, len(frame.parts) - 1),
        )

    def _finish(self, problem: Exception | None) -> None:
        try:
            self.writer.close()
        except (GrabberError, OSError) as error:
            problem = problem or UnfinishedFileError(self.writer.path, error)
        except Exception as error:  # a library's, perhaps raised for a frame before
            log.exception("finishing %s", self.writer.path)
            problem = problem or UnfinishedFileError(self.writer.path, error)
        kept = frames = self.writer.kept(self._progress.frames)
        size = 0
        if problem is not None and kept:
            # A full disk may have lost what an encoder or a buffer had accepted already.
            frames = playable_frames(self.writer.path)
        try:
            if kept and not self.writer.path.exists():
                problem = problem or UnfinishedFileError(self.writer.path, RecordingError("it was removed"))
                kept = frames = 0
            if kept:
                size = self.writer.size()
            if not size:
                self.writer.discard()
        except OSError as error:
            problem = problem or UnfinishedFileError(self.writer.path, error)
        self._progress = replace(
            self._progress,
            ended=True,
            error=problem,
            frames=frames,
            dropped=self._queue.dropped,
            size=size,
        )
        if problem is not None:
            log.info("recording ended: %s", self._progress.reason)  # the caller reports it
        self.changed.emit(self._progress)


def create_writer(
    kind: RecordingKind,
    path: Path,
    info: DeviceInfo,
    rate: float = 0.0,
    scan: Scan3d | None = None,
    calibration: CalibrationOf = lambda frame: None,
) -> RecordingWriter:
    """Return a writer of a kind. `rate` is the camera's in Hz, 0 if unknown; `scan` describes 3D data.

    `calibration` returns a frame's, which ROS messages have as camera_info. Raises ExistingFileError if the
    path is taken, RecordingError if it cannot be created.
    """
    try:
        if path.exists() and not (path.is_dir() and not any(path.iterdir())):
            raise ExistingFileError(
                f"{path} is there already; a recording overwrites nothing, choose another name"
            )
        path.parent.mkdir(parents=True, exist_ok=True)
        # Imported on demand, as each kind needs another library.
        if kind is RecordingKind.MCAP:
            from grabbergui.recording.mcap_writer import McapWriter

            return McapWriter(path, info, scan, calibration)
        if kind is RecordingKind.BAG:
            from grabbergui.recording.bag_writer import BagWriter

            return BagWriter(path, info, scan, calibration)
        if kind in (RecordingKind.PNG, RecordingKind.TIFF):
            from grabbergui.recording.folder import FolderWriter

            return FolderWriter(path, tiff=kind is RecordingKind.TIFF)
        if kind in (RecordingKind.STACK, RecordingKind.NUMPY):
            from grabbergui.recording.stack_writer import NpyWriter, TiffWriter

            return TiffWriter(path) if kind is RecordingKind.STACK else NpyWriter(path)
        from grabbergui.recording.movie_writer import MovieWriter

        return MovieWriter(path, kind, rate)
    except GrabberError:
        raise
    except ImportError as error:
        raise RecordingError(f"{path.name} cannot be recorded: {explained(error)}") from error
    except OSError as error:
        # The file may also be a movie's notes, left from a recording that was removed.
        file = error.filename or path
        problem = f"{file} could not be created: {error.strerror or error}; choose another folder or name"
        if isinstance(error, FileExistsError):
            raise ExistingFileError(problem) from error
        raise RecordingError(problem) from error


def create_recorder(
    grabber: FrameGrabber,
    path: Path,
    kind: RecordingKind,
    limits: RecordingLimits = UNLIMITED,
    calibration: CalibrationOf | None = None,
    thinning: Thinning = ALL_FRAMES,
) -> Recorder:
    """Return a recorder of a grabber's next frames, or of some of them, not yet started.

    `calibration` is by default that which the source reports. Raises as `create_writer`.
    """
    scan = read_scan3d(grabber)
    rate = thinning.rate(frame_rate(grabber))
    of = calibration or partial(_reported_calibration, grabber)
    writer = create_writer(kind, path, grabber.info, rate, scan, of)
    return Recorder(grabber, writer, limits, thinning=thinning)


def _reported_calibration(grabber: FrameGrabber, frame: Frame) -> FrameCalibration | None:
    own = grabber.calibration()
    if own is None or (own.width, own.height) != (frame.width, frame.height):
        return None
    return FrameCalibration(own, own)
