"""Overlays of the image: values of pixels, grid, marks, cursor."""

from __future__ import annotations

import math
from enum import Enum

import pyqtgraph as pg
from PyQt5.QtCore import QLineF, QPointF, QRectF, Qt
from PyQt5.QtGui import QColor, QFont, QFontMetrics, QPainter, QPainterPath, QPen
from PyQt5.QtWidgets import QStyleOptionGraphicsItem, QWidget

from grabbergui.models.image.pixel_text import TintedPart, plain_text
from grabbergui.ui.widgets.tinted import INK, PLATE, TINTS

PixelTexts = dict[tuple[int, int], tuple[TintedPart, ...]]
"The lines of text on pixels, by column and line of the image."
LEGIBLE_ZOOM = 40.0
"Screen pixels per pixel of the image from which its value has room."
_LARGEST, _LEAST = 11, 6
"Heights of text on a pixel, in screen pixels; smaller ones cannot be read."
_GAP = 4
"Screen pixels between the texts of two pixels."
GRID_PARTS = 6
"Fields of the grid along each side: thirds, and their halves."
_SHADE = QColor(0, 0, 0, 120)
_CROSS = 7
"Half the size of the mark of the cursor, screen pixels."


class ImageOverlay(pg.GraphicsObject):  # type: ignore[misc]  # the library has no types
    """An item in the image's coordinates: x to the right, y down, one unit a pixel."""

    def __init__(self, level: float) -> None:
        """`level` is its place among what lies over the image: the higher, the further in front."""
        super().__init__()
        self.setZValue(level)
        self._bounds = QRectF()

    def cover(self, width: int, height: int) -> None:
        """Cover an image of that size, and repaint."""
        bounds = QRectF(0, 0, width, height)
        if bounds != self._bounds:
            self.prepareGeometryChange()
            self._bounds = bounds
        self.update()

    def boundingRect(self) -> QRectF:
        """The whole image."""
        return self._bounds


class PixelValues(ImageOverlay):
    """Text on single pixels of the image as it is displayed."""

    def __init__(self) -> None:
        super().__init__(5)
        self._texts: PixelTexts = {}

    @property
    def texts(self) -> PixelTexts:
        """The texts shown."""
        return self._texts

    def setTexts(self, texts: PixelTexts) -> None:
        """Replace the texts."""
        if texts or self._texts:
            self._texts = texts
            self.update()

    def paint(
        self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None
    ) -> None:
        """Write each text in the middle of its pixel, as small as it takes to fit, if it can be read then."""
        if not self._texts:
            return
        to_screen = painter.worldTransform()
        painter.resetTransform()
        font = QFont(painter.font())
        font.setPixelSize(self._size(font, to_screen.mapRect(QRectF(0, 0, 1, 1))))
        if font.pixelSize() < _LEAST:
            return
        painter.setFont(font)
        for (x, y), lines in self._texts.items():
            pixel = to_screen.mapRect(QRectF(x, y, 1, 1))
            text = plain_text(lines, "\n")
            place = painter.boundingRect(pixel, Qt.AlignmentFlag.AlignCenter, text)
            painter.fillRect(place.adjusted(-3, -1, 3, 1), PLATE)
            row = QRectF(pixel.left(), place.top(), pixel.width(), place.height() / len(lines))
            for line, channel in lines:
                painter.setPen(TINTS.get(channel, INK))
                painter.drawText(row, Qt.AlignmentFlag.AlignCenter, line)
                row.translate(0, row.height())

    def _size(self, font: QFont, pixel: QRectF) -> int:
        """Return the height of text at which all of it fits into its pixel; 1 or more."""
        font.setPixelSize(_LARGEST)
        metrics, texts = QFontMetrics(font), list(self._texts.values())
        longest = max((line.text for lines in texts for line in lines), key=len)
        width = metrics.horizontalAdvance(longest) + 2 * _GAP
        height = metrics.height() * max(map(len, texts))
        return max(1, int(_LARGEST * min(1.0, pixel.width() / width, pixel.height() / height)))


class Mark(Enum):
    """The user's marks, and their colours."""

    DRAFT = "#ffffff"
    "The shape that is being drawn."
    FOCUS = "#30d158"
    PROFILE = "#ffb224"


def size_text(chosen: QRectF) -> str:
    """Return place and size of the pixels that a box touches: `120, 40   320 × 240`."""
    left, top = math.floor(chosen.left()), math.floor(chosen.top())
    return f"{left}, {top}   {math.ceil(chosen.right()) - left} × {math.ceil(chosen.bottom()) - top}"


def write_plate(painter: QPainter, corner: QPointF, text: str) -> None:
    """Write a text on a dark plate, in the pixels and the text size of the screen."""
    plate = QRectF(painter.fontMetrics().boundingRect(text)).adjusted(-6, -3, 6, 3)
    plate.moveTopLeft(corner)
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(QColor(0, 0, 0, 170))
    painter.drawRoundedRect(plate, 4, 4)
    painter.setPen(QColor(Mark.DRAFT.value))
    painter.drawText(plate, Qt.AlignmentFlag.AlignCenter, text)


class ImageMarks(ImageOverlay):
    """Drawn in the view's own pixels; every line is one screen pixel wide, over a darker one to stand out."""

    def __init__(self) -> None:
        super().__init__(10)
        self._crosshair = False
        self._grid = False
        self._shapes: dict[Mark, QRectF | QLineF] = {}

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

    def paint(
        self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None
    ) -> None:
        """Draw grid, crosshair and shapes."""
        if self._bounds.isEmpty():
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
        """Write the region's place and size in pixels of the image."""
        text = size_text(chosen.intersected(self.boundingRect()))
        on_screen = painter.transform().mapRect(chosen)
        to_screen = painter.transform()
        painter.resetTransform()
        write_plate(painter, on_screen.topLeft() + QPointF(6, 6), text)
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
        width, height = self._bounds.width(), self._bounds.height()
        lines: list[QRectF | QLineF] = []
        for part in range(1, GRID_PARTS):
            x, y = width * part / GRID_PARTS, height * part / GRID_PARTS
            lines += [QLineF(x, 0, x, height), QLineF(0, y, width, y)]
        return lines

    def _crosshair_lines(self) -> list[QRectF | QLineF]:
        width, height = self._bounds.width(), self._bounds.height()
        middle = self._bounds.center()
        return [QLineF(middle.x(), 0, middle.x(), height), QLineF(0, middle.y(), width, middle.y())]


class CursorMark(pg.GraphicsObject):  # type: ignore[misc]  # the library has no types
    """A small cross at the cursor's place in another image of the same frame; hidden at first."""

    def __init__(self) -> None:
        super().__init__()
        self.setFlag(self.ItemIgnoresTransformations)
        self.setZValue(6)
        self.hide()

    def boundingRect(self) -> QRectF:
        """The cross in screen pixels."""
        return QRectF(-_CROSS - 2, -_CROSS - 2, 2 * _CROSS + 4, 2 * _CROSS + 4)

    def paint(
        self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None
    ) -> None:
        """Draw it bright over dark, to be seen on any image."""
        for colour, width in ((QColor(0, 0, 0, 160), 3), (QColor(255, 255, 255), 1)):
            painter.setPen(QPen(colour, width))
            painter.drawLine(-_CROSS, 0, _CROSS, 0)
            painter.drawLine(0, -_CROSS, 0, _CROSS)
