"""Settings in a table that can be ticked."""

from __future__ import annotations

from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import QTreeWidget, QTreeWidgetItem

from grabbergui.core.selection import SettingKey

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
