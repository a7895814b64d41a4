"""The strip below the picture that records it."""

from __future__ import annotations

from PyQt5.QtCore import pyqtSignal
from PyQt5.QtWidgets import QComboBox, QLabel, QPushButton, QToolButton, QWidget

from grabbergui.models.recorder import RecordingProgress
from grabbergui.models.recording_writers import RecordingKind
from grabbergui.ui import icons
from grabbergui.ui.loader import load_form

_KINDS = {
    RecordingKind.MCAP: "ROS 2 messages (MCAP)",
    RecordingKind.MP4: "Movie (MP4)",
    RecordingKind.LOSSLESS: "Movie, lossless (MP4)",
    RecordingKind.PNG: "Pictures (PNG)",
    RecordingKind.TIFF: "Pictures (TIFF, fast)",
}


class RecordingBar(QWidget):
    """Setters in, signals out."""

    recordRequested = pyqtSignal(RecordingKind)
    stopRequested = pyqtSignal()
    folderRequested = pyqtSignal()
    playRequested = pyqtSignal()

    recordButton: QPushButton
    kindBox: QComboBox
    folderButton: QToolButton
    progressLabel: QLabel
    playButton: QPushButton

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("recording_bar", self)
        for kind, text in _KINDS.items():
            self.kindBox.addItem(text, kind)
        self.recordButton.clicked.connect(self._on_record_clicked)
        self.folderButton.clicked.connect(self.folderRequested)
        self.playButton.clicked.connect(self.playRequested)
        icons.apply(self)

    def setAvailable(self, available: bool) -> None:
        """Whether there is a source to record."""
        self.recordButton.setEnabled(available)

    def setRecording(self, recording: bool) -> None:
        """Whether a recording runs."""
        self.recordButton.setChecked(recording)
        self.recordButton.setText("Stop recording" if recording else "Record")
        self.kindBox.setEnabled(not recording)
        self.folderButton.setEnabled(not recording)
        self.playButton.setVisible(False)

    def setProgress(self, progress: RecordingProgress) -> None:
        """Length, size, what was lost, what is left."""
        minutes, seconds = divmod(progress.seconds, 60)
        parts = [f"{int(minutes):02d}:{seconds:04.1f}", f"{progress.frames} frames", _bytes(progress.size)]
        if progress.dropped:
            parts.append(f"{progress.dropped} dropped")
        if progress.free and not progress.ended:
            parts.append(f"{_bytes(progress.free)} free")
        self.progressLabel.setText(" · ".join(parts))
        self.progressLabel.setToolTip(self.progressLabel.text())

    def setPlayable(self, name: str) -> None:
        """A recording is finished; its name."""
        self.playButton.setVisible(True)
        self.playButton.setToolTip(f"Play {name} in place of the camera")

    def _on_record_clicked(self, checked: bool) -> None:
        # The button shows what is, not what was asked for: the program sets it back once it records.
        self.recordButton.setChecked(not checked)
        if checked:
            self.recordRequested.emit(self.kindBox.currentData())
        else:
            self.stopRequested.emit()


def _bytes(count: int) -> str:
    return f"{count / 1e9:.1f} GB" if count >= 1e9 else f"{count / 1e6:.0f} MB"
