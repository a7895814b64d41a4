"""Lines and words over a picture, in its own pixels, always as sharp as the screen."""

from __future__ import annotations

from PyQt5.QtCore import QPointF, Qt
from PyQt5.QtGui import QColor, QPainter, QPen, QPolygonF
from PyQt5.QtWidgets import QStyleOptionGraphicsItem, QWidget

from grabbergui.servo.overlay import Drawing
from grabbergui.ui.widgets.picture_overlay import PictureOverlay

_HALO = QColor(0, 0, 0, 130)


class DrawingItem(PictureOverlay):
    """Shows a Drawing in a scene whose unit is the frame's pixel."""

    def __init__(self) -> None:
        super().__init__(20)
        self._drawing = Drawing()

    @property
    def drawing(self) -> Drawing:
        """What is shown."""
        return self._drawing

    def setDrawing(self, drawing: Drawing, width: int, height: int) -> None:
        """Show it over a picture of that size."""
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
        """At the size of the window's text, whatever the zoom."""
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
