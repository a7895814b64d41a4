"""Recordings of open sources."""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass
from pathlib import Path

from psygnal import Signal

from grabbergui.core.errors import GrabberError
from grabbergui.core.grabber import FrameGrabber
from grabbergui.models.error_text import error_text
from grabbergui.models.language import counted, translate
from grabbergui.models.messages import MessageModel
from grabbergui.models.open_source import OpenSource
from grabbergui.models.open_sources import OpenSources
from grabbergui.recording.errors import DiskFullError, SourceClosedError, UnfinishedFileError
from grabbergui.recording.kinds import RecordingKind
from grabbergui.recording.recorder import Recorder, RecordingLimits, RecordingProgress, create_recorder
from grabbergui.recording.thinning import ALL_FRAMES, Thinning


@dataclass(frozen=True)
class SourceRecording:
    """State of a source's recording, also after its end until the next one begins."""

    path: Path
    progress: RecordingProgress

    @property
    def running(self) -> bool:
        """Whether frames are still written."""
        return not self.progress.ended


class Recordings:
    """Records open sources, each to files of its own. Methods may be called from any thread and never wait.

    A recording continues while its source is in the background and ends when the source is closed. Signals
    come from the thread of the source or of its recorder.
    """

    changed = Signal(OpenSource)
    """The recording of a source began, progressed or ended: see `of`."""

    def __init__(self, open_sources: OpenSources, messages: MessageModel) -> None:
        self._open_sources, self._messages = open_sources, messages
        self._recorders: dict[OpenSource, Recorder] = {}
        "The last recorder of each source, until the source is closed."
        self._beginning: set[OpenSource] = set()
        self._ending: list[Recorder] = []
        "Recorders of closed sources that still finish their files."
        self._lock = threading.RLock()
        open_sources.ending.connect(self._on_ending)

    @property
    def running(self) -> tuple[OpenSource, ...]:
        """The sources that are being recorded."""
        with self._lock:
            return tuple(source for source in self._recorders if self.runs(source))

    def runs(self, source: OpenSource) -> bool:
        """Return whether a source is being recorded."""
        with self._lock:
            recorder = self._recorders.get(source)
            return source in self._beginning or (recorder is not None and not recorder.progress.ended)

    def of(self, source: OpenSource | None) -> SourceRecording | None:
        """Return the state of a source's recording, or its final state."""
        with self._lock:
            recorder = self._recorders.get(source) if source is not None else None
        return SourceRecording(recorder.writer.path, recorder.progress) if recorder is not None else None

    def begin(
        self,
        source: OpenSource,
        folder: Path,
        kind: RecordingKind,
        limits: RecordingLimits,
        thinning: Thinning = ALL_FRAMES,
    ) -> None:
        """Record a source to a file named after the camera and the time, unless it is being recorded."""
        grabber = source.grabber
        with self._lock:
            if grabber is None or self.runs(source):
                return
            self._beginning.add(source)

        def job() -> Recorder:
            path = self._new_path(folder, grabber, kind)
            return create_recorder(grabber, path, kind, limits, thinning=thinning)

        def failed(error: GrabberError) -> None:
            with self._lock:
                self._beginning.discard(source)
            self._messages.error(error_text(error), source)
            self.changed.emit(source)

        if not source.worker.submit(job, done=lambda made: self._begun(source, made), failed=failed):
            with self._lock:
                self._beginning.discard(source)

    def stop(self, source: OpenSource) -> None:
        """End the recording of a source; its recorder finishes the files."""
        with self._lock:
            recorder = self._recorders.get(source)
        if recorder is not None:
            recorder.stop()

    def close(self, timeout: float) -> bool:
        """End all; return whether their files were finished within `timeout` seconds. Can be repeated."""
        deadline = time.monotonic() + timeout
        with self._lock:
            recorders = [*self._recorders.values(), *self._ending]
        for recorder in recorders:
            recorder.stop()
        ended = [recorder.wait(max(0.0, deadline - time.monotonic())) for recorder in recorders]
        return all(ended)

    def _new_path(self, folder: Path, grabber: FrameGrabber, kind: RecordingKind) -> Path:
        """Return a unique name: cameras with equal user names may start in the same second."""
        stem = f"{grabber.info.file_name or 'recording'}_{time.strftime('%Y%m%d-%H%M%S')}"
        with self._lock:
            taken = {recorder.writer.path for recorder in (*self._recorders.values(), *self._ending)}
        path, number = folder / f"{stem}{kind.suffix}", 1
        while path in taken or path.exists():
            number += 1
            path = folder / f"{stem}_{number}{kind.suffix}"
        return path

    def _begun(self, source: OpenSource, recorder: Recorder) -> None:
        with self._lock:
            self._beginning.discard(source)
            self._recorders[source] = recorder
        recorder.changed.connect(lambda progress: self._on_recorder_changed(source, recorder, progress))
        recorder.start()
        if source not in self._open_sources.all:  # closed meanwhile
            self._on_ending(source)
        self.changed.emit(source)

    def _on_recorder_changed(
        self, source: OpenSource, recorder: Recorder, progress: RecordingProgress
    ) -> None:
        if progress.ended:
            with self._lock:
                owner = source if source in self._recorders else None
                self._ending = [other for other in self._ending if other is not recorder]
            self._post_end(source.title, owner, recorder.writer.path, progress)
        self.changed.emit(source)

    def _post_end(
        self, title: str, owner: OpenSource | None, path: Path, progress: RecordingProgress
    ) -> None:
        """Post a message about the source, or about the window if the source is closed."""
        if progress.reason:
            text = translate("Recording", "the recording of {0} ended: {1}")
            self._messages.error(text.format(title, _ended_text(progress)), owner)
        elif not progress.frames:
            text = translate("Recording", "nothing was recorded of {0}").format(title)
            self._messages.notice(text, owner)
        else:
            frames = counted(
                progress.frames, translate("Recording", "1 frame"), translate("Recording", "{0} frames")
            )
            text = translate("Recording", "recorded {0} to {1}")
            self._messages.notice(text.format(frames, path), owner)

    def _on_ending(self, source: OpenSource) -> None:
        # The recorder's queue must be closed before the grabber.
        with self._lock:
            recorder = self._recorders.pop(source, None)
            if recorder is not None and not recorder.progress.ended:
                self._ending.append(recorder)
        if recorder is not None:
            recorder.stop()
        self.changed.emit(source)


def _ended_text(progress: RecordingProgress) -> str:
    """Return why a recording ended early, in the user's language."""
    error = progress.error
    assert error is not None
    if isinstance(error, DiskFullError):
        text = translate("Recording", "the disk of {0} is full ({1} MiB left)").format(
            error.path, error.free >> 20
        )
    elif isinstance(error, SourceClosedError):
        return translate("Recording", "the source was closed")
    elif isinstance(error, UnfinishedFileError):
        return translate("Recording", "{0} could not be finished: {1}").format(error.path, error.cause)
    elif isinstance(error, GrabberError):
        return error_text(error)
    elif isinstance(error, OSError):
        text = str(error)
    else:
        return translate("Recording", "internal error, see the log: {0}").format(error)
    if progress.frames:
        return text + counted(
            progress.frames,
            translate("Recording", "; 1 frame recorded by then is kept"),
            translate("Recording", "; {0} frames recorded by then are kept"),
        )
    return text + translate("Recording", "; nothing was recorded")
