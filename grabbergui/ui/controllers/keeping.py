"""Settings to files and back."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PyQt5.QtCore import QT_TRANSLATE_NOOP, QEvent, QObject, pyqtSignal
from PyQt5.QtGui import QDropEvent
from PyQt5.QtWidgets import QFileDialog, QWidget

from grabbergui.core.errors import GrabberError
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.uri import SourceUri
from grabbergui.driver.playback.opening import VIDEO_SUFFIXES
from grabbergui.models import feature_set_files
from grabbergui.models.connection import Connection
from grabbergui.models.feature_set import FeatureSet, Selectors, capture
from grabbergui.models.feature_set_loading import LoadReport, load_onto, roll_back
from grabbergui.ui.bridge import Bridge
from grabbergui.ui.views.settings_report import SettingsReport

SETTINGS_FILTER = QT_TRANSLATE_NOOP("KeepingController", "Settings (*.yaml *.yml *.pfs *.txt);;All files (*)")


class KeepingController(QObject):
    """Make it on the GUI thread. Cameras are asked on their own thread."""

    failed = pyqtSignal(str)
    noticed = pyqtSignal(str)
    playRequested = pyqtSignal(str)
    """The URI of a recording to open in place of the camera."""

    def __init__(self, window: QWidget, connection: Connection) -> None:
        super().__init__(window)
        self._window = window
        self._connection = connection
        self.report: SettingsReport | None = None
        "The dialog shown last."
        self._bridge = Bridge(self)

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

    # -- settings --------------------------------------------------------------------------------
    def ask_save(self) -> None:
        """Let the user choose a file and save there."""
        chosen, _ = QFileDialog.getSaveFileName(
            self._window, self.tr("Save settings"), "settings.yaml", SETTINGS_FILTER
        )
        if chosen:
            self.save(Path(chosen))

    def ask_load(self) -> None:
        """Let the user choose a file and load it."""
        if path := self._asked(self.tr("Load settings")):
            self.load(path)

    def ask_compare(self) -> None:
        """Let the user choose a file and compare the camera with it."""
        if path := self._asked(self.tr("Compare the camera with settings")):
            self.compare(path)

    def save(self, path: Path) -> None:
        """Save the camera's settings."""

        def job(grabber: FrameGrabber) -> FeatureSet:
            features = capture(grabber)
            feature_set_files.save(features, path)
            return features

        text = self.tr("Saved {0} settings to {1}")
        self._on_camera(job, lambda features: self.noticed.emit(text.format(len(features), path)))

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

        title = (self.tr("Camera and {0}") if dry_run else self.tr("Loaded {0}")).format(path.name)
        self._on_camera(job, lambda report: self._show(title, report, path))

    def _show(self, title: str, report: LoadReport, path: Path) -> None:
        dialog = SettingsReport(self._window)
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
            lambda after: self.noticed.emit(self.tr("Rolled back: {0}").format(after.summary())),
        )

    def _on_camera(self, job: Callable[[FrameGrabber], object], done: Callable[..., None]) -> None:
        """Run a job on the camera's thread, then `done` with its result on this one."""
        source = self._connection.source
        if source is None or source.grabber is None:
            self.failed.emit(self.tr("there is no camera; connect to one first"))
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
        chosen, _ = QFileDialog.getOpenFileName(self._window, title, "", self.tr(SETTINGS_FILTER))
        return Path(chosen) if chosen else None


def _dropped(event: QDropEvent) -> Path | None:
    data = event.mimeData()
    urls = data.urls() if data is not None else []
    return Path(urls[0].toLocalFile()) if len(urls) == 1 and urls[0].isLocalFile() else None
