"""Steps through the frames that were kept, while the picture is paused."""

from __future__ import annotations

from PyQt5.QtCore import QSignalBlocker, pyqtSignal
from PyQt5.QtWidgets import QLabel, QPushButton, QSlider, QWidget

from grabbergui.models.language import localized
from grabbergui.ui.loader import load_form


class PauseBar(QWidget):
    """Hidden while the picture is live."""

    frameChosen = pyqtSignal(int)
    """Which of the frames kept is to be shown; 0 is the oldest."""
    liveRequested = pyqtSignal()

    placeLabel: QLabel
    slider: QSlider
    liveButton: QPushButton

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("pause_bar", self)
        self.slider.valueChanged.connect(self.frameChosen)
        self.liveButton.clicked.connect(self.liveRequested)
        self.hide()

    def setPlace(self, index: int, count: int, age: float) -> None:
        """Show which of `count` frames is seen, `age` seconds older than the newest of them."""
        with QSignalBlocker(self.slider):
            self.slider.setRange(0, max(0, count - 1))
            self.slider.setValue(index)
        self.placeLabel.setText(localized(self.tr("{0} of {1}   −{2:.2f} s").format(index + 1, count, age)))
