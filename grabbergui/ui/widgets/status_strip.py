"""The status bar's content: state, picture, rates, losses."""

from __future__ import annotations

from enum import Enum

from PyQt5.QtWidgets import QLabel, QWidget

from grabbergui.ui.loader import load_form


class StateTone(Enum):
    """How the state is coloured."""

    IDLE = "idle"
    BUSY = "busy"
    GOOD = "good"
    BAD = "bad"


class StatusStrip(QWidget):
    """Setters only."""

    stateLabel: QLabel
    messageLabel: QLabel
    formatLabel: QLabel
    rateLabel: QLabel
    bandwidthLabel: QLabel
    lossLabel: QLabel

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("status_strip", self)
        self.setState(self.tr("Not connected"), StateTone.IDLE)

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
        self.formatLabel.setText(text)

    def setRates(self, camera: float, painted: float) -> None:
        """Frames per second from the camera, and pictures painted."""
        self.rateLabel.setText(self.tr("{0:.1f} fps · {1:.0f} painted").format(camera, painted))

    def setBandwidth(self, bytes_per_second: float) -> None:
        """Payload per second."""
        self.bandwidthLabel.setText(f"{bytes_per_second / 1e6:.1f} MB/s")

    def setLosses(self, lost: int, incomplete: int) -> None:
        """Frames lost and incomplete since the start."""
        self.lossLabel.setText(self.tr("{0} lost · {1} incomplete").format(lost, incomplete))

    def clearFigures(self) -> None:
        """Nothing streams."""
        for label in (self.formatLabel, self.rateLabel, self.bandwidthLabel, self.lossLabel):
            label.clear()
