"""Rows of text in a table, filled again and again while their values change."""

from __future__ import annotations

from collections.abc import Sequence

from PyQt5.QtWidgets import QTreeWidget, QTreeWidgetItem

from grabbergui.ui.shown_text import set_cell_tooltip


def fill_rows(table: QTreeWidget, rows: Sequence[Sequence[str]]) -> bool:
    """Show these rows; those that stay keep their place and selection. Return whether there are more now."""
    before = table.topLevelItemCount()
    while table.topLevelItemCount() > len(rows):
        table.takeTopLevelItem(table.topLevelItemCount() - 1)
    while table.topLevelItemCount() < len(rows):
        QTreeWidgetItem(table)
    for row, texts in enumerate(rows):
        item = table.topLevelItem(row)
        assert item is not None
        for column, text in enumerate(texts):
            if item.text(column) != text:
                item.setText(column, text)
                set_cell_tooltip(item, column, text)
    return len(rows) > before
