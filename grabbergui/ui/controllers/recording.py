"""Connects the current source to its recording; asks before a recorded source is closed."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from PyQt5.QtCore import QObject, Qt, pyqtSignal
from PyQt5.QtWidgets import QMessageBox

from grabbergui.core.uri import SourceUri
from grabbergui.models.connection import Connection
from grabbergui.models.open_source import LinkState, OpenSource
from grabbergui.models.recordings import Recordings
from grabbergui.recording.recorder import RecordingLimits
from grabbergui.recording.writer import RecordingKind
from grabbergui.ui.bridge import Bridge
from grabbergui.ui.preferences import Preferences
from grabbergui.ui.views.bases import FileQuestions
from grabbergui.ui.views.recording_bar import RecordingBar

Confirm = Callable[[Sequence[OpenSource | None], Callable[[], None]], None]
"""Does something that closes these sources, after asking where one is being recorded."""


class RecordingController(QObject):
    """Shows and controls the recording of the current source; others go on meanwhile."""

    playRequested = pyqtSignal(str)
    """The URI of a recording to open in place of the camera."""
    availableChanged = pyqtSignal(bool)
    """Whether there is something to record, or a recording to stop."""

    def __init__(
        self,
        bar: RecordingBar,
        connection: Connection,
        recordings: Recordings,
        preferences: Preferences,
        files: FileQuestions,
    ) -> None:
        super().__init__(bar)
        self._files = files
        self._bar = bar
        self._connection = connection
        self._recordings = recordings
        self._preferences = preferences
        self.question: QMessageBox | None = None
        """Ask whether to close a source that is being recorded."""
        bridge = Bridge(self)
        bridge.bind(recordings.changed, lambda _: self._show())
        bridge.bind(connection.state_changed, lambda *_: self._show())
        bar.recordRequested.connect(self.record)
        bar.stopRequested.connect(self.stop)
        bar.folderRequested.connect(self._choose_folder)
        bar.playRequested.connect(self._play)
        self._show()

    def record(self, kind: RecordingKind, limits: RecordingLimits) -> None:
        """Begin to record the current source."""
        if (source := self._connection.source) is not None:
            self._recordings.begin(source, self._preferences.snapshot_folder, kind, limits)

    def stop(self) -> None:
        """End the recording of the current source; files are finished behind the scenes."""
        if (source := self._connection.source) is not None:
            self._recordings.stop(source)

    def confirm(self, closing: Sequence[OpenSource | None], proceed: Callable[[], None]) -> None:
        """Do what closes these sources, at once where none is being recorded, else after asking."""
        recorded = [source for source in closing if source is not None and self._recordings.runs(source)]
        if not recorded:
            proceed()
            return
        if self.question is not None:
            self.question.raise_()
            return
        names = ", ".join(source.title for source in recorded)
        box = QMessageBox(self._bar.window())
        box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        box.setIcon(QMessageBox.Icon.Question)
        box.setWindowTitle(self.tr("Recording"))
        box.setText(self.tr("Being recorded: {0}").format(names))
        box.setInformativeText(self.tr("Closing ends the recording; what was recorded so far is kept."))
        close = box.addButton(self.tr("Stop recording and close"), QMessageBox.ButtonRole.AcceptRole)
        go_on = box.addButton(self.tr("Go on recording"), QMessageBox.ButtonRole.RejectRole)
        box.setDefaultButton(go_on)
        box.setEscapeButton(go_on)

        def answered() -> None:
            self.question = None
            if box.clickedButton() is close:
                proceed()

        box.finished.connect(lambda _: answered())
        self.question = box
        box.open()

    def _show(self) -> None:
        source = self._connection.source
        recording = self._recordings.of(source)
        running = source is not None and self._recordings.runs(source)
        self._bar.setRecording(running)
        if recording is not None:
            self._bar.setProgress(recording.progress)
            if not recording.running and recording.progress.frames:
                self._bar.setPlayable(recording.path.name)
        available = running or self._connection.state is LinkState.STREAMING
        self._bar.setAvailable(available)
        self.availableChanged.emit(available)

    def _choose_folder(self) -> None:
        before = self._preferences.snapshot_folder
        if chosen := self._files.folder(self.tr("Folder for recordings"), before):
            self._preferences.snapshot_folder = chosen

    def _play(self) -> None:
        recording = self._recordings.of(self._connection.source)
        if recording is not None:
            self.playRequested.emit(str(SourceUri("file", str(recording.path))))
