"""The bars of recording a source, of playing a recording, and of stepping through paused frames."""

from __future__ import annotations

from dataclasses import dataclass

from PyQt5.QtCore import QSignalBlocker, QSize, pyqtSignal
from PyQt5.QtGui import QResizeEvent
from PyQt5.QtWidgets import (
    QWIDGETSIZE_MAX,
    QComboBox,
    QDoubleSpinBox,
    QLabel,
    QPushButton,
    QSlider,
    QToolButton,
    QWidget,
)

from grabbergui.models.language import counted, localized
from grabbergui.models.playback import PlaybackState
from grabbergui.recording.kinds import RecordingKind
from grabbergui.recording.recorder import RecordingLimits, RecordingProgress
from grabbergui.ui.form_loader import load_form
from grabbergui.ui.shown_text import set_tooltip
from grabbergui.ui.theme import icon
from grabbergui.ui.widgets.labels import ElidedLabel

_OFFERED = (
    RecordingKind.MCAP,
    RecordingKind.BAG,
    RecordingKind.H264,
    RecordingKind.LOSSLESS,
    RecordingKind.FFV1,
    RecordingKind.PNG,
    RecordingKind.TIFF,
    RecordingKind.STACK,
    RecordingKind.NUMPY,
)
"""In the order of the form's `kindBox`; the first is the default."""
NARROW = 480
"Width below which *Play* is an icon, the folder is only in the menu, and the progress is hidden."
_LEAST_CHOICE, _WHOLE_CHOICE = 70, 138
"Width of the box for the end of a recording: at least, and where there is room."
_ICON_ROOM = 20
"Pixels beside the icon of a button without text."
SPEEDS = (0.1, 0.25, 0.5, 1.0, 2.0, 4.0, 10.0)


@dataclass(frozen=True)
class _Limit:
    """One way for a recording to end, as the user enters it."""

    field: str
    "Name of the field of RecordingLimits."
    unit: str
    usual: float
    "The initial value."
    decimals: int = 0
    scale: float = 1
    "Converts the typed text to the field's value."


_LIMITS = (
    None,
    _Limit("seconds", "s", 10, decimals=1),
    _Limit("frames", "", 100),
    _Limit("size", "MB", 1000, scale=1e6),
)
"""In the order of the form's `limitBox`."""


class RecordingBar(QWidget):
    """Setters in, signals out."""

    recordRequested = pyqtSignal(RecordingKind, RecordingLimits)
    stopRequested = pyqtSignal()
    folderRequested = pyqtSignal()
    playRequested = pyqtSignal()

    recordButton: QPushButton
    kindBox: QComboBox
    limitBox: QComboBox
    amountBox: QDoubleSpinBox
    folderButton: QToolButton
    progressLabel: ElidedLabel
    playButton: QPushButton

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("recording_bar", self)
        self._thinning = ""
        for kind in _OFFERED:
            self.kindBox.addItem(self._kind_text(kind), kind)
        self._amounts = [None if limit is None else limit.usual for limit in _LIMITS]
        self.limitBox.currentIndexChanged[int].connect(self._on_limit_chosen)
        self.amountBox.valueChanged[float].connect(self._on_amount_changed)
        self.recordButton.clicked.connect(self._on_record_clicked)
        self.folderButton.clicked.connect(self.folderRequested)
        self.playButton.clicked.connect(self.playRequested)

    def minimumSizeHint(self) -> QSize:
        """Return that of the narrow bar, so that the window can become as narrow."""
        width, layout = super().minimumSizeHint().width(), self.layout()
        spacing = layout.spacing() if layout is not None else 0
        for widget in self._spared():
            if not widget.isHidden():
                width -= widget.minimumSizeHint().width() + spacing
        if self.playButton.text() and not self.playButton.isHidden():
            width -= max(0, self.playButton.minimumSizeHint().width() - self._play_width())
        if not self.limitBox.isHidden():
            width -= self.limitBox.minimumWidth() - _LEAST_CHOICE
        return QSize(width, self._height())

    def sizeHint(self) -> QSize:
        """Return the same height whichever parts are shown, so that nothing above moves."""
        return QSize(super().sizeHint().width(), self._height())

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Show as much as there is room for."""
        super().resizeEvent(event)
        self._arrange()

    def setRecording(self, recording: bool) -> None:
        """Show whether a recording runs."""
        self.recordButton.setChecked(recording)
        self._show_button()
        # A running recording cannot be changed, and its progress needs the space.
        for choice in (self.kindBox, self.limitBox):
            choice.setVisible(not recording)
        self.amountBox.setVisible(not recording and _LIMITS[self.limitBox.currentIndex()] is not None)
        self._arrange()
        self.playButton.setVisible(False)
        self.progressLabel.clear()

    def setThinning(self, text: str) -> None:
        """Show which frames the next recording has: `1/10`, `5 s`; empty for all."""
        self._thinning = text
        self._show_button()
        self._arrange()

    def _show_button(self) -> None:
        if self.recordButton.isChecked():
            self.recordButton.setText(self.tr("Stop recording"))
        else:
            self.recordButton.setText(" · ".join(filter(None, (self.tr("Record"), self._thinning))))

    def setProgress(self, progress: RecordingProgress) -> None:
        """Show length, size, lost frames and free space."""
        minutes, seconds = divmod(progress.seconds, 60)
        frames = counted(progress.frames, self.tr("1 frame"), self.tr("{0} frames"))
        parts = [localized(f"{int(minutes):02d}:{seconds:04.1f}"), frames, _bytes(progress.size)]
        if progress.dropped:
            parts.append(counted(progress.dropped, self.tr("1 dropped"), self.tr("{0} dropped")))
        if progress.left_out:
            parts.append(self.tr("first image of {0}").format(progress.left_out + 1))
        if progress.free and not progress.ended:
            parts.append(self.tr("{0} free").format(_bytes(progress.free)))
        if (left := progress.left) is not None:
            parts.append(self.tr("for {0}").format(_duration(left)))
        # A truncated figure reads as another one: with little room there are fewer figures, or none.
        fewer = (" · ".join(parts[:count]) for count in range(len(parts) - 1, 0, -1))
        self.progressLabel.setTexts(" · ".join(parts), *fewer, "")

    @property
    def limits(self) -> RecordingLimits:
        """Return the limits at which a recording ends by itself."""
        limit, amount = _LIMITS[self.limitBox.currentIndex()], self.amountBox.value()
        if limit is None:
            return RecordingLimits()
        if limit.field == "seconds":
            return RecordingLimits(seconds=amount)
        return RecordingLimits(**{limit.field: round(amount * limit.scale)})

    def setPlayable(self, name: str) -> None:
        """Show the name of a finished recording."""
        self.playButton.setVisible(True)
        self._arrange()
        set_tooltip(self.playButton, self.tr("Play {0} in place of the camera").format(name))

    def _kind_text(self, kind: RecordingKind) -> str:
        return {
            RecordingKind.MCAP: self.tr("All raw data (MCAP)"),
            RecordingKind.BAG: self.tr("All raw data (ROS 2 bag)"),
            RecordingKind.H264: self.tr("Movie (MP4)"),
            RecordingKind.LOSSLESS: self.tr("Movie, lossless (MP4)"),
            RecordingKind.FFV1: self.tr("Movie, lossless up to 16 bits (FFV1)"),
            RecordingKind.PNG: self.tr("Images (PNG)"),
            RecordingKind.TIFF: self.tr("Images (TIFF, fast)"),
            RecordingKind.STACK: self.tr("One TIFF with pages"),
            RecordingKind.NUMPY: self.tr("NumPy array (.npy)"),
        }[kind]

    def _arrange(self) -> None:
        narrow, recording = self.width() < NARROW, self.recordButton.isChecked()
        self.folderButton.setVisible(not narrow and not recording)
        room = self.width() - self.minimumSizeHint().width()
        fits = not narrow or room >= _WHOLE_CHOICE - _LEAST_CHOICE
        self.limitBox.setMinimumWidth(_WHOLE_CHOICE if fits else _LEAST_CHOICE)
        # Beside the length of the next recording there is no room for the figures of the last one.
        self.progressLabel.setVisible(recording or (not narrow and self.amountBox.isHidden()))
        self.playButton.setMaximumWidth(self._play_width() if narrow else QWIDGETSIZE_MAX)
        self.playButton.setText("" if narrow else self.tr("Play"))

    def _height(self) -> int:
        layout = self.layout()
        assert layout is not None
        parts = (self.recordButton, self.kindBox, self.folderButton)
        for part in parts:
            part.ensurePolished()  # a hidden one has the height of another style until then
        margins = layout.contentsMargins()
        return margins.top() + max(part.sizeHint().height() for part in parts) + margins.bottom()

    def _spared(self) -> tuple[QWidget, ...]:
        """Return the parts that a narrow bar hides."""
        recording = self.recordButton.isChecked()
        return (self.folderButton,) if recording else (self.folderButton, self.progressLabel)

    def _play_width(self) -> int:
        return self.playButton.iconSize().width() + _ICON_ROOM

    def _on_record_clicked(self, checked: bool) -> None:
        # The button shows the state, not the request: the program sets it once it records.
        self.recordButton.setChecked(not checked)
        if checked:
            self.recordRequested.emit(self.kindBox.currentData(), self.limits)
        else:
            self.stopRequested.emit()

    def _on_limit_chosen(self, index: int) -> None:
        limit, amount = _LIMITS[index], self._amounts[index]
        self.amountBox.setVisible(limit is not None)
        self._arrange()
        if limit is not None and amount is not None:
            self.amountBox.setDecimals(limit.decimals)
            self.amountBox.setMinimum(10**-limit.decimals)
            self.amountBox.setSuffix(f" {limit.unit}" if limit.unit else "")
            self.amountBox.setValue(amount)

    def _on_amount_changed(self, amount: float) -> None:
        if self._amounts[self.limitBox.currentIndex()] is not None:
            self._amounts[self.limitBox.currentIndex()] = amount


def _duration(seconds: float) -> str:
    """Return a duration with one unit: seconds, minutes, hours or days."""
    for unit, size in (("d", 86400), ("h", 3600), ("min", 60)):
        if seconds >= 2 * size:
            return f"{seconds / size:.0f} {unit}"
    return f"{seconds:.0f} s"


def _bytes(count: int) -> str:
    return localized(f"{count / 1e9:.1f} GB") if count >= 1e9 else f"{count / 1e6:.0f} MB"


class PlaybackBar(QWidget):
    """Controls of a recording that is played; hidden while the source is no recording."""

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
        self._longest = ""
        for speed in SPEEDS:
            self.speedBox.addItem(_times(speed), speed)
        self.backButton.clicked.connect(lambda: self.stepRequested.emit(-1))
        self.forwardButton.clicked.connect(lambda: self.stepRequested.emit(1))
        self.playButton.clicked.connect(lambda: self.playRequested.emit(not self._playing))
        self.slider.valueChanged.connect(self.positionChosen)
        self.speedBox.activated[int].connect(self._on_speed_chosen)
        self.loopButton.clicked[bool].connect(self.loopRequested)
        self.hide()

    def setState(self, state: PlaybackState) -> None:
        """Show the state of the recording."""
        self._playing = state.playing
        self.playButton.setText(self.tr("Pause") if state.playing else self.tr("Play"))
        self.playButton.setAccessibleName(self.playButton.text())
        name = "pause" if state.playing else "start"
        if self.playButton.property("iconName") != name:
            self.playButton.setProperty("iconName", name)
            self.playButton.setIcon(icon(name, self.palette()))
        with QSignalBlocker(self.slider):
            self.slider.setRange(0, max(0, state.frames - 1))
            if not self.slider.isSliderDown():
                self.slider.setValue(state.position)
        self.slider.setPageStep(max(1, state.frames // 10))
        self._keep_width(_place(state.duration, state.duration, state.frames, state.frames))
        self.placeLabel.setText(_place(state.time, state.duration, state.position + 1, state.frames))
        self._show_speed(state.speed)
        self.loopButton.setChecked(state.loop)

    def _keep_width(self, longest: str) -> None:
        """Leave room for the longest text: with each digit more, the slider would jump under the mouse."""
        if longest != self._longest:
            self._longest = longest
            self.placeLabel.setText(longest)
            self.placeLabel.setMinimumWidth(self.placeLabel.sizeHint().width())

    def _on_speed_chosen(self, index: int) -> None:
        self.speedChosen.emit(self.speedBox.itemData(index))

    def _show_speed(self, speed: float) -> None:
        index = self.speedBox.findData(speed)
        if index < 0:  # set elsewhere, e.g. in the feature panel
            self.speedBox.addItem(_times(speed), speed)
            index = self.speedBox.count() - 1
        self.speedBox.setCurrentIndex(index)


def _place(time: float, duration: float, frame: int, frames: int) -> str:
    return f"{_clock(time)} / {_clock(duration)}   {frame} / {frames}"


def _times(speed: float) -> str:
    return localized(f"{speed:g} ×")


def _clock(seconds: float) -> str:
    minutes, rest = divmod(max(0.0, seconds), 60)
    return localized(f"{int(minutes):02d}:{rest:04.1f}")


class PauseBar(QWidget):
    """Steps through the last frames; hidden while the image is live."""

    frameChosen = pyqtSignal(int)
    """Index of the frame to show; 0 is the oldest."""
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
        """Show that frame `index` of `count` is shown, `age` seconds older than the newest."""
        with QSignalBlocker(self.slider):
            self.slider.setRange(0, max(0, count - 1))
            self.slider.setValue(index)
        self.placeLabel.setText(localized(self.tr("{0} of {1}   −{2:.2f} s").format(index + 1, count, age)))
