"""Detections drawn over the image, and what a set of calibration views covers: cells, tilts, distances."""

from __future__ import annotations

import numpy as np
from PyQt5.QtCore import QPointF, QRectF, QSize, Qt
from PyQt5.QtGui import QColor, QPainter, QPaintEvent, QPalette, QPen, QPolygonF
from PyQt5.QtWidgets import QSizePolicy, QStyleOptionGraphicsItem, QWidget

from grabbergui.calibration.collector import GRID, Counts, Coverage
from grabbergui.core.drawing import Drawing
from grabbergui.ui.widgets.image_overlays import ImageOverlay

_HALO = QColor(0, 0, 0, 130)
ENOUGH = 12
"Corners with which a cell has its full colour."
_GREEN = QColor(60, 200, 90)
_CELL, _GAP = 46.0, 8.0
_SKEW = 0.22
"Share by which the nearer edge of a tilted board is drawn longer."
_SIZES = (0.42, 0.68, 1.0)
"Sizes of a far, a middle and a near board."


class DrawingItem(ImageOverlay):
    """Shows a Drawing in a scene whose unit is the frame's pixel."""

    def __init__(self) -> None:
        super().__init__(20)
        self._drawing = Drawing()

    @property
    def drawing(self) -> Drawing:
        """The drawing shown."""
        return self._drawing

    def setDrawing(self, drawing: Drawing, width: int, height: int) -> None:
        """Show a drawing over an image of that size."""
        self._drawing = drawing
        self.cover(width, height)

    def paint(
        self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None
    ) -> None:
        """Draw every line over a darker one, so that it stands out from whatever is below."""
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        for stroke in self._drawing.strokes:
            # A pixel's centre is a whole number there, here its corner is.
            line = QPolygonF([QPointF(float(x) + 0.5, float(y) + 0.5) for x, y in stroke.points])
            for ink, width in ((_HALO, stroke.weight + 2), (QColor(*stroke.colour), stroke.weight)):
                pen = QPen(ink, width)
                pen.setCosmetic(True)
                pen.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
                painter.setPen(pen)
                if stroke.closed:
                    painter.drawPolygon(line)
                else:
                    painter.drawPolyline(line)
        self._words(painter)

    def _words(self, painter: QPainter) -> None:
        """Write the labels in the size of the window's text, at any zoom."""
        to_screen = painter.transform()
        painter.resetTransform()
        font = painter.font()
        font.setBold(True)
        painter.setFont(font)
        for label in self._drawing.labels:
            place = to_screen.map(QPointF(label.place[0] + 0.5, label.place[1] + 0.5))
            painter.setPen(_HALO)
            for shift in (QPointF(1, 1), QPointF(-1, 1), QPointF(1, -1), QPointF(-1, -1)):
                painter.drawText(place + shift, label.text)
            painter.setPen(QColor(*label.colour))
            painter.drawText(place, label.text)
        painter.setTransform(to_screen)


class CoverageItem(ImageOverlay):
    """Fills cells with a green that grows with their corners; outlines those without any."""

    def __init__(self) -> None:
        super().__init__(5)
        self._cells = np.zeros(GRID[::-1], np.int64)

    def setCells(self, cells: Counts, width: int, height: int) -> None:
        """Show counts (rows, columns) over an image of that size."""
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


class CoverageView(QWidget):
    """Nine small boards, tilted every way, and three of different sizes; green once seen."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Fixed)
        self._coverage = Coverage()

    def setCoverage(self, coverage: Coverage) -> None:
        """Show the tilts and distances seen so far."""
        self._coverage = coverage
        self.update()

    def sizeHint(self) -> QSize:
        """Return room for three by three boards and one more column."""
        return QSize(round(4 * (_CELL + _GAP) + 3 * _GAP + 100), round(3 * (_CELL + _GAP) + 22))

    def minimumSizeHint(self) -> QSize:
        """Return room for all boards."""
        return self.sizeHint()

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Draw the boards."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        muted = self.palette().color(QPalette.ColorRole.PlaceholderText)
        top = 22.0
        painter.setPen(muted)
        painter.drawText(QPointF(0, 14), self.tr("Tilts"))
        left = 3 * (_CELL + _GAP) + 3 * _GAP
        painter.drawText(QPointF(left, 14), self.tr("Distances"))
        for row in range(3):
            for column in range(3):
                place = QRectF(column * (_CELL + _GAP), top + row * (_CELL + _GAP), _CELL, _CELL)
                seen = int(self._coverage.tilts[row, column])
                self._board(painter, place, (column - 1) * _SKEW, (row - 1) * _SKEW, 0.68, seen)
        names = (self.tr("far"), self.tr("between"), self.tr("near"))
        for number, (size, name) in enumerate(zip(_SIZES, names, strict=True)):
            place = QRectF(left, top + number * (_CELL + _GAP), _CELL, _CELL)
            self._board(painter, place, 0, 0, size, int(self._coverage.sizes[number]))
            painter.setPen(muted)
            text = QRectF(place.right() + _GAP, place.top(), 90, _CELL)
            painter.drawText(text, Qt.AlignmentFlag.AlignVCenter, name)
        painter.end()

    def _board(
        self, painter: QPainter, place: QRectF, slant_x: float, slant_y: float, size: float, seen: int
    ) -> None:
        """Draw a board; with a positive slant its right (lower) edge is nearer."""
        half_x, half_y, middle = (
            place.width() / 2 * size * 0.92,
            place.height() / 2 * size * 0.7,
            place.center(),
        )
        corners = []
        for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
            nearer = 1 + slant_x * x + slant_y * y
            corners.append(QPointF(middle.x() + x * half_x * nearer, middle.y() + y * half_y * nearer))
        line = QColor(_GREEN) if seen else self.palette().color(QPalette.ColorRole.PlaceholderText)
        fill = QColor(_GREEN)
        fill.setAlpha(150)
        painter.setPen(QPen(line, 1.5))
        painter.setBrush(fill if seen else Qt.BrushStyle.NoBrush)
        painter.drawPolygon(QPolygonF(corners))
        if seen > 1:
            painter.setPen(self.palette().color(QPalette.ColorRole.WindowText))
            painter.drawText(place, Qt.AlignmentFlag.AlignCenter, str(seen))
