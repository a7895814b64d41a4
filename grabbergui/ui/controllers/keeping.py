"""Settings to files and back, and the picture to recordings."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

from PyQt5.QtCore import QEvent, QObject, pyqtSignal
from PyQt5.QtGui import QDropEvent
from PyQt5.QtWidgets import QFileDialog, QWidget

from grabbergui.core.errors import GrabberError
from grabbergui.core.features import FeatureValue
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.sfnc import Role
from grabbergui.core.uri import SourceUri
from grabbergui.driver.playback.opening import VIDEO_SUFFIXES
from grabbergui.models import feature_set_files
from grabbergui.models.connection import Connection, OpenSource
from grabbergui.models.feature_set import FeatureSet, Selectors, capture
from grabbergui.models.feature_set_loading import LoadReport, load_onto, roll_back
from grabbergui.models.recorder import Recorder, RecordingProgress
from grabbergui.models.recording_writers import RecordingKind, create_writer
from grabbergui.ui.bridge import Bridge
from grabbergui.ui.preferences import Preferences
from grabbergui.ui.views.recording_bar import RecordingBar
from grabbergui.ui.views.settings_report import SettingsReport

SETTINGS_FILTER = "Settings (*.yaml *.yml *.pfs *.txt);;All files (*)"
_SUFFIX = {
    RecordingKind.MCAP: ".mcap",
    RecordingKind.MP4: ".mp4",
    RecordingKind.LOSSLESS: ".mp4",
    RecordingKind.PNG: "",
    RecordingKind.TIFF: "",
}


class KeepingController(QObject):
    """Make it on the GUI thread. Cameras are asked on their own thread, files written on the recorder's."""

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
        self.report: SettingsReport | None = None
        "The dialog shown last."
        bridge = Bridge(self)
        bridge.bind(connection.opened, lambda _: bar.setAvailable(True))
        bridge.bind(connection.closing, lambda _: bar.setAvailable(False))
        # Not over the bridge: its queue must be let go before the grabber is closed.
        connection.ending.connect(self._on_connection_ending)
        self._bridge = bridge
        bar.recordRequested.connect(self.record)
        bar.stopRequested.connect(self.stop_recording)
        bar.folderRequested.connect(self._choose_folder)
        bar.playRequested.connect(self._play)

    def accept_drops(self, window: QWidget) -> None:
        """Take settings (loaded) and recordings (played) that are dragged onto a window."""
        window.setAcceptDrops(True)
        window.installEventFilter(self)

    def eventFilter(self, watched: QObject | None, event: QEvent | None) -> bool:
        """Of a window that accepts drops."""
        if isinstance(event, QDropEvent) and (path := _dropped(event)) is not None:
            event.acceptProposedAction()
            if event.type() == QEvent.Type.Drop:
                self.open_file(path)
            return True
        return super().eventFilter(watched, event)

    def open_file(self, path: Path) -> None:
        """Play what is a recording by its ending, load anything else as settings."""
        if path.is_dir() or path.suffix.lower() in (".mcap", *VIDEO_SUFFIXES):
            self.playRequested.emit(str(SourceUri("file", str(path))))
        else:
            self.load(path)

    def shut_down(self, timeout: float) -> bool:
        """Finish a recording. Whether its files were finished within `timeout` seconds."""
        self.stop_recording()
        return self._recorder is None or self._recorder.wait(timeout)

    # -- settings --------------------------------------------------------------------------------
    def ask_save(self) -> None:
        """Let the user choose a file and save there."""
        chosen, _ = QFileDialog.getSaveFileName(
            self._bar.window(), "Save settings", "settings.yaml", SETTINGS_FILTER
        )
        if chosen:
            self.save(Path(chosen))

    def ask_load(self) -> None:
        """Let the user choose a file and load it."""
        if path := self._asked("Load settings"):
            self.load(path)

    def ask_compare(self) -> None:
        """Let the user choose a file and compare the camera with it."""
        if path := self._asked("Compare the camera with settings"):
            self.compare(path)

    def save(self, path: Path) -> None:
        """Save the camera's settings."""

        def job(grabber: FrameGrabber) -> FeatureSet:
            features = capture(grabber)
            feature_set_files.save(features, path)
            return features

        self._on_camera(job, lambda features: self.noticed.emit(f"Saved {len(features)} settings to {path}"))

    def load(self, path: Path) -> None:
        """Load settings and show what became of each."""
        self._load(path, dry_run=False)

    def compare(self, path: Path) -> None:
        """Show what loading would change, and offer to."""
        self._load(path, dry_run=True)

    def _load(self, path: Path, *, dry_run: bool) -> None:
        def job(grabber: FrameGrabber) -> LoadReport:
            features = feature_set_files.load(path, Selectors(grabber).of)
            return load_onto(grabber, features, dry_run=dry_run)

        title = f"{'Camera and' if dry_run else 'Loaded'} {path.name}"
        self._on_camera(job, lambda report: self._show(title, report, path))

    def _show(self, title: str, report: LoadReport, path: Path) -> None:
        dialog = SettingsReport(self._bar.window())
        dialog.setReport(title, report)
        dialog.applyRequested.connect(lambda: self.load(path))
        dialog.rollBackRequested.connect(lambda: self._roll_back(report))
        dialog.finished.connect(self._on_report_finished)
        self.report = dialog
        dialog.open()

    def _on_report_finished(self, _: int) -> None:
        self.report = None

    def _roll_back(self, report: LoadReport) -> None:
        self._on_camera(
            lambda grabber: roll_back(grabber, report),
            lambda after: self.noticed.emit(f"Rolled back: {after.summary()}"),
        )

    def _on_camera(self, job: Callable[[FrameGrabber], object], done: Callable[..., None]) -> None:
        """Run a job on the camera's thread, then `done` with its result on this one."""
        source = self._connection.source
        if source is None or source.grabber is None:
            self.failed.emit("there is no camera; connect to one first")
            return
        grabber = source.grabber
        source.worker.submit(
            lambda: job(grabber),
            done=lambda result: self._bridge.call(lambda: done(result)),
            failed=self._fail_later,
        )

    def _fail_later(self, error: GrabberError) -> None:
        self._bridge.call(lambda: self.failed.emit(str(error)))

    def _asked(self, title: str) -> Path | None:
        chosen, _ = QFileDialog.getOpenFileName(self._bar.window(), title, "", SETTINGS_FILTER)
        return Path(chosen) if chosen else None

    # -- recording -------------------------------------------------------------------------------
    def record(self, kind: RecordingKind) -> None:
        """Begin a recording named by the camera and the time."""
        source = self._connection.source
        if source is None or self._recorder is not None:
            return
        name = f"{source.title.replace('/', '-')}_{time.strftime('%Y%m%d-%H%M%S')}"
        path = self._preferences.snapshot_folder / f"{name}{_SUFFIX[kind]}"

        def job(grabber: FrameGrabber) -> Recorder:
            writer = create_writer(kind, path, grabber.info, _frame_rate(grabber))
            return Recorder(grabber, writer)

        self._on_camera(job, lambda recorder: self._begin(source, recorder))

    def stop_recording(self) -> None:
        """End it; files are finished behind the scenes."""
        if self._recorder is not None:
            self._recorder.stop()

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
        self._recorder, self._last = None, recorder.writer.path
        self._bar.setRecording(False)
        if progress.frames:
            self._bar.setPlayable(self._last.name)
        if progress.reason:
            self.failed.emit(f"The recording ended: {progress.reason}")
        else:
            self.noticed.emit(f"Recorded {progress.frames} frames to {self._last}")

    def _on_connection_ending(self, source: OpenSource) -> None:
        if source is self._recorded:
            self.stop_recording()

    def _choose_folder(self) -> None:
        before = str(self._preferences.snapshot_folder)
        chosen = QFileDialog.getExistingDirectory(self._bar.window(), "Folder for recordings", before)
        if chosen:
            self._preferences.snapshot_folder = Path(chosen)

    def _play(self) -> None:
        if self._last is not None:
            self.playRequested.emit(str(SourceUri("file", str(self._last))))


def _dropped(event: QDropEvent) -> Path | None:
    data = event.mimeData()
    urls = data.urls() if data is not None else []
    return Path(urls[0].toLocalFile()) if len(urls) == 1 and urls[0].isLocalFile() else None


def _frame_rate(grabber: FrameGrabber) -> float:
    name = Role.FRAME_RATE.find(grabber.has_feature)
    value: FeatureValue | None = grabber.feature(name).value if name is not None else None
    return float(value) if isinstance(value, int | float) else 0.0
