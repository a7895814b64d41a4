"""The dialog with the data of the shown frame."""

from __future__ import annotations

from collections.abc import Sequence

from PyQt5.QtCore import pyqtSignal
from PyQt5.QtWidgets import QDialog, QLabel, QPushButton, QTreeWidget, QTreeWidgetItem, QWidget

from grabbergui.ui.form_loader import load_form
from grabbergui.ui.screen import fit_screen
from grabbergui.ui.shown_text import set_cell_tooltip
from grabbergui.ui.widgets.columns import size_columns


class FrameDataDialog(QDialog):
    """A setter for the rows; they keep their places while their values change."""

    copyRequested = pyqtSignal()

    table: QTreeWidget
    hintLabel: QLabel
    copyButton: QPushButton
    closeButton: QPushButton

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("frame_data", self)
        size_columns(self.table, ("Exposed or received at ",))
        self.copyButton.clicked.connect(self.copyRequested)
        self.closeButton.clicked.connect(self.reject)
        fit_screen(self)

    def setRows(self, rows: Sequence[tuple[str, str]], *, chunks: bool) -> None:
        """Show names and values; with `chunks` there is chunk data among them."""
        while self.table.topLevelItemCount() > len(rows):
            self.table.takeTopLevelItem(self.table.topLevelItemCount() - 1)
        while self.table.topLevelItemCount() < len(rows):
            QTreeWidgetItem(self.table)
        for row, texts in enumerate(rows):
            item = self.table.topLevelItem(row)
            assert item is not None
            for column, text in enumerate(texts):
                if item.text(column) != text:
                    item.setText(column, text)
                    set_cell_tooltip(item, column, text)
        self.hintLabel.setVisible(not chunks)
