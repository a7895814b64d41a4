"""The dialog with the data of the shown frame."""

from __future__ import annotations

from collections.abc import Sequence

from PyQt5.QtCore import pyqtSignal
from PyQt5.QtWidgets import QDialog, QLabel, QPushButton, QTreeWidget, QWidget

from grabbergui.models.language import translate
from grabbergui.ui.form_loader import load_form
from grabbergui.ui.screen import fit_screen
from grabbergui.ui.widgets.columns import size_columns
from grabbergui.ui.widgets.table_rows import fill_rows


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
        size_columns(self.table, (translate("FrameData", "Exposed or received at") + " ",))
        self.copyButton.clicked.connect(self.copyRequested)
        self.closeButton.clicked.connect(self.reject)
        fit_screen(self)

    def setRows(self, rows: Sequence[tuple[str, str]], *, chunks: bool) -> None:
        """Show names and values; with `chunks` there is chunk data among them."""
        fill_rows(self.table, rows)
        self.hintLabel.setVisible(not chunks)
