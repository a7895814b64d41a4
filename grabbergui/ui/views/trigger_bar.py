"""The bar of the trigger, below the image while one is on."""

from __future__ import annotations

from PyQt5.QtCore import QSignalBlocker, pyqtSignal
from PyQt5.QtWidgets import QCheckBox, QLabel, QPushButton, QSpinBox, QWidget

from grabbergui.models.triggers import TriggerState
from grabbergui.ui.form_loader import load_form
from grabbergui.ui.widgets.labels import ElidedLabel, ShrinkingLabel


class TriggerBar(QWidget):
    """Setters in, signals out; hidden while no trigger is on."""

    sendRequested = pyqtSignal()
    repeatRequested = pyqtSignal(float)
    """Send a trigger every so many seconds; 0: no more."""
    offRequested = pyqtSignal()

    stateLabel: ShrinkingLabel
    countsLabel: ElidedLabel
    problemLabel: QLabel
    sendButton: QPushButton
    repeatBox: QCheckBox
    periodBox: QSpinBox
    offButton: QPushButton

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("trigger_bar", self)
        self.sendButton.clicked.connect(self.sendRequested)
        self.offButton.clicked.connect(self.offRequested)
        self.repeatBox.toggled.connect(self._on_repeat_changed)
        self.periodBox.valueChanged[int].connect(self._on_repeat_changed)
        self.hide()

    def setState(self, state: TriggerState | None) -> None:
        """Show a trigger; None hides the bar."""
        if state is not None:
            self.stateLabel.setText(state.text)
            self.countsLabel.setText(state.counts)
            self.problemLabel.setText(state.problem)
            self.problemLabel.setVisible(bool(state.problem))
            for control in (self.sendButton, self.repeatBox, self.periodBox):
                control.setVisible(state.sendable)
            self.offButton.setVisible(state.switchable)
            with QSignalBlocker(self.repeatBox):
                self.repeatBox.setChecked(state.repeating)
        self.setVisible(state is not None)

    def _on_repeat_changed(self) -> None:
        if self.sender() is self.periodBox and not self.repeatBox.isChecked():
            return
        self.repeatRequested.emit(self.periodBox.value() / 1000 if self.repeatBox.isChecked() else 0.0)
