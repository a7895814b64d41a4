"""Which parts of the picture a set of views covers, over the picture."""

from __future__ import annotations

import numpy as np
from PyQt5.QtCore import QRectF, Qt
from PyQt5.QtGui import QColor, QPainter, QPen
from PyQt5.QtWidgets import QStyleOptionGraphicsItem, QWidget

from grabbergui.calibration.coverage import GRID, Counts
from grabbergui.ui.widgets.picture_overlay import PictureOverlay

ENOUGH = 12
"Corners in a cell with which it has its full colour."
_GREEN = QColor(60, 200, 90)


class CoverageItem(PictureOverlay):
    """Cells grow greener the more corners were seen in them; those without any are outlined."""

    def __init__(self) -> None:
        super().__init__(5)
        self._cells = np.zeros(GRID[::-1], np.int64)

    def setCells(self, cells: Counts, width: int, height: int) -> None:
        """Show counts (rows, columns) over a picture of that size."""
        self._cells = cells
        self.cover(width, height)

    def paint(
        self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None
    ) -> None:
        """Draw the cells."""
        rows, columns = self._cells.shape
        width, height = self._bounds.width() / columns, self._bounds.height() / rows
        outline = QPen(QColor(255, 255, 255, 50), 1)
        outline.setCosmetic(True)
        painter.setPen(outline)
        for row in range(rows):
            for column in range(columns):
                count = min(int(self._cells[row, column]), ENOUGH)
                fill = QColor(_GREEN)
                fill.setAlpha(0 if not count else 24 + 48 * count // ENOUGH)
                painter.setBrush(fill if count else Qt.BrushStyle.NoBrush)
                painter.drawRect(QRectF(column * width, row * height, width, height))
