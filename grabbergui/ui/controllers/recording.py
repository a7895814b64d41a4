"""The picture to recordings."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

from PyQt5.QtCore import QObject, pyqtSignal
from PyQt5.QtWidgets import QFileDialog

from grabbergui.core.errors import GrabberError
from grabbergui.core.features import FeatureValue
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.sfnc import Role
from grabbergui.core.uri import SourceUri
from grabbergui.models.connection import Connection
from grabbergui.models.error_text import error_text
from grabbergui.models.open_source import OpenSource
from grabbergui.models.recording.recorder import Recorder, RecordingLimits, RecordingProgress
from grabbergui.models.recording.writers import RecordingKind, create_writer
from grabbergui.ui.bridge import Bridge
from grabbergui.ui.preferences import Preferences
from grabbergui.ui.views.recording_bar import RecordingBar

_SUFFIX = {
    RecordingKind.MCAP: ".mcap",
    RecordingKind.MP4: ".mp4",
    RecordingKind.LOSSLESS: ".mp4",
    RecordingKind.PNG: "",
    RecordingKind.TIFF: "",
}


class RecordingController(QObject):
    """Records the source at hand, and goes on while another one is; files are written on another thread."""

    failed = pyqtSignal(str)
    noticed = pyqtSignal(str)
    playRequested = pyqtSignal(str)
    """The URI of a recording to open in place of the camera."""

    def __init__(self, bar: RecordingBar, connection: Connection, preferences: Preferences) -> None:
        super().__init__(bar)
        self._bar = bar
        self._connection = connection
        self._preferences = preferences
        self._recorder: Recorder | None = None
        self._recorded: OpenSource | None = None
        "What the recorder records; also while another source is at hand."
        self._last: Path | None = None
        bridge = Bridge(self)
        bridge.bind(connection.opened, lambda _: bar.setAvailable(True))
        bridge.bind(connection.closing, lambda _: bar.setAvailable(self._recorder is not None))
        # Not over the bridge: its queue must be let go before the grabber is closed.
        connection.ending.connect(self._on_connection_ending)
        self._bridge = bridge
        bar.recordRequested.connect(self.record)
        bar.stopRequested.connect(self.stop)
        bar.folderRequested.connect(self._choose_folder)
        bar.playRequested.connect(self._play)

    def shut_down(self, timeout: float) -> bool:
        """Finish a recording. Whether its files were finished within `timeout` seconds."""
        self.stop()
        return self._recorder is None or self._recorder.wait(timeout)

    def record(self, kind: RecordingKind, limits: RecordingLimits) -> None:
        """Begin a recording named by the camera and the time."""
        source = self._connection.source
        if source is None or source.grabber is None or self._recorder is not None:
            return
        name = f"{source.title.replace('/', '-')}_{time.strftime('%Y%m%d-%H%M%S')}"
        path = self._preferences.snapshot_folder / f"{name}{_SUFFIX[kind]}"
        grabber = source.grabber

        def job() -> Recorder:
            writer = create_writer(kind, path, grabber.info, _frame_rate(grabber))
            return Recorder(grabber, writer, limits)

        source.worker.submit(
            job,
            done=self._later(lambda recorder: self._begin(source, recorder)),
            failed=self._later(lambda error: self.failed.emit(error_text(error))),
        )

    def stop(self) -> None:
        """End it; files are finished behind the scenes."""
        if self._recorder is not None:
            self._recorder.stop()

    def _later(self, slot: Callable[..., None]) -> Callable[[Recorder | GrabberError], None]:
        """On the GUI thread."""
        return lambda result: self._bridge.call(lambda: slot(result))

    def _begin(self, source: OpenSource, recorder: Recorder) -> None:
        self._recorder, self._recorded = recorder, source
        self._bridge.bind(recorder.changed, self._on_recorder_changed)
        self._bar.setRecording(True)
        recorder.start()
        if source.abandoned.is_set():
            recorder.stop()

    def _on_recorder_changed(self, progress: RecordingProgress) -> None:
        self._bar.setProgress(progress)
        recorder = self._recorder
        if not progress.ended or recorder is None:
            return
        self._recorder, self._recorded, self._last = None, None, recorder.writer.path
        self._bar.setRecording(False)
        self._bar.setAvailable(self._connection.state.connected)
        if progress.frames:
            self._bar.setPlayable(self._last.name)
        if progress.reason:
            self.failed.emit(self.tr("The recording ended: {0}").format(progress.reason))
        elif not progress.frames:
            self.noticed.emit(self.tr("Nothing was recorded"))
        else:
            text = self.tr("Recorded {0} frames to {1}")
            self.noticed.emit(text.format(progress.frames, self._last))

    def _on_connection_ending(self, source: OpenSource) -> None:
        if source is self._recorded:
            self.stop()

    def _choose_folder(self) -> None:
        before = str(self._preferences.snapshot_folder)
        title = self.tr("Folder for recordings")
        chosen = QFileDialog.getExistingDirectory(self._bar.window(), title, before)
        if chosen:
            self._preferences.snapshot_folder = Path(chosen)

    def _play(self) -> None:
        if self._last is not None:
            self.playRequested.emit(str(SourceUri("file", str(self._last))))


def _frame_rate(grabber: FrameGrabber) -> float:
    name = Role.FRAME_RATE.find(grabber.has_feature)
    value: FeatureValue | None = grabber.feature(name).value if name is not None else None
    return float(value) if isinstance(value, int | float) else 0.0
