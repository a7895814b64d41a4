"""The scale of a picture in false colour: colours, round values with their unit, and the mark of no data."""

from __future__ import annotations

import numpy as np
from PyQt5.QtCore import QPointF, QRectF, QSize, Qt
from PyQt5.QtGui import QColor, QImage, QPainter, QPaintEvent
from PyQt5.QtWidgets import QWidget

from grabbergui.models.language import localized
from grabbergui.models.picture.quantities import NO_DATA, ColourScale

_BAR = 16
"Width of the colours, pixels."
_MARGIN = 10
_TICK = 5
_BACK = QColor(0, 0, 0, 150)
"The picture behind may have any colour."
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
        """Show a scale, or none. Return whether it is another than before."""
        if scale == self._scale:
            return False
        self._scale = scale
        self.setVisible(scale is not None)
        if scale is not None:
            column = np.ascontiguousarray(scale.colours[::-1].reshape(256, 1, 3))
            self._colours = QImage(column.tobytes(), 1, 256, 3, QImage.Format.Format_RGB888).copy()
            ends = f"{scale.text(scale.low)} – {scale.text(scale.high)} {scale.unit}".strip()
            self.setAccessibleName(self.tr("Scale of the colours: {0}").format(localized(ends)))
            self.update()
        return True

    def sizeHint(self) -> QSize:
        """As wide as the longest text."""
        metrics, scale = self.fontMetrics(), self._scale
        texts = [self._no_data()]
        if scale is not None:
            texts += [scale.unit, *(localized(scale.text(tick)) for tick in scale.ticks)]
        width = max(metrics.horizontalAdvance(text) for text in texts)
        return QSize(width + _BAR + _TICK + 3 * _MARGIN, 200)

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
        top = _MARGIN + (line + 4 if scale.unit else line // 2)
        bottom = self.height() - 2 * _MARGIN - line
        right = self.width() - _MARGIN
        if scale.unit:
            painter.drawText(QRectF(0, _MARGIN - 2, right, line), Qt.AlignmentFlag.AlignRight, scale.unit)
        painter.drawImage(QRectF(_MARGIN, top, _BAR, bottom - top), self._colours)
        for tick in scale.ticks:
            y = bottom - (tick - scale.low) / (scale.high - scale.low) * (bottom - top)
            painter.drawLine(QPointF(_MARGIN + _BAR, y), QPointF(_MARGIN + _BAR + _TICK, y))
            place = QRectF(0, y - line / 2, right, line)
            painter.drawText(place, Qt.AlignmentFlag.AlignRight, localized(scale.text(tick)))
        swatch = QRectF(_MARGIN, self.height() - _MARGIN - line, _BAR, line)
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
