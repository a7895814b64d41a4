"""The scale of an image in false colours."""

from __future__ import annotations

import numpy as np
from PyQt5.QtCore import QPointF, QRect, QRectF, QSize, Qt
from PyQt5.QtGui import QColor, QImage, QPainter, QPaintEvent
from PyQt5.QtWidgets import QWidget

from grabbergui.models.image.quantities import NO_DATA, ColourScale
from grabbergui.models.language import localized

SCALE_MARGIN = 6
"Between a scale and the edge of its image, pixels."
_SCALE_HEIGHT = 260
_LEAST_ROOM = 4
"A scale takes at most 1/_LEAST_ROOM of the width of its image; beyond, it is text."
_BAR = 16
"Width of the colours, pixels."
_EDGE = 10
_TICK = 5
_BACK = QColor(0, 0, 0, 150)
"The image behind may have any colour."
_TEXT = QColor(255, 255, 255)


class ScaleBar(QWidget):
    """Paints a `ColourScale` from its largest value down to its smallest, below it the mark of no data."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self._scale: ColourScale | None = None
        self._colours = QImage()
        self.hide()

    @property
    def scale(self) -> ColourScale | None:
        """The scale that is shown."""
        return self._scale

    def setScale(self, scale: ColourScale | None) -> bool:
        """Show a scale, or none; return whether it differs from the one shown before."""
        if scale == self._scale:
            return False
        self._scale = scale
        self.setVisible(scale is not None)
        if scale is not None:
            column = np.ascontiguousarray(scale.colours[::-1].reshape(256, 1, 3))
            self._colours = QImage(column.tobytes(), 1, 256, 3, QImage.Format.Format_RGB888).copy()
            self.setAccessibleName(self.tr("Scale of the colours: {0}").format(_scale_text(scale)))
            self.update()
        return True

    def sizeHint(self) -> QSize:
        """Return room for the longest text."""
        metrics, scale = self.fontMetrics(), self._scale
        texts = [self._no_data()]
        if scale is not None:
            texts += [scale.unit, *(localized(scale.text(tick)) for tick in scale.ticks)]
        width = max(metrics.horizontalAdvance(text) for text in texts)
        return QSize(width + _BAR + _TICK + 3 * _EDGE, 200)

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Draw colours, ticks and the hatching."""
        scale = self._scale
        if scale is None:
            return
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(_BACK)
        painter.drawRoundedRect(QRectF(self.rect()), 6, 6)
        painter.setPen(_TEXT)
        line = self.fontMetrics().height()
        top = _EDGE + (line + 4 if scale.unit else line // 2)
        bottom = self.height() - 2 * _EDGE - line
        right = self.width() - _EDGE
        if scale.unit:
            painter.drawText(QRectF(0, _EDGE - 2, right, line), Qt.AlignmentFlag.AlignRight, scale.unit)
        painter.drawImage(QRectF(_EDGE, top, _BAR, bottom - top), self._colours)
        for tick in scale.ticks:
            y = bottom - (tick - scale.low) / (scale.high - scale.low) * (bottom - top)
            painter.drawLine(QPointF(_EDGE + _BAR, y), QPointF(_EDGE + _BAR + _TICK, y))
            place = QRectF(0, y - line / 2, right, line)
            painter.drawText(place, Qt.AlignmentFlag.AlignRight, localized(scale.text(tick)))
        swatch = QRectF(_EDGE, self.height() - _EDGE - line, _BAR, line)
        dark, light = (QColor(grey, grey, grey) for grey in NO_DATA)
        painter.fillRect(swatch, dark)
        painter.setBrush(Qt.BrushStyle.BDiagPattern)
        painter.fillRect(swatch, painter.brush())
        painter.setPen(light)
        painter.drawRect(swatch)
        painter.setPen(_TEXT)
        painter.drawText(QRectF(0, swatch.top(), right, line), Qt.AlignmentFlag.AlignRight, self._no_data())

    def _no_data(self) -> str:
        return self.tr("no data")


def place_scale(bar: ScaleBar, room: QRect, margin: int = SCALE_MARGIN, *, needed: bool = False) -> str:
    """Put a scale at the right edge of `room`.

    Return its text instead where it would hide the image, unless it is `needed`.
    """
    scale = bar.scale
    if scale is None:
        return ""
    size = bar.sizeHint()
    small = not needed and (size.width() * _LEAST_ROOM > room.width() or room.height() < size.height())
    bar.setVisible(not small)
    if small:
        return _scale_text(scale)
    height = min(_SCALE_HEIGHT, room.height() - 2 * margin)
    bar.setGeometry(room.right() - margin - size.width(), room.top() + margin, size.width(), height)
    bar.raise_()
    return ""


def _scale_text(scale: ColourScale) -> str:
    """Return the ends of a scale."""
    return localized(f"{scale.text(scale.low)} – {scale.text(scale.high)} {scale.unit}".strip())
