"""The dialog with the events of the camera."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from PyQt5.QtCore import QSignalBlocker, Qt, pyqtSignal
from PyQt5.QtWidgets import QDialog, QListWidget, QListWidgetItem, QPushButton, QTreeWidget, QWidget

from grabbergui.ui.form_loader import load_form
from grabbergui.ui.screen import fit_screen
from grabbergui.ui.widgets.columns import size_columns
from grabbergui.ui.widgets.table_rows import fill_rows


class CameraEventsDialog(QDialog):
    """Setters for the switches and the events; signals for what the user does."""

    switched = pyqtSignal(str, bool)
    """Report an event of this name, or no more."""
    clearRequested = pyqtSignal()
    copyRequested = pyqtSignal()

    switchList: QListWidget
    table: QTreeWidget
    clearButton: QPushButton
    copyButton: QPushButton
    closeButton: QPushButton

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("camera_events", self)
        size_columns(self.table, ("00:00:00.000", "FrameTriggerMissed "))
        self.switchList.itemChanged.connect(self._on_item_changed)
        self.clearButton.clicked.connect(self.clearRequested)
        self.copyButton.clicked.connect(self.copyRequested)
        self.closeButton.clicked.connect(self.reject)
        fit_screen(self)

    def setSwitches(self, switches: Mapping[str, bool]) -> None:
        """Show which events there are, and which are on."""
        with QSignalBlocker(self.switchList):
            if [item.text() for item in self._items()] != list(switches):
                self.switchList.clear()
                self.switchList.addItems(switches)
            for item in self._items():
                on = switches[item.text()]
                item.setCheckState(Qt.CheckState.Checked if on else Qt.CheckState.Unchecked)

    def setRows(self, rows: Sequence[Sequence[str]]) -> None:
        """Show events: time, name, values."""
        fill_rows(self.table, rows)

    def _items(self) -> list[QListWidgetItem]:
        items = (self.switchList.item(row) for row in range(self.switchList.count()))
        return [item for item in items if item is not None]

    def _on_item_changed(self, item: QListWidgetItem) -> None:
        self.switched.emit(item.text(), item.checkState() == Qt.CheckState.Checked)
