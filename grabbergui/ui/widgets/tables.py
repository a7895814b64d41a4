"""Changes and settings as tables."""

from __future__ import annotations

import time
from collections.abc import Sequence

from PyQt5.QtCore import QAbstractTableModel, QModelIndex, QObject, Qt
from PyQt5.QtWidgets import QTreeWidget, QTreeWidgetItem

from grabbergui.core.features import format_value
from grabbergui.core.selection import SettingKey
from grabbergui.models.changes.history import Change, Origin
from grabbergui.models.changes.journal import MOST_CHANGES
from grabbergui.models.features.text import number_text

_ROOT = QModelIndex()
SOME = 200
"""Rows forgotten at once."""


class ChangeTable(QAbstractTableModel):
    """One row a change, the oldest first; a change that went on keeps its row."""

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
        "Of the columns."
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
        """All of them, the oldest first."""
        return tuple(self._changes)

    def change(self, row: int) -> Change:
        """The change in a row."""
        return self._changes[row]

    def setChanges(self, changes: Sequence[Change]) -> None:
        """Show these and no others."""
        self.beginResetModel()
        self._changes = list(changes)
        self._rows = {change.number: row for row, change in enumerate(self._changes)}
        self.endResetModel()

    def note(self, change: Change) -> None:
        """Show one more, or one that went on; the oldest make way."""
        row = self._rows.get(change.number)
        if row is not None:
            self._changes[row] = change
            self.dataChanged.emit(self.index(row, 0), self.index(row, self.CAUSE))
            return
        row = len(self._changes)
        self.beginInsertRows(QModelIndex(), row, row)
        self._changes.append(change)
        self._rows[change.number] = row
        self.endInsertRows()
        if len(self._changes) > MOST_CHANGES:
            self._forget(SOME)

    def texts(self, change: Change) -> tuple[str, ...]:
        """The columns' texts for a change."""
        seconds = time.strftime("%H:%M:%S", time.localtime(change.time))
        moment = f"{seconds}.{int(change.time * 1000) % 1000:03d}"
        values = (self.tr("run"), "") if change.command else (change.before, change.after)
        before, after = (value if isinstance(value, str) else format_value(value) for value in values)
        return moment, str(change.key), before, after, self._who[change.origin], change.cause

    # -- Qt's part of a table ----------------------------------------------------------------------
    def rowCount(self, parent: QModelIndex = _ROOT) -> int:
        """How many changes."""
        return 0 if parent.isValid() else len(self._changes)

    def columnCount(self, parent: QModelIndex = _ROOT) -> int:
        """How many columns."""
        return 0 if parent.isValid() else len(self.titles)

    def headerData(
        self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole
    ) -> object:
        """The columns' titles."""
        if orientation == Qt.Orientation.Horizontal and role == Qt.ItemDataRole.DisplayRole:
            return self.titles[section]
        return None

    def data(self, index: QModelIndex, role: int = Qt.ItemDataRole.DisplayRole) -> object:
        """A cell's text; in full, with all its digits, as a tooltip."""
        change = self._changes[index.row()]
        if role == Qt.ItemDataRole.ToolTipRole:
            return self.texts(change)[index.column()]
        return self._shortened(change, index.column()) if role == Qt.ItemDataRole.DisplayRole else None

    def _forget(self, count: int) -> None:
        self.beginRemoveRows(QModelIndex(), 0, count - 1)
        del self._changes[:count]
        self._rows = {change.number: row for row, change in enumerate(self._changes)}
        self.endRemoveRows()

    def _shortened(self, change: Change, column: int) -> str:
        value = {self.BEFORE: change.before, self.AFTER: change.after}.get(column)
        if isinstance(value, float):
            return number_text(value)
        text = self.texts(change)[column]
        if column == self.TIME:
            return text.partition(".")[0]
        if column == self.FEATURE and change.key.selected:
            return f"{change.key.name}[{', '.join(entry for _, entry in change.key.selected)}]"
        return text


TICK_WIDTH = 24
"Pixels of the ticks, which a style sheet makes larger than a column fitted to its contents has room for."
_KEY_ROLE = Qt.ItemDataRole.UserRole + 1


def make_checkable(row: QTreeWidgetItem, key: SettingKey) -> None:
    """Let a row be ticked; it is at first."""
    row.setFlags(row.flags() | Qt.ItemFlag.ItemIsUserCheckable)
    row.setCheckState(0, Qt.CheckState.Checked)
    row.setData(0, _KEY_ROLE, key)


def checked_keys(table: QTreeWidget) -> list[SettingKey]:
    """The settings of the rows that are ticked."""
    rows = (table.topLevelItem(index) for index in range(table.topLevelItemCount()))
    return [
        row.data(0, _KEY_ROLE)
        for row in rows
        if row is not None
        and row.data(0, _KEY_ROLE) is not None
        and row.checkState(0) == Qt.CheckState.Checked
    ]
