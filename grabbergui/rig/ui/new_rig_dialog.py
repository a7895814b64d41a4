"""*Camera → New rig…*: the cameras of a rig, their names, and what triggers them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtWidgets import (
    QComboBox,
    QDialog,
    QDoubleSpinBox,
    QLabel,
    QLineEdit,
    QPushButton,
    QTreeWidget,
    QTreeWidgetItem,
    QWidget,
)

from grabbergui.core.errors import UsageError
from grabbergui.models.language import driver_text
from grabbergui.rig import rig_file
from grabbergui.rig.rig_file import TRIGGERS, RigEntry, TriggerEntry
from grabbergui.ui.form_loader import load_form
from grabbergui.ui.screen import fit_screen
from grabbergui.ui.shown_text import set_cell_tooltip
from grabbergui.ui.widgets.columns import size_columns

FORM = Path(__file__).with_name("forms") / "new_rig.ui"
LONG_NAME = "☑ camera12 in the middle"
"A name with its box, for the width of the column."
FEWEST_NAMES = ("left", "right")
"Names of the cameras of a pair; those of more are numbered."


class NewRigDialog(QDialog):
    """Setters, and a signal."""

    saveRequested = pyqtSignal(object)
    """The `RigEntry` that was described; the dialog stays until `accept`."""

    introLabel: QLabel
    cameraTable: QTreeWidget
    sourceEdit: QLineEdit
    addButton: QPushButton
    triggerBox: QComboBox
    rateLabel: QLabel
    rateBox: QDoubleSpinBox
    leaderLabel: QLabel
    leaderBox: QComboBox
    problemLabel: QLabel
    saveButton: QPushButton
    closeButton: QPushButton

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form(FORM, self)
        self.problemLabel.hide()
        size_columns(self.cameraTable, (LONG_NAME,))
        self.addButton.clicked.connect(self._on_add_clicked)
        self.sourceEdit.returnPressed.connect(self._on_add_clicked)
        self.triggerBox.currentIndexChanged.connect(self._arrange)
        self.cameraTable.itemChanged.connect(self._arrange)
        self.saveButton.clicked.connect(self._on_save_clicked)
        self.closeButton.clicked.connect(self.reject)
        self._arrange()
        fit_screen(self)

    def setSources(self, cameras: Sequence[tuple[str, str, bool]]) -> None:
        """Offer cameras: URI, title, and whether it is part of the rig to begin with."""
        self.cameraTable.clear()
        chosen = sum(each[2] for each in cameras)
        names = FEWEST_NAMES if chosen == len(FEWEST_NAMES) else ()
        for uri, title, part in sorted(cameras, key=lambda each: not each[2]):
            row = self.cameraTable.topLevelItemCount()
            self.addCamera(names[row] if row < len(names) else f"camera{row + 1}", uri, title, part=part)

    def addCamera(self, name: str, uri: str, title: str = "", *, part: bool = True) -> None:
        """Add a line."""
        item = QTreeWidgetItem([name, uri])
        item.setFlags(item.flags() | Qt.ItemFlag.ItemIsEditable | Qt.ItemFlag.ItemIsUserCheckable)
        item.setCheckState(0, Qt.CheckState.Checked if part else Qt.CheckState.Unchecked)
        set_cell_tooltip(item, 1, title or uri)
        self.cameraTable.addTopLevelItem(item)

    def setProblem(self, text: str) -> None:
        """Show why the rig cannot be made; empty: nothing."""
        self.problemLabel.setText(text[:1].upper() + text[1:])
        self.problemLabel.setVisible(bool(text))

    @property
    def cameras(self) -> list[tuple[str, str]]:
        """Name and URI of the cameras that are ticked."""
        return [
            (item.text(0).strip(), item.text(1).strip())
            for item in self._items()
            if item.checkState(0) == Qt.CheckState.Checked
        ]

    def entry(self) -> RigEntry:
        """Return the rig that is described. Raises UsageError."""
        cameras = self.cameras
        if len(dict(cameras)) < len(cameras):
            raise UsageError(self.tr("two cameras have one name; name each by a double click"))
        by = TRIGGERS[self.triggerBox.currentIndex()]
        leader = self.leaderBox.currentText() if by == "line" and self.leaderBox.currentIndex() > 0 else ""
        rate = self.rateBox.value() if by != "free" else 0.0
        return rig_file.of_sources(dict(cameras), trigger=TriggerEntry(by, rate, leader=leader))

    def _items(self) -> list[QTreeWidgetItem]:
        items = (self.cameraTable.topLevelItem(row) for row in range(self.cameraTable.topLevelItemCount()))
        return [item for item in items if item is not None]

    def _arrange(self) -> None:
        by = TRIGGERS[self.triggerBox.currentIndex()]
        for widget in (self.rateLabel, self.rateBox):
            widget.setVisible(by != "free")
        for widget in (self.leaderLabel, self.leaderBox):
            widget.setVisible(by == "line")
        leader = self.leaderBox.currentText()
        self.leaderBox.clear()
        self.leaderBox.addItem(self.tr("None: a signal from elsewhere"))
        self.leaderBox.addItems([name for name, _ in self.cameras])
        self.leaderBox.setCurrentIndex(max(0, self.leaderBox.findText(leader)))

    def _on_add_clicked(self) -> None:
        if uri := self.sourceEdit.text().strip():
            self.addCamera(f"camera{self.cameraTable.topLevelItemCount() + 1}", uri)
            self.sourceEdit.clear()

    def _on_save_clicked(self) -> None:
        try:
            entry = self.entry()
        except UsageError as error:
            self.setProblem(driver_text(error))
            return
        self.setProblem("")
        self.saveRequested.emit(entry)
