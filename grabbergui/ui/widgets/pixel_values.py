"""The sensor's values written on the pixels, where these are large enough."""

from __future__ import annotations

import pyqtgraph as pg
from PyQt5.QtCore import QRectF, Qt
from PyQt5.QtGui import QColor, QFont, QPainter
from PyQt5.QtWidgets import QStyleOptionGraphicsItem, QWidget

LEGIBLE_ZOOM = 40.0
"Screen pixels for one of the picture from which on its value has room."
_LINE = 12
"Height of a line of text, pixels."
_BEHIND = QColor(0, 0, 0, 150)
"White text must stand out from white pixels too."


class PixelValues(pg.GraphicsObject):  # type: ignore[misc]  # the library has no types
    """Text on single pixels; in the pixels of the picture as it is seen."""

    def __init__(self) -> None:
        super().__init__()
        self.setZValue(5)
        self._size = (0, 0)
        self._texts: dict[tuple[int, int], str] = {}

    @property
    def texts(self) -> dict[tuple[int, int], str]:
        """What is written, by column and line."""
        return self._texts

    def setSize(self, width: int, height: int) -> None:
        """The size of the picture."""
        if (width, height) != self._size:
            self.prepareGeometryChange()
            self._size = (width, height)

    def setTexts(self, texts: dict[tuple[int, int], str]) -> None:
        """Write these, by column and line, and no others."""
        if texts or self._texts:
            self._texts = texts
            self.update()

    def boundingRect(self) -> QRectF:
        """The whole picture."""
        return QRectF(0, 0, *self._size)

    def paint(
        self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None
    ) -> None:
        """Write each text in the middle of its pixel."""
        if not self._texts:
            return
        to_screen = painter.worldTransform()
        painter.resetTransform()
        font = QFont(painter.font())
        font.setPixelSize(_LINE - 1)
        painter.setFont(font)
        painter.setPen(QColor(255, 255, 255))
        for (x, y), text in self._texts.items():
            pixel = to_screen.mapRect(QRectF(x, y, 1, 1))
            place = painter.boundingRect(pixel, Qt.AlignmentFlag.AlignCenter, text)
            painter.fillRect(place.adjusted(-3, -1, 3, 1), _BEHIND)
            painter.drawText(pixel, Qt.AlignmentFlag.AlignCenter, text)
