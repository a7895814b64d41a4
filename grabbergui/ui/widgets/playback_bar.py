"""Bars below the image: playing a recording, and stepping through paused frames."""

from __future__ import annotations

from PyQt5.QtCore import QSignalBlocker, pyqtSignal
from PyQt5.QtWidgets import QComboBox, QLabel, QPushButton, QSlider, QToolButton, QWidget

from grabbergui.models.language import localized
from grabbergui.models.playback import PlaybackState
from grabbergui.ui import icons
from grabbergui.ui.loader import load_form

SPEEDS = (0.1, 0.25, 0.5, 1.0, 2.0, 4.0, 10.0)


class PlaybackBar(QWidget):
    """Setters in, signals out; hidden while the source is no recording."""

    playRequested = pyqtSignal(bool)
    stepRequested = pyqtSignal(int)
    positionChosen = pyqtSignal(int)
    speedChosen = pyqtSignal(float)
    loopRequested = pyqtSignal(bool)

    backButton: QToolButton
    playButton: QToolButton
    forwardButton: QToolButton
    slider: QSlider
    placeLabel: QLabel
    speedBox: QComboBox
    loopButton: QToolButton

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("playback_bar", self)
        self._playing = False
        for speed in SPEEDS:
            self.speedBox.addItem(_times(speed), speed)
        self.backButton.clicked.connect(lambda: self.stepRequested.emit(-1))
        self.forwardButton.clicked.connect(lambda: self.stepRequested.emit(1))
        self.playButton.clicked.connect(lambda: self.playRequested.emit(not self._playing))
        self.slider.valueChanged.connect(self.positionChosen)
        self.speedBox.activated[int].connect(self._on_speed_chosen)
        self.loopButton.clicked[bool].connect(self.loopRequested)
        icons.apply(self)
        self.hide()

    def setState(self, state: PlaybackState) -> None:
        """Show how the recording stands."""
        self._playing = state.playing
        self.playButton.setText(self.tr("Hold") if state.playing else self.tr("Play"))
        self.playButton.setAccessibleName(self.playButton.text())
        name = "pause" if state.playing else "start"
        if self.playButton.property("iconName") != name:
            self.playButton.setProperty("iconName", name)
            self.playButton.setIcon(icons.icon(name, self.palette()))
        with QSignalBlocker(self.slider):
            self.slider.setRange(0, max(0, state.frames - 1))
            if not self.slider.isSliderDown():
                self.slider.setValue(state.position)
        self.slider.setPageStep(max(1, state.frames // 10))
        figures = f"{_clock(state.time)} / {_clock(state.duration)}   {state.position + 1} / {state.frames}"
        self.placeLabel.setText(figures)
        self._show_speed(state.speed)
        self.loopButton.setChecked(state.loop)

    def _on_speed_chosen(self, index: int) -> None:
        self.speedChosen.emit(self.speedBox.itemData(index))

    def _show_speed(self, speed: float) -> None:
        index = self.speedBox.findData(speed)
        if index < 0:  # set elsewhere, e.g. in the panel of features
            self.speedBox.addItem(_times(speed), speed)
            index = self.speedBox.count() - 1
        self.speedBox.setCurrentIndex(index)


def _times(speed: float) -> str:
    return localized(f"{speed:g} ×")


def _clock(seconds: float) -> str:
    minutes, rest = divmod(max(0.0, seconds), 60)
    return localized(f"{int(minutes):02d}:{rest:04.1f}")


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
