"""The width of a table's columns."""

from __future__ import annotations

from collections.abc import Sequence

from PyQt5.QtWidgets import (
    QTableView,
    QTreeView,
)

CELL_MARGINS = 16
"Pixels beside the text of a cell."


def size_columns(table: QTableView | QTreeView, longest: Sequence[str]) -> None:
    """Make the first columns as wide as these texts are in the table's font."""
    table.ensurePolished()  # the style sheet may set another font
    for column, text in enumerate(longest):
        table.setColumnWidth(column, table.fontMetrics().horizontalAdvance(text) + CELL_MARGINS)
