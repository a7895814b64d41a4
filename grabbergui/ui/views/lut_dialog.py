"""The window of the look-up table: the camera's curve and the edited one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PyQt5.QtCore import QSignalBlocker, Qt, pyqtSignal
from PyQt5.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDialog,
    QDoubleSpinBox,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from grabbergui.ui.widgets.plots import ChannelPlot

_MOST_POINTS = 2048
"Most points of a curve that are drawn; no screen shows more."
_EDITED = "#3e7bfa"


class LutDialog(QDialog):
    """Shows tables; signals for the requested actions. Setters never emit."""

    selectorChosen = pyqtSignal(str)
    enableToggled = pyqtSignal(bool)
    gammaChosen = pyqtSignal(float)
    linearRequested = pyqtSignal()
    loadRequested = pyqtSignal()
    saveRequested = pyqtSignal()
    writeRequested = pyqtSignal()
    undoRequested = pyqtSignal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(self.tr("Look-up table"))
        self.resize(560, 480)
        self.selectorLabel = QLabel(self.tr("&Table"))
        self.selectorBox = QComboBox()
        self.selectorLabel.setBuddy(self.selectorBox)
        self.enableBox = QCheckBox(self.tr("The camera &uses it"))
        self.plot = ChannelPlot()
        self.plot.setAccessibleName(self.tr("Curve of the look-up table"))
        self.plot.setToolTip(self.tr("Horizontal: value of the sensor; vertical: value that is sent instead"))
        self.plot.nameAxes(self.tr("Input (LUTIndex)"), self.tr("Output (LUTValue)"))
        present, edited = self.tr("in the camera"), self.tr("edited")
        self.legendLabel = QLabel(f'━ {present} &nbsp; <span style="color: {_EDITED}">━</span> {edited}')
        self.gammaBox = QDoubleSpinBox()
        self.gammaBox.setRange(0.05, 20)
        self.gammaBox.setSingleStep(0.05)
        self.gammaBox.setValue(1.0)
        self.gammaBox.setAccessibleName(self.tr("Gamma"))
        self.gammaBox.setToolTip(self.tr("Below 1, dark parts become brighter; above 1, darker"))
        gamma_label = QLabel(self.tr("&Gamma"))
        gamma_label.setBuddy(self.gammaBox)
        self.linearButton = QPushButton(self.tr("Li&near"))
        self.loadButton = QPushButton(self.tr("L&oad…"))
        self.saveButton = QPushButton(self.tr("&Save…"))
        self.stateLabel = QLabel()
        self.stateLabel.setWordWrap(True)
        self.undoButton = QPushButton(self.tr("Un&do"))
        self.undoButton.setToolTip(self.tr("Write back the camera's previous table"))
        self.writeButton = QPushButton(self.tr("&Write to the camera"))
        self.closeButton = QPushButton(self.tr("&Close"))
        self._lay_out(gamma_label)
        self._join()

    def setSelectors(self, names: tuple[str, ...]) -> None:
        """Offer these tables; the choice is hidden if there is only one."""
        with QSignalBlocker(self.selectorBox):
            self.selectorBox.clear()
            self.selectorBox.addItems(names)
        self.selectorBox.setVisible(len(names) > 1)
        self.selectorLabel.setVisible(len(names) > 1)

    def setEnabledInCamera(self, used: bool | None) -> None:
        """Show whether the camera uses the table; None if it has no switch for that."""
        self.enableBox.setVisible(used is not None)
        with QSignalBlocker(self.enableBox):
            self.enableBox.setChecked(bool(used))

    def setTables(self, present: NDArray[np.int64], edited: NDArray[np.int64]) -> None:
        """Show the camera's table, and the edited one over it."""
        places = np.unique(np.linspace(0, len(present) - 1, _MOST_POINTS).astype(int))
        self.plot.setLine("present", places, present[places], "")
        self.plot.setLine("edited", places, edited[places], _EDITED)
        changed = not np.array_equal(present, edited)
        self.writeButton.setEnabled(changed)
        size = self.tr("{0} entries").format(len(present))
        state = self.tr("not written yet") if changed else self.tr("as the camera has it")
        self.stateLabel.setText(f"{size} · {state}")

    def setUndoable(self, undoable: bool) -> None:
        """Enable the undo of the last write."""
        self.undoButton.setEnabled(undoable)

    def setGamma(self, gamma: float) -> None:
        """Show the exponent of a gamma curve."""
        with QSignalBlocker(self.gammaBox):
            self.gammaBox.setValue(gamma)

    def _lay_out(self, gamma_label: QLabel) -> None:
        def line(*widgets: QWidget | None) -> QHBoxLayout:
            row = QHBoxLayout()
            for widget in widgets:
                row.addStretch(1) if widget is None else row.addWidget(widget)
            return row

        column = QVBoxLayout(self)
        column.addLayout(line(self.selectorLabel, self.selectorBox, self.enableBox, None, self.legendLabel))
        column.addWidget(self.plot, 1)
        column.addWidget(self.stateLabel)
        column.addLayout(
            line(gamma_label, self.gammaBox, self.linearButton, None, self.loadButton, self.saveButton)
        )
        column.addLayout(line(self.undoButton, None, self.writeButton, self.closeButton))

    def _join(self) -> None:
        for button in self.findChildren(QPushButton):
            button.setAutoDefault(False)  # Enter in the field must not press one
        self.selectorBox.currentTextChanged.connect(self.selectorChosen)
        self.enableBox.toggled.connect(self.enableToggled)
        self.gammaBox.valueChanged.connect(self.gammaChosen)
        self.linearButton.clicked.connect(lambda: self.linearRequested.emit())
        self.loadButton.clicked.connect(lambda: self.loadRequested.emit())
        self.saveButton.clicked.connect(lambda: self.saveRequested.emit())
        self.writeButton.clicked.connect(lambda: self.writeRequested.emit())
        self.undoButton.clicked.connect(lambda: self.undoRequested.emit())
        self.closeButton.clicked.connect(self.reject)
