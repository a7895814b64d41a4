"""The panel of the change history: changes, their authors, and copying them as commands."""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtWidgets import QComboBox, QMenu, QPushButton, QTableView, QWidget

from grabbergui.models.changes.history import Change, Origin
from grabbergui.ui.loader import load_form
from grabbergui.ui.widgets.tables import ChangeTable

_WIDTHS = (76, 180, 90, 90, 80)
"""Of the columns at first."""
ROW_PADDING = 6
"""Pixels of a row above and below its text."""

_WHOSE = (frozenset(Origin), frozenset(Origin) - {Origin.CAMERA}, frozenset({Origin.OPERATOR}))
"""Whose changes are shown, as in the form's box."""


class CopyAs(Enum):
    """The forms in which changes can be copied."""

    COMMAND = "command"
    PROGRAM = "program"
    TABLE = "table"


class ChangesPanel(QWidget):
    """Setters for the changes; signals for the requested actions."""

    copyRequested = pyqtSignal(CopyAs)
    saveRequested = pyqtSignal()
    clearRequested = pyqtSignal()
    whoseChanged = pyqtSignal()
    """Other changes are to be shown: `setChanges` is to follow."""

    whoseBox: QComboBox
    copyButton: QPushButton
    saveButton: QPushButton
    clearButton: QPushButton
    table: QTableView

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("changes_panel", self)
        self._changes = ChangeTable(self)
        self.table.setModel(self._changes)
        self._follows = True
        "Whether new rows are followed: until somebody scrolls up."
        if (bar := self.table.verticalScrollBar()) is not None:
            bar.valueChanged.connect(self._on_bar_value_changed)
            bar.rangeChanged.connect(self._follow)
        if (rows := self.table.verticalHeader()) is not None:
            rows.setDefaultSectionSize(self.fontMetrics().height() + ROW_PADDING)
        if (header := self.table.horizontalHeader()) is not None:
            left = Qt.Alignment(Qt.AlignmentFlag.AlignLeft)
            header.setDefaultAlignment(left | Qt.AlignmentFlag.AlignVCenter)
        for column, width in enumerate(_WIDTHS):
            self.table.setColumnWidth(column, width)
        self.copyMenu = QMenu(self)
        for kind, title in (
            (CopyAs.COMMAND, self.tr("&Command line")),
            (CopyAs.PROGRAM, self.tr("&Python program")),
            (CopyAs.TABLE, self.tr("&Table")),
        ):
            action = self.copyMenu.addAction(title)
            assert action is not None
            action.triggered.connect(lambda _, kind=kind: self.copyRequested.emit(kind))
        self.copyButton.setMenu(self.copyMenu)
        self.whoseBox.currentIndexChanged[int].connect(lambda _: self.whoseChanged.emit())
        self.saveButton.clicked.connect(self.saveRequested)
        self.clearButton.clicked.connect(self.clearRequested)
        self._changes.rowsInserted.connect(self._enable)
        self._changes.modelReset.connect(self._enable)
        self._enable()

    def setChanges(self, changes: Sequence[Change]) -> None:
        """Show these changes, as far as they are wanted."""
        self._changes.setChanges([change for change in changes if self._wanted(change)])
        self._follows = True
        self._follow()

    def noteChange(self, change: Change) -> None:
        """Show one more, or one that went on; follow them unless somebody scrolled up."""
        if not self._wanted(change):
            return
        self._changes.note(change)
        self._follow()

    @property
    def chosen(self) -> tuple[Change, ...]:
        """The changes selected; with none selected, all that are shown."""
        selection = self.table.selectionModel()
        rows = sorted(index.row() for index in selection.selectedRows()) if selection is not None else []
        return tuple(self._changes.change(row) for row in rows) or self._changes.changes

    def tableText(self, changes: Sequence[Change], separator: str = "\t") -> str:
        """Changes as lines of text, with the columns' titles."""
        lines = [self._changes.titles, *(self._changes.texts(change) for change in changes)]
        return "".join(f"{separator.join(line)}\n" for line in lines)

    def _wanted(self, change: Change) -> bool:
        return change.origin in _WHOSE[self.whoseBox.currentIndex()]

    def _on_bar_value_changed(self, value: int) -> None:
        bar = self.table.verticalScrollBar()
        self._follows = bar is None or value == bar.maximum()

    def _follow(self) -> None:
        """Also once the panel comes to the front, or is made higher: it has no place for rows before."""
        if self._follows:
            self.table.scrollToBottom()

    def _enable(self) -> None:
        anything = self._changes.rowCount() > 0
        for button in (self.copyButton, self.saveButton, self.clearButton):
            button.setEnabled(anything)
