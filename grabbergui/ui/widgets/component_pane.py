"""A component beside the chosen one with its caption, and the scale of a picture in false colour."""

from __future__ import annotations

import numpy as np
import pyqtgraph as pg
from PyQt5.QtCore import QEvent, QPointF, QRect, QRectF, QSize, Qt, pyqtSignal
from PyQt5.QtGui import QColor, QImage, QMouseEvent, QPainter, QPaintEvent, QPen, QResizeEvent
from PyQt5.QtWidgets import QApplication, QStyleOptionGraphicsItem, QWidget

from grabbergui.core.pixels import DisplayImage
from grabbergui.models.language import localized
from grabbergui.models.picture.quantities import NO_DATA, ColourScale
from grabbergui.ui.widgets.picture_items import DIMMED, PictureItem

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
        """Show a scale, or none; return whether it changed."""
        if scale == self._scale:
            return False
        self._scale = scale
        self.setVisible(scale is not None)
        if scale is not None:
            column = np.ascontiguousarray(scale.colours[::-1].reshape(256, 1, 3))
            self._colours = QImage(column.tobytes(), 1, 256, 3, QImage.Format.Format_RGB888).copy()
            self.setAccessibleName(self.tr("Scale of the colours: {0}").format(scale_text(scale)))
            self.update()
        return True

    def sizeHint(self) -> QSize:
        """Return room for the longest text."""
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


MARGIN = 6
_PAD = 6
SCALE_HEIGHT = 260
_LEAST_ROOM = 4
"A scale takes at most this part of the width and height of its picture; in a smaller one it is text."
_CROSS = 7
"Half the size of the mark of the cursor, screen pixels."


class CursorMark(pg.GraphicsObject):  # type: ignore[misc]  # the library has no types
    """A small cross at the cursor's place in another picture of the same frame; hidden at first."""

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
        """Draw it bright over dark, to be seen on any picture."""
        for colour, width in ((QColor(0, 0, 0, 160), 3), (QColor(255, 255, 255), 1)):
            painter.setPen(QPen(colour, width))
            painter.drawLine(-_CROSS, 0, _CROSS, 0)
            painter.drawLine(0, -_CROSS, 0, _CROSS)


class PaneCaption(QWidget):
    """The name of a component over its picture, its value under the cursor, and a scale that has no room."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self._parts = ("", "", "")
        self._lines: list[str] = []
        self.hide()

    @property
    def text(self) -> str:
        """The text shown."""
        return "\n".join(self._lines)

    def setParts(self, name: str, value: str, scale: str) -> None:
        """Show name, value and scale; nothing without a name."""
        if (name, value, scale) != self._parts:
            self._parts = (name, value, scale)
            self.arrange()

    def arrange(self) -> None:
        """Fit the text into the width of the picture, in one line or several."""
        self.ensurePolished()  # the style sheet may set another font
        name, value, scale = self._parts
        room = self._room()
        first = f"{name}   {value}" if value else name
        long = self.fontMetrics().horizontalAdvance(first) > room
        self._lines = [line for line in ([name, value, scale] if long else [first, scale]) if line]
        width = max(map(self.fontMetrics().horizontalAdvance, self._lines), default=0)
        height = self.fontMetrics().height() * len(self._lines)
        self.setGeometry(MARGIN, MARGIN, min(width, room) + 2 * _PAD, height + _PAD)
        self.setVisible(bool(name))
        self.update()

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Write it bright over dark, to be read on any picture."""
        painter, line = QPainter(self), self.fontMetrics().height()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor(0, 0, 0, 150))
        painter.drawRoundedRect(QRectF(self.rect()), 4, 4)
        painter.setPen(QColor(255, 255, 255))
        for index, text in enumerate(self._lines):
            elided = self.fontMetrics().elidedText(text, Qt.TextElideMode.ElideRight, self.width() - 2 * _PAD)
            top = _PAD // 2 + index * line
            painter.drawText(QRect(_PAD, top, self.width(), line), Qt.AlignmentFlag.AlignLeft, elided)

    def _room(self) -> int:
        parent = self.parentWidget()
        return max(40, (parent.width() if parent is not None else 0) - 2 * MARGIN - 2 * _PAD)


def place_scale(bar: ScaleBar, room: QRect, margin: int = MARGIN, *, needed: bool = False) -> str:
    """Put a scale at the right edge of `room`.

    Return its text instead where it would hide the picture, unless it is `needed`.
    """
    scale = bar.scale
    if scale is None:
        return ""
    size = bar.sizeHint()
    small = not needed and (size.width() * _LEAST_ROOM > room.width() or room.height() < size.height())
    bar.setVisible(not small)
    if small:
        return scale_text(scale)
    height = min(SCALE_HEIGHT, room.height() - 2 * margin)
    bar.setGeometry(room.right() - margin - size.width(), room.top() + margin, size.width(), height)
    bar.raise_()
    return ""


def scale_text(scale: ColourScale) -> str:
    """Return the ends of a scale."""
    return localized(f"{scale.text(scale.low)} – {scale.text(scale.high)} {scale.unit}".strip())


class ComponentPane(pg.GraphicsView):  # type: ignore[misc]  # the library has no types
    """Shows a part of a component. Wheel and dragging move it, which its owner passes on to all panes.

    Places are fractions of the picture, as components may differ in size.
    """

    moved = pyqtSignal(QRectF)
    """The user zoomed or panned; the part that is seen."""
    chosen = pyqtSignal()
    """The user clicked on it."""
    fitToggled = pyqtSignal()
    cursorMoved = pyqtSignal(QPointF)
    cursorLeft = pyqtSignal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent, background=None)
        self.setFrameShape(self.NoFrame)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)  # letters are keys of the chosen picture
        self.setMinimumSize(60, 40)
        self._box = pg.ViewBox(lockAspect=True, invertY=True, enableMenu=False, defaultPadding=0)
        self._box.setBorder(None)
        self._item = PictureItem(lambda: None)
        self._pressed: QPointF | None = None
        self.mark = CursorMark()
        self.setCentralItem(self._box)
        self._box.addItem(self._item, ignoreBounds=True)
        self._box.addItem(self.mark, ignoreBounds=True)
        self._box.disableAutoRange()
        self._box.sigRangeChangedManually.connect(self._on_box_moved_by_hand)
        self.caption = PaneCaption(self)
        self.scaleBar = ScaleBar(self)
        self._name = self._value = ""

    def setPicture(self, name: str, image: DisplayImage, width: int, height: int) -> None:
        """Show an image of a component of that name and size in pixels."""
        self._item.setPicture(image, width, height)
        if name != self._name:
            self._name = name
            self.setAccessibleName(name)
            self._caption()

    def setScale(self, scale: ColourScale | None) -> None:
        """Show the scale of false colours; None for a picture of light."""
        if self.scaleBar.setScale(scale):
            self._caption()

    def setValueText(self, text: str) -> None:
        """Show the value under the cursor."""
        if text != self._value:
            self._value = text
            self._caption()

    def setDimmed(self, dimmed: bool) -> None:
        """Dim the picture, which is not current."""
        self._item.setOpacity(DIMMED if dimmed else 1.0)

    def setSeen(self, part: QRectF) -> None:
        """Show this part of the picture."""
        width, height = self._item.frame_size
        seen = QRectF(part.x() * width, part.y() * height, part.width() * width, part.height() * height)
        if width and height and seen != self._box.viewRect():
            self._box.setRange(seen, padding=0)

    def setMark(self, place: QPointF | None) -> None:
        """Mark a place of the picture, or none."""
        self.mark.setVisible(place is not None)
        if place is not None:
            width, height = self._item.frame_size
            self.mark.setPos(place.x() * width, place.y() * height)

    # -- Qt's own ----------------------------------------------------------------------------------
    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Keep the scale at the edge."""
        super().resizeEvent(event)
        if hasattr(self, "scaleBar"):
            self._caption()
            self.caption.arrange()

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Remember where a click may begin."""
        super().mousePressEvent(event)
        self._pressed = event.localPos() if event.button() == Qt.MouseButton.LeftButton else None

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """Emit `chosen` for a click, not for the end of a drag."""
        super().mouseReleaseEvent(event)
        pressed, self._pressed = self._pressed, None
        if pressed is not None:
            way = (event.localPos() - pressed).manhattanLength()
            if way < QApplication.startDragDistance():
                self.chosen.emit()

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        """Toggle between fitted and 1:1."""
        super().mouseDoubleClickEvent(event)
        self.fitToggled.emit()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Follow the cursor."""
        super().mouseMoveEvent(event)
        point = self._box.mapSceneToView(QPointF(self.mapToScene(event.pos())))
        width, height = self._item.frame_size
        if 0 <= point.x() < width and 0 <= point.y() < height:
            self.cursorMoved.emit(QPointF(point.x() / width, point.y() / height))
        else:
            self.cursorLeft.emit()

    def leaveEvent(self, event: QEvent) -> None:
        """Report that the cursor is on no pixel."""
        super().leaveEvent(event)
        self.cursorLeft.emit()

    def _on_box_moved_by_hand(self, *_: object) -> None:
        width, height = self._item.frame_size
        seen = self._box.viewRect()
        if width and height:
            self.moved.emit(
                QRectF(seen.x() / width, seen.y() / height, seen.width() / width, seen.height() / height)
            )

    def _caption(self) -> None:
        text = place_scale(self.scaleBar, self.rect())
        self.caption.setParts(self._name, self._value, text)
