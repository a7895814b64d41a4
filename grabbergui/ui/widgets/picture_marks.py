"""Lines over the picture: crosshair, grid, regions and the line of a profile."""

from __future__ import annotations

import math
from enum import Enum

import pyqtgraph as pg
from PyQt5.QtCore import QLineF, QPointF, QRectF, Qt
from PyQt5.QtGui import QColor, QPainter, QPainterPath, QPen
from PyQt5.QtWidgets import QStyleOptionGraphicsItem, QWidget

GRID_PARTS = 6
"Fields of the grid along each side: thirds, and their halves."


class Mark(Enum):
    """The marks of the user, and their colours."""

    DRAFT = "#ffffff"
    "Being drawn."
    FOCUS = "#30d158"
    PROFILE = "#ffb224"


_SHADE = QColor(0, 0, 0, 120)


def size_text(chosen: QRectF) -> str:
    """Width and height of every pixel that a box touches."""
    width = math.ceil(chosen.right()) - math.floor(chosen.left())
    height = math.ceil(chosen.bottom()) - math.floor(chosen.top())
    return f"{width} × {height}"


class PictureMarks(pg.GraphicsObject):  # type: ignore[misc]  # the library has no types
    """Drawn in the view's own pixels; every line is one screen pixel wide, over a darker one to stand out."""

    def __init__(self) -> None:
        super().__init__()
        self.setZValue(10)
        self._size = (0, 0)
        self._crosshair = False
        self._grid = False
        self._shapes: dict[Mark, QRectF | QLineF] = {}

    def setSize(self, width: int, height: int) -> None:
        """The size of the picture as it is seen."""
        if (width, height) != self._size:
            self.prepareGeometryChange()
            self._size = (width, height)

    def setCrosshair(self, shown: bool) -> None:
        """Mark the middle."""
        self._crosshair = shown
        self.update()

    def setGrid(self, shown: bool) -> None:
        """Divide the picture."""
        self._grid = shown
        self.update()

    def setShape(self, mark: Mark, shape: QRectF | QLineF | None) -> None:
        """Show a rectangle or a line; None takes it away."""
        if shape is None:
            self._shapes.pop(mark, None)
        else:
            self._shapes[mark] = shape
        self.update()

    def shape_of(self, mark: Mark) -> QRectF | QLineF | None:
        """What is shown."""
        return self._shapes.get(mark)

    def boundingRect(self) -> QRectF:
        """The whole picture."""
        return QRectF(0, 0, *self._size)

    def paint(
        self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None
    ) -> None:
        """Draw what is shown."""
        if not self._size[0]:
            return
        if self._grid:
            self._draw(painter, QColor(255, 255, 255, 110), self._grid_lines())
        if self._crosshair:
            self._draw(painter, QColor(255, 255, 255, 210), self._crosshair_lines())
        for mark, shape in self._shapes.items():
            chosen = shape if mark is Mark.DRAFT and isinstance(shape, QRectF) else None
            if chosen is not None:
                self._darken_around(painter, chosen)
            self._draw(painter, QColor(mark.value), [shape])
            if chosen is not None:
                self._tell_size(painter, chosen)

    def _darken_around(self, painter: QPainter, chosen: QRectF) -> None:
        """Dims the area outside the choice, so that the choice can be judged while it is made."""
        around = QPainterPath()
        around.addRect(self.boundingRect())
        around.addRect(chosen.intersected(self.boundingRect()))
        painter.fillPath(around, _SHADE)  # odd and even: the inner one is left out

    def _tell_size(self, painter: QPainter, chosen: QRectF) -> None:
        """Its size in pixels of the picture, in the size of the window's text."""
        text = size_text(chosen.intersected(self.boundingRect()))
        on_screen = painter.transform().mapRect(chosen)
        to_screen = painter.transform()
        painter.resetTransform()
        plate = QRectF(painter.fontMetrics().boundingRect(text)).adjusted(-6, -3, 6, 3)
        plate.moveTopLeft(on_screen.topLeft() + QPointF(6, 6))
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor(0, 0, 0, 170))
        painter.drawRoundedRect(plate, 4, 4)
        painter.setPen(QColor(Mark.DRAFT.value))
        painter.drawText(plate, Qt.AlignmentFlag.AlignCenter, text)
        painter.setTransform(to_screen)

    def _draw(self, painter: QPainter, colour: QColor, shapes: list[QRectF | QLineF]) -> None:
        for ink, width in ((QColor(0, 0, 0, 110), 3), (colour, 1)):
            pen = QPen(ink, width)
            pen.setCosmetic(True)
            painter.setPen(pen)
            painter.setBrush(Qt.BrushStyle.NoBrush)
            for shape in shapes:
                if isinstance(shape, QLineF):
                    painter.drawLine(shape)
                else:
                    painter.drawRect(shape)

    def _grid_lines(self) -> list[QRectF | QLineF]:
        width, height = self._size
        lines: list[QRectF | QLineF] = []
        for part in range(1, GRID_PARTS):
            x, y = width * part / GRID_PARTS, height * part / GRID_PARTS
            lines += [QLineF(x, 0, x, height), QLineF(0, y, width, y)]
        return lines

    def _crosshair_lines(self) -> list[QRectF | QLineF]:
        width, height = self._size
        middle = QPointF(width / 2, height / 2)
        return [QLineF(middle.x(), 0, middle.x(), height), QLineF(0, middle.y(), width, middle.y())]
