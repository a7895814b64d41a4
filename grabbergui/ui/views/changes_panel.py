"""The panel of the change history: changes, their authors, and copying them as commands."""

from __future__ import annotations

import time
from collections.abc import Sequence
from enum import Enum

from PyQt5.QtCore import QAbstractTableModel, QModelIndex, QObject, Qt, pyqtSignal
from PyQt5.QtGui import QResizeEvent
from PyQt5.QtWidgets import (
    QBoxLayout,
    QComboBox,
    QHeaderView,
    QMenu,
    QPushButton,
    QTableView,
    QWidget,
)

from grabbergui.core.features import format_value
from grabbergui.models.change import Change, Origin
from grabbergui.models.change_journal import MOST_CHANGES
from grabbergui.models.features.number_text import number_text
from grabbergui.models.language import localized
from grabbergui.models.unavailable import Unavailable
from grabbergui.ui.actions import set_available
from grabbergui.ui.form_loader import load_form
from grabbergui.ui.widgets.columns import size_columns

_LONGEST = ("00:00:00", "AcquisitionFrameRate", "1000000.5", "1000000.5", "operator")
"""Texts as wide as the columns are at first; the last column takes the rest."""
NARROW = 450
"Width of the panel below which some columns are hidden."
ROW_PADDING = 6
"""Pixels of a row above and below its text."""

_WHOSE = (frozenset(Origin), frozenset(Origin) - {Origin.CAMERA}, frozenset({Origin.OPERATOR}))
"""Origins of the changes shown, in the order of the form's `whoseBox`."""


_ROOT = QModelIndex()
SOME = 200
"""Rows removed at once when there are too many."""


class ChangeTable(QAbstractTableModel):
    """One row per change, the oldest first; a change that continues keeps its row."""

    TIME, FEATURE, BEFORE, AFTER, BY, CAUSE = range(6)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.titles = (
            self.tr("Time"),
            self.tr("Feature"),
            self.tr("Before"),
            self.tr("After"),
            self.tr("By"),
            self.tr("Part of"),
        )
        "Titles of the columns."
        self._who = {
            Origin.OPERATOR: self.tr("operator"),
            Origin.CAMERA: self.tr("camera"),
            Origin.NETWORK: self.tr("network"),
        }
        self._changes: list[Change] = []
        self._rows: dict[int, int] = {}
        "Number of a change to its row."

    @property
    def changes(self) -> tuple[Change, ...]:
        """All changes, the oldest first."""
        return tuple(self._changes)

    def change(self, row: int) -> Change:
        """Return the change in a row."""
        return self._changes[row]

    def setChanges(self, changes: Sequence[Change]) -> None:
        """Replace all rows."""
        self.beginResetModel()
        self._changes = list(changes)
        self._rows = {change.number: row for row, change in enumerate(self._changes)}
        self.endResetModel()

    def note(self, change: Change) -> None:
        """Add a change, update one that continues, or remove one without effect; the oldest are removed."""
        row = self._rows.get(change.number)
        if not change.effective:
            if row is not None:
                self._forget(row, 1)
        elif row is not None:
            self._changes[row] = change
            self.dataChanged.emit(self.index(row, 0), self.index(row, self.CAUSE))
        else:
            self._append(change)

    def texts(self, change: Change) -> tuple[str, ...]:
        """Return the texts of a change's columns."""
        seconds = time.strftime("%H:%M:%S", time.localtime(change.time))
        moment = f"{seconds}.{int(change.time * 1000) % 1000:03d}"
        values = (self.tr("run"), "") if change.command else (change.before, change.after)
        before, after = (value if isinstance(value, str) else format_value(value) for value in values)
        return moment, str(change.key), before, after, self._who[change.origin], change.cause

    def rowCount(self, parent: QModelIndex = _ROOT) -> int:
        """Return the number of changes."""
        return 0 if parent.isValid() else len(self._changes)

    def columnCount(self, parent: QModelIndex = _ROOT) -> int:
        """Return the number of columns."""
        return 0 if parent.isValid() else len(self.titles)

    def headerData(
        self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole
    ) -> object:
        """Return a column's title."""
        if orientation == Qt.Orientation.Horizontal and role == Qt.ItemDataRole.DisplayRole:
            return self.titles[section]
        return None

    def data(self, index: QModelIndex, role: int = Qt.ItemDataRole.DisplayRole) -> object:
        """Return a cell's text; the tooltip has all of its digits."""
        change = self._changes[index.row()]
        if role == Qt.ItemDataRole.ToolTipRole:
            return self.texts(change)[index.column()]
        return self._shortened(change, index.column()) if role == Qt.ItemDataRole.DisplayRole else None

    def _append(self, change: Change) -> None:
        row = len(self._changes)
        self.beginInsertRows(QModelIndex(), row, row)
        self._changes.append(change)
        self._rows[change.number] = row
        self.endInsertRows()
        if len(self._changes) > MOST_CHANGES:
            self._forget(0, SOME)

    def _forget(self, first: int, count: int) -> None:
        self.beginRemoveRows(QModelIndex(), first, first + count - 1)
        del self._changes[first : first + count]
        self._rows = {change.number: row for row, change in enumerate(self._changes)}
        self.endRemoveRows()

    def _shortened(self, change: Change, column: int) -> str:
        value = {self.BEFORE: change.before, self.AFTER: change.after}.get(column)
        if isinstance(value, float):
            return localized(format_value(value)) if _alike(change) else number_text(value)
        text = self.texts(change)[column]
        if column == self.TIME:
            return text.partition(".")[0]
        if column == self.FEATURE and change.key.selected:
            return f"{change.key.name}[{', '.join(entry for _, entry in change.key.selected)}]"
        return text


def _alike(change: Change) -> bool:
    """Return whether the two values differ only in digits that `number_text` omits."""
    before, after = change.before, change.after
    return (
        isinstance(before, float) and isinstance(after, float) and number_text(before) == number_text(after)
    )


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
    """The user chose other changes; `setChanges` is expected."""

    controls: QBoxLayout
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
        self._narrow: bool | None = None
        self._follows = True
        "Whether to scroll to new rows: until the user scrolls up."
        if (bar := self.table.verticalScrollBar()) is not None:
            bar.valueChanged.connect(self._on_bar_value_changed)
            bar.rangeChanged.connect(self._follow)
        if (rows := self.table.verticalHeader()) is not None:
            rows.setDefaultSectionSize(self.fontMetrics().height() + ROW_PADDING)
        if (header := self.table.horizontalHeader()) is not None:
            left = Qt.Alignment(Qt.AlignmentFlag.AlignLeft)
            header.setDefaultAlignment(left | Qt.AlignmentFlag.AlignVCenter)
        self._arrange(narrow=True)  # or the window makes room for all of it
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

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Put the choice above the buttons in a narrow panel, and show what changed to which value."""
        super().resizeEvent(event)
        self._arrange(narrow=self.width() < NARROW)

    def _arrange(self, *, narrow: bool) -> None:
        if narrow is self._narrow:
            return
        self._narrow = narrow
        below, across = QBoxLayout.Direction.TopToBottom, QBoxLayout.Direction.LeftToRight
        self.controls.setDirection(below if narrow else across)
        if (around := self.layout()) is not None:
            around.invalidate()  # which a layout within it does not do
        for column in (ChangeTable.BEFORE, ChangeTable.BY, ChangeTable.CAUSE):
            self.table.setColumnHidden(column, narrow)
        if (header := self.table.horizontalHeader()) is not None:
            stretch, usual = QHeaderView.ResizeMode.Stretch, QHeaderView.ResizeMode.Interactive
            header.setStretchLastSection(not narrow)
            header.setSectionResizeMode(ChangeTable.FEATURE, stretch if narrow else usual)
        size_columns(self.table, _LONGEST)

    def setChanges(self, changes: Sequence[Change]) -> None:
        """Show these changes, as far as the filter lets them through."""
        self._changes.setChanges([change for change in changes if self._wanted(change)])
        self._follows = True
        self._follow()

    def noteChange(self, change: Change) -> None:
        """Add a change, or update one that continues; scroll there unless the user scrolled up."""
        if not self._wanted(change):
            return
        self._changes.note(change)
        self._follow()

    @property
    def chosen(self) -> tuple[Change, ...]:
        """The selected changes; without a selection, all that are shown."""
        selection = self.table.selectionModel()
        rows = sorted(index.row() for index in selection.selectedRows()) if selection is not None else []
        return tuple(self._changes.change(row) for row in rows) or self._changes.changes

    def tableText(self, changes: Sequence[Change]) -> str:
        """Return changes as lines of text, columns separated by tabs, with the columns' titles."""
        lines = [self._changes.titles, *(self._changes.texts(change) for change in changes)]
        return "".join("\t".join(line) + "\n" for line in lines)

    def _wanted(self, change: Change) -> bool:
        return change.origin in _WHOSE[self.whoseBox.currentIndex()]

    def _on_bar_value_changed(self, value: int) -> None:
        bar = self.table.verticalScrollBar()
        self._follows = bar is None or value == bar.maximum()

    def _follow(self) -> None:
        """Scroll to the newest row, also when the panel is raised or resized, unless the user scrolled up."""
        if self._follows:
            self.table.scrollToBottom()

    def _enable(self) -> None:
        anything = self._changes.rowCount() > 0
        for button in (self.copyButton, self.saveButton, self.clearButton):
            set_available(button, None if anything else Unavailable.ENTRIES)
