"""What to do about a camera that is not calibrated."""

from __future__ import annotations

from PyQt5.QtCore import pyqtSignal
from PyQt5.QtWidgets import QCommandLinkButton, QDialog, QDoubleSpinBox, QLabel, QPushButton, QWidget

from grabbergui.core.calibration import NOMINAL_FIELD_OF_VIEW
from grabbergui.ui import icons
from grabbergui.ui.loader import load_form


class CalibrationChoiceDialog(QDialog):
    """Setters and signals; it stays open until it is accepted by whoever did what was asked."""

    calibrateRequested = pyqtSignal()
    fileRequested = pyqtSignal()
    nominalRequested = pyqtSignal(float)
    """Degrees that the picture's width is to be taken for."""

    titleLabel: QLabel
    calibrateButton: QCommandLinkButton
    fileButton: QCommandLinkButton
    nominalButton: QCommandLinkButton
    degreesBox: QDoubleSpinBox
    problemLabel: QLabel
    cancelButton: QPushButton

    def __init__(self, camera: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("calibration_choice", self)
        self.titleLabel.setText(self.tr("{0} is not calibrated").format(camera))
        self.degreesBox.setValue(NOMINAL_FIELD_OF_VIEW)
        self.setProblem("")
        icons.apply(self)
        self.calibrateButton.clicked.connect(lambda: self.calibrateRequested.emit())
        self.fileButton.clicked.connect(lambda: self.fileRequested.emit())
        self.nominalButton.clicked.connect(lambda: self.nominalRequested.emit(self.degreesBox.value()))
        self.cancelButton.clicked.connect(self.reject)

    def setProblem(self, text: str) -> None:
        """Say why what was chosen does not do; empty: nothing is wrong."""
        self.problemLabel.setText(text)
        self.problemLabel.setVisible(bool(text))
