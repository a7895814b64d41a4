"""The status bar's content: state, picture, rates, losses."""

from __future__ import annotations

from enum import Enum

from PyQt5.QtCore import QSize
from PyQt5.QtGui import QResizeEvent
from PyQt5.QtWidgets import QLabel, QWidget

from grabbergui.ui.loader import load_form
from grabbergui.ui.widgets.elided_label import ElidedLabel


class StateTone(Enum):
    """How the state is coloured."""

    IDLE = "idle"
    BUSY = "busy"
    GOOD = "good"
    BAD = "bad"


LEAST_MESSAGE = 60
"Pixels kept for the message before figures make way for it."


class StatusStrip(QWidget):
    """Setters only. Figures keep their places while they change; the least make way for lack of room."""

    stateLabel: QLabel
    messageLabel: ElidedLabel
    formatLabel: QLabel
    rateLabel: QLabel
    bandwidthLabel: QLabel
    lossLabel: QLabel

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("status_strip", self)
        self._figures = (self.lossLabel, self.rateLabel, self.formatLabel, self.bandwidthLabel)
        "The most important first."
        self.setState(self.tr("Not connected"), StateTone.IDLE)

    def minimumSizeHint(self) -> QSize:
        """The state alone."""
        return QSize(self.stateLabel.sizeHint().width(), super().minimumSizeHint().height())

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Show as many figures as there is room for."""
        super().resizeEvent(event)
        self._fit()

    def setState(self, text: str, tone: StateTone) -> None:
        """Where the connection stands."""
        self.stateLabel.setText(f"● {text}")
        if self.stateLabel.property("tone") != tone.value:
            self.stateLabel.setProperty("tone", tone.value)
            # A style sheet looks at properties only when a widget is polished.
            if (style := self.stateLabel.style()) is not None:
                style.unpolish(self.stateLabel)
                style.polish(self.stateLabel)

    def setMessage(self, text: str) -> None:
        """What is open, or a word in passing."""
        self.messageLabel.setText(text)

    def setFormat(self, text: str) -> None:
        """Resolution and pixel format."""
        self._show(self.formatLabel, text)

    def setRates(self, camera: float, painted: float) -> None:
        """Frames per second from the camera, and pictures painted."""
        self._show(self.rateLabel, self.tr("{0:.1f} fps · {1:.0f} shown").format(camera, painted))

    def setBandwidth(self, bytes_per_second: float) -> None:
        """Payload per second."""
        self._show(self.bandwidthLabel, f"{bytes_per_second / 1e6:.1f} MB/s")

    def setLosses(self, lost: int, incomplete: int) -> None:
        """Frames lost and incomplete since the start."""
        self._show(self.lossLabel, self.tr("{0} lost · {1} incomplete").format(lost, incomplete))

    def clearFigures(self) -> None:
        """Nothing streams."""
        for label in self._figures:
            label.clear()
            label.setMinimumWidth(0)

    def _show(self, label: QLabel, text: str) -> None:
        """Never narrower than before, so that one more digit does not push its neighbours to and fro."""
        if text != label.text():
            label.setText(text)
            label.setMinimumWidth(max(label.minimumWidth(), label.sizeHint().width()))
            self._fit()

    def _fit(self) -> None:
        layout = self.layout()
        gap = layout.spacing() if layout is not None else 0
        room = self.width() - self.stateLabel.sizeHint().width() - LEAST_MESSAGE
        for label in self._figures:
            room -= label.sizeHint().width() + gap
            label.setVisible(room >= 0)
