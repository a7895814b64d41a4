"""Numbers in the colour of the channel they belong to, on a dark plate over the image."""

from __future__ import annotations

from collections.abc import Sequence

from PyQt5.QtCore import QRectF, Qt
from PyQt5.QtGui import QColor, QPainter, QPaintEvent
from PyQt5.QtWidgets import QWidget

from grabbergui.models.image.pixel_text import TintedPart
from grabbergui.ui.widgets.labels import ShrinkingLabel

PLATE = QColor(0, 0, 0, 200)
"Behind text over the image, in both themes: the image may be white."
INK = QColor(255, 255, 255)
TINTS = {"R": QColor("#ff9c92"), "G": QColor("#7be3a3"), "B": QColor("#a9c4ff")}
"Ink of each channel; at least 4.5:1 on `PLATE` over white."


class TintedLabel(ShrinkingLabel):
    """A line of text with parts in the colours of channels, on a dark ground; else as its base."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._parts: tuple[TintedPart, ...] = ()

    def setParts(self, parts: Sequence[TintedPart]) -> None:
        """Show these parts one after the other."""
        self._parts = tuple(parts)
        self.setText("".join(part.text for part in parts))
        self.update()

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Draw the parts side by side; the text elided and in one colour where there is no room."""
        if self.shown != self.text():
            super().paintEvent(event)
            return
        painter, place = QPainter(self), QRectF(self.contentsRect())
        for text, channel in self._parts:
            painter.setPen(TINTS.get(channel, INK))
            painter.drawText(place, Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignLeft, text)
            place.setLeft(place.left() + self.fontMetrics().horizontalAdvance(text))
