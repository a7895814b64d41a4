"""The dialog of the camera's look-up table."""

from __future__ import annotations

from collections.abc import Callable

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
    QMessageBox,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from grabbergui.core.lookup_table import LEAST_GAMMA, MOST_GAMMA
from grabbergui.models.markup import markup
from grabbergui.models.unavailable import Unavailable
from grabbergui.ui.actions import set_available
from grabbergui.ui.dialog_style import dress_dialog
from grabbergui.ui.shown_text import PlainLabel, question_box, set_rich, set_tooltip
from grabbergui.ui.widgets.plots import ChannelPlot

_MOST_POINTS = 2048
"Most points of a curve that are drawn; no screen shows more."
_EDITED = "#3e7bfa"
"Colour of the edited curve."


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
        self.unsaved: Callable[[], bool] = lambda: False
        """Returns whether edits would be lost; the user is asked before that."""
        self.question: QMessageBox | None = None
        """The question whether to discard edits, while it is open."""
        self._selector = ""
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(self.tr("Look-up table"))
        self.resize(560, 480)
        self.selectorLabel = PlainLabel(self.tr("&Table"))
        self.selectorBox = QComboBox()
        self.selectorLabel.setBuddy(self.selectorBox)
        self.enableBox = QCheckBox(self.tr("The camera &uses it"))
        self.plot = ChannelPlot()
        self.plot.setAccessibleName(self.tr("Curve of the look-up table"))
        set_tooltip(
            self.plot, self.tr("Horizontal: value of the sensor; vertical: value that is sent instead")
        )
        self.plot.nameAxes(self.tr("Input (LUTIndex)"), self.tr("Output (LUTValue)"))
        present, edited = self.tr("in the camera"), self.tr("edited")
        self.legendLabel = PlainLabel()
        legend = markup('━ {0} &nbsp; <span style="color: {1}">━</span> {2}', present, _EDITED, edited)
        set_rich(self.legendLabel, legend)
        self.gammaBox = QDoubleSpinBox()
        self.gammaBox.setRange(0, MOST_GAMMA)
        self.gammaBox.setSpecialValueText("–")
        self.gammaBox.setSingleStep(0.05)
        self.gammaBox.setAccessibleName(self.tr("Gamma"))
        set_tooltip(self.gammaBox, self.tr("Below 1, dark parts become brighter; above 1, darker"))
        gamma_label = PlainLabel(self.tr("&Gamma"))
        gamma_label.setBuddy(self.gammaBox)
        self.linearButton = QPushButton(self.tr("Li&near"))
        self.loadButton = QPushButton(self.tr("L&oad…"))
        self.saveButton = QPushButton(self.tr("&Save…"))
        self.stateLabel = PlainLabel()
        self.stateLabel.setWordWrap(True)
        self.undoButton = QPushButton(self.tr("Un&do"))
        set_tooltip(self.undoButton, self.tr("Write back the camera's previous table"))
        self.writeButton = QPushButton(self.tr("&Write to the camera"))
        self.closeButton = QPushButton(self.tr("&Close"))
        self._lay_out(gamma_label)
        self._join()

    def setSelectors(self, names: tuple[str, ...]) -> None:
        """Offer these tables; the choice is hidden if there is only one."""
        with QSignalBlocker(self.selectorBox):
            self.selectorBox.clear()
            self.selectorBox.addItems(names)
        self._selector = self.selectorBox.currentText()
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
        set_available(self.writeButton, None if changed else Unavailable.EDIT)
        size = self.tr("{0} entries").format(len(present))
        state = self.tr("not written yet") if changed else self.tr("as in the camera")
        self.stateLabel.setText(f"{size} · {state}")

    def showProblem(self, text: str) -> None:
        """Show why a file was not loaded, until the next table is shown."""
        self.stateLabel.setText(text)

    def setUndoable(self, undoable: bool) -> None:
        """Enable the undo of the last write."""
        set_available(self.undoButton, None if undoable else Unavailable.EDIT)

    def setGamma(self, gamma: float | None) -> None:
        """Show the exponent of a gamma curve; None for any other curve."""
        with QSignalBlocker(self.gammaBox):
            self.gammaBox.setValue(gamma or 0.0)

    def reject(self) -> None:
        """Close the window; called by Qt for Esc and the window's own button, too."""
        self._ask_to_discard(super().reject)

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
        dress_dialog(self, self.writeButton)

    def _join(self) -> None:
        for button in self.findChildren(QPushButton):
            button.setAutoDefault(False)  # Enter in the field must not press one
        self.selectorBox.currentTextChanged.connect(self._on_selector_chosen)
        self.enableBox.toggled.connect(self.enableToggled)
        self.gammaBox.valueChanged.connect(self._on_gamma_changed)
        self.gammaBox.editingFinished.connect(self._on_gamma_entered)
        self.linearButton.clicked.connect(lambda: self.linearRequested.emit())
        self.loadButton.clicked.connect(lambda: self.loadRequested.emit())
        self.saveButton.clicked.connect(lambda: self.saveRequested.emit())
        self.writeButton.clicked.connect(lambda: self.writeRequested.emit())
        self.undoButton.clicked.connect(lambda: self.undoRequested.emit())
        self.closeButton.clicked.connect(self.reject)

    def _on_gamma_changed(self, gamma: float) -> None:
        if gamma >= LEAST_GAMMA:
            self.gammaChosen.emit(gamma)

    def _on_gamma_entered(self) -> None:
        if 0 < self.gammaBox.value() < LEAST_GAMMA:
            self.gammaBox.setValue(LEAST_GAMMA)

    def _on_selector_chosen(self, name: str) -> None:
        def discarded() -> None:
            self._selector = name
            self.selectorChosen.emit(name)

        def kept() -> None:
            with QSignalBlocker(self.selectorBox):
                self.selectorBox.setCurrentText(self._selector)

        self._ask_to_discard(discarded, kept)

    def _ask_to_discard(self, discarded: Callable[[], None], kept: Callable[[], None] = lambda: None) -> None:
        """Call `discarded` if no edits would be lost or the user agrees to that, otherwise `kept`."""
        if not self.unsaved():
            discarded()
            return
        if self.question is not None:
            return
        self.question = box = question_box(
            self,
            self.tr("Discard the edited table?"),
            self.tr("It is neither in the camera nor saved in a file."),
        )
        box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        discard = box.addButton(self.tr("&Discard"), QMessageBox.ButtonRole.DestructiveRole)
        box.setDefaultButton(box.addButton(QMessageBox.StandardButton.Cancel))

        def finished(_: int) -> None:
            self.question = None
            (discarded if box.clickedButton() is discard else kept)()

        box.finished.connect(finished)
        box.open()
