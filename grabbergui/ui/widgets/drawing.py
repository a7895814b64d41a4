"""Lines over the picture, such as crosshair, grid and regions, and the tool that draws regions and lines."""

from __future__ import annotations

import math
from enum import Enum
from typing import TYPE_CHECKING

import pyqtgraph as pg
from PyQt5.QtCore import QEvent, QLineF, QObject, QPointF, QRectF, Qt, pyqtSignal
from PyQt5.QtGui import QColor, QKeyEvent, QMouseEvent, QPainter, QPainterPath, QPen
from PyQt5.QtWidgets import QStyleOptionGraphicsItem, QWidget

from grabbergui.core.pixels import Region
from grabbergui.models.measuring import Line

if TYPE_CHECKING:  # the canvas imports the marks
    from grabbergui.ui.widgets.picture_canvas import PictureCanvas

GRID_PARTS = 6
"Fields of the grid along each side: thirds, and their halves."


class Mark(Enum):
    """The user's marks, and their colours."""

    DRAFT = "#ffffff"
    "The shape that is being drawn."
    FOCUS = "#30d158"
    PROFILE = "#ffb224"


_SHADE = QColor(0, 0, 0, 120)


def size_text(chosen: QRectF) -> str:
    """Return width and height of the pixels that a box touches."""
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
        """Set the size of the picture as it is displayed."""
        if (width, height) != self._size:
            self.prepareGeometryChange()
            self._size = (width, height)

    def setCrosshair(self, shown: bool) -> None:
        """Show or hide the crosshair."""
        self._crosshair = shown
        self.update()

    def setGrid(self, shown: bool) -> None:
        """Show or hide the grid."""
        self._grid = shown
        self.update()

    def setShape(self, mark: Mark, shape: QRectF | QLineF | None) -> None:
        """Show a rectangle or a line; None removes it."""
        if shape is None:
            self._shapes.pop(mark, None)
        else:
            self._shapes[mark] = shape
        self.update()

    def shape_of(self, mark: Mark) -> QRectF | QLineF | None:
        """Return the shape of a mark; None if it is not shown."""
        return self._shapes.get(mark)

    def boundingRect(self) -> QRectF:
        """The whole picture."""
        return QRectF(0, 0, *self._size)

    def paint(
        self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None
    ) -> None:
        """Draw grid, crosshair and shapes."""
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
                self._write_size(painter, chosen)

    def _darken_around(self, painter: QPainter, chosen: QRectF) -> None:
        """Dim the area outside the region, so that it can be judged while it is drawn."""
        around = QPainterPath()
        around.addRect(self.boundingRect())
        around.addRect(chosen.intersected(self.boundingRect()))
        painter.fillPath(around, _SHADE)  # odd and even: the inner one is left out

    def _write_size(self, painter: QPainter, chosen: QRectF) -> None:
        """Write the region's size in pixels of the picture, in the size of the window's text."""
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


LEAST = 2.0
"Shortest drag, in pixels of the picture; a shorter one was a slip."


class Purpose(Enum):
    """The shape that is drawn."""

    SENSOR_REGION = "sensor region"
    FOCUS_REGION = "focus region"
    PROFILE_LINE = "profile line"
    EXPOSURE_REGION = "exposure region"
    BALANCE_REGION = "balance region"


class DrawingTool(QObject):
    """Takes the mouse from the canvas, from `begin` until a shape is drawn or Escape is pressed."""

    regionDrawn = pyqtSignal(Purpose, Region)
    """In pixels of the picture as it is displayed, within it."""
    lineDrawn = pyqtSignal(Purpose, Line)
    ended = pyqtSignal()
    """A shape was drawn, or cancelled."""

    def __init__(self, canvas: PictureCanvas) -> None:
        super().__init__(canvas)
        self._canvas = canvas
        self._purpose: Purpose | None = None
        self._start: QPointF | None = None
        canvas.installEventFilter(self)
        viewport = canvas.viewport()
        assert viewport is not None
        viewport.installEventFilter(self)

    @property
    def purpose(self) -> Purpose | None:
        """The shape in progress."""
        return self._purpose

    def begin(self, purpose: Purpose) -> None:
        """Draw a shape for this purpose with the next drag of the mouse."""
        self._purpose, self._start = purpose, None
        self._canvas.setFocus(Qt.FocusReason.OtherFocusReason)

    def cancel(self) -> None:
        """Cancel; does nothing if nothing is being drawn."""
        if self._purpose is not None:
            self._end()

    def eventFilter(self, watched: QObject | None, event: QEvent | None) -> bool:
        """Keep the events of the drag from the canvas."""
        if self._purpose is None or event is None:
            return False
        if isinstance(event, QKeyEvent) and event.key() == Qt.Key.Key_Escape:
            if event.type() == QEvent.Type.KeyPress:
                self.cancel()
            return True
        if watched is self._canvas or not isinstance(event, QMouseEvent):
            return False
        return self._on_mouse(event)

    def _on_mouse(self, event: QMouseEvent) -> bool:
        point = self._canvas.viewToFrame(event.localPos())
        kind = event.type()
        if kind == QEvent.Type.MouseButtonPress and event.button() == Qt.MouseButton.LeftButton:
            self._start = point
        elif kind == QEvent.Type.MouseMove and self._start is not None:
            self._canvas.marks.setShape(Mark.DRAFT, self._shape(self._start, point))
            return True
        elif kind == QEvent.Type.MouseButtonRelease and self._start is not None:
            self._finish(self._start, point)
        return kind != QEvent.Type.MouseMove

    def _shape(self, start: QPointF, end: QPointF) -> QRectF | QLineF:
        if self._purpose is Purpose.PROFILE_LINE:
            return QLineF(start, end)
        return QRectF(start, end).normalized()

    def _finish(self, start: QPointF, end: QPointF) -> None:
        purpose = self._purpose
        assert purpose is not None
        length = QLineF(start, end).length()
        self._end()
        if length < LEAST:
            return
        if purpose is Purpose.PROFILE_LINE:
            self.lineDrawn.emit(purpose, Line(int(start.x()), int(start.y()), int(end.x()), int(end.y())))
            return
        box = QRectF(start, end).normalized()
        # Every pixel that the box touches.
        left, top = math.floor(box.left()), math.floor(box.top())
        right, bottom = math.ceil(box.right()), math.ceil(box.bottom())
        region = Region(left, top, max(1, right - left), max(1, bottom - top))
        self.regionDrawn.emit(purpose, region.clipped(*self._canvas.pictureSize))

    def _end(self) -> None:
        self._purpose = self._start = None
        self._canvas.marks.setShape(Mark.DRAFT, None)
        self.ended.emit()
