"""The pane of one component, with its caption."""

from __future__ import annotations

import pyqtgraph as pg
from PyQt5.QtCore import QEvent, QPointF, QRect, QRectF, Qt, pyqtSignal
from PyQt5.QtGui import QColor, QMouseEvent, QPainter, QPaintEvent, QResizeEvent
from PyQt5.QtWidgets import QApplication, QWidget

from grabbergui.core.pixels import DisplayImage
from grabbergui.models.image.quantities import ColourScale
from grabbergui.ui.widgets.image_items import DIMMED, ImageItem
from grabbergui.ui.widgets.image_overlays import CursorMark
from grabbergui.ui.widgets.scale_bar import SCALE_MARGIN, ScaleBar, place_scale

_PAD = 6
"Between a caption and its edge, pixels."
WHOLE = QRectF(0, 0, 1, 1)
"All of an image, in fractions of it."


class PaneCaption(QWidget):
    """The name of a component over its image, its value under the cursor, and a scale that has no room."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self._parts = ("", "", "")
        self._lines: list[str] = []
        self.hide()

    @property
    def text(self) -> str:
        """The text that is painted, elided where the pane is too narrow."""
        room = self.width() - 2 * _PAD
        elide = self.fontMetrics().elidedText
        return "\n".join(elide(line, Qt.TextElideMode.ElideRight, room) for line in self._lines)

    def setParts(self, name: str, value: str, scale: str) -> None:
        """Show name, value and scale; nothing without a name."""
        if (name, value, scale) != self._parts:
            self._parts = (name, value, scale)
            self.arrange()

    def arrange(self) -> None:
        """Fit the text into the width of the image, in one line or several."""
        self.ensurePolished()  # the style sheet may set another font
        name, value, scale = self._parts
        room = self._room()
        first = f"{name}   {value}" if value else name
        long = self.fontMetrics().horizontalAdvance(first) > room
        self._lines = [line for line in ([name, value, scale] if long else [first, scale]) if line]
        # Rounded up, as the pixel that `horizontalAdvance` may round off is missed by `elidedText`.
        width = max((self.fontMetrics().horizontalAdvance(line) + 1 for line in self._lines), default=0)
        height = self.fontMetrics().height() * len(self._lines)
        self.setGeometry(SCALE_MARGIN, SCALE_MARGIN, min(width, room) + 2 * _PAD, height + _PAD)
        self.setVisible(bool(name))
        self.update()

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Write it bright over dark, to be read on any image."""
        painter, line = QPainter(self), self.fontMetrics().height()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor(0, 0, 0, 150))
        painter.drawRoundedRect(QRectF(self.rect()), 4, 4)
        painter.setPen(QColor(255, 255, 255))
        for index, text in enumerate(self.text.splitlines()):
            top = _PAD // 2 + index * line
            painter.drawText(QRect(_PAD, top, self.width(), line), Qt.AlignmentFlag.AlignLeft, text)

    def _room(self) -> int:
        parent = self.parentWidget()
        return max(40, (parent.width() if parent is not None else 0) - 2 * SCALE_MARGIN - 2 * _PAD)


class ComponentPane(pg.GraphicsView):  # type: ignore[misc]  # the library has no types
    """Shows a part of a component. Wheel and dragging move it, which its owner passes on to all panes.

    With `setOwnZoom` it shows the part that the user chose in it, all of the image at first.
    Places are fractions of the image, as components may differ in size.
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
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)  # letters are keys of the chosen image
        self.setMinimumSize(60, 40)
        self._box = pg.ViewBox(lockAspect=True, invertY=True, enableMenu=False, defaultPadding=0)
        self._box.setBorder(None)
        self._item = ImageItem(lambda: None)
        self._pressed: QPointF | None = None
        self._own_zoom = False
        self._part = WHOLE
        "The image's own zoom, or a part of it."
        self.mark = CursorMark()
        self.setCentralItem(self._box)
        self._box.addItem(self._item, ignoreBounds=True)
        self._box.addItem(self.mark, ignoreBounds=True)
        self._box.disableAutoRange()
        self._box.sigRangeChangedManually.connect(self._on_box_moved_by_hand)
        self.caption = PaneCaption(self)
        self.scaleBar = ScaleBar(self)
        self._name = self._value = ""

    def setImage(self, name: str, image: DisplayImage, width: int, height: int) -> None:
        """Show an image of a component of that name and size in pixels."""
        other = (width, height) != self._item.frame_size
        self._item.setImage(image, width, height)
        if other and self._own_zoom:
            self.setSeen(self._part)
        if name != self._name:
            self._name = name
            self.setAccessibleName(name)
            self._caption()

    def setScale(self, scale: ColourScale | None) -> None:
        """Show the scale of false colours; None for an intensity image."""
        if self.scaleBar.setScale(scale):
            self._caption()

    def setValueText(self, text: str) -> None:
        """Show the value under the cursor."""
        if text != self._value:
            self._value = text
            self._caption()

    def setDimmed(self, dimmed: bool) -> None:
        """Dim the image, which is not current."""
        self._item.setOpacity(DIMMED if dimmed else 1.0)

    @property
    def seen(self) -> QRectF:
        """The visible part in fractions of the image; beyond 0 … 1 if the view is larger."""
        return self._item.toFractions(self._box.viewRect())

    def setOwnZoom(self, own: bool) -> None:
        """Let the pane have a zoom of its own, beginning with what it shows now."""
        if own != self._own_zoom:
            self._own_zoom = own
            self._part = self.seen if own and all(self._item.frame_size) else WHOLE

    def showPart(self, part: QRectF) -> None:
        """Show this part of the image as if the user had chosen it here; never more than all of it."""
        self._part = WHOLE if part.width() >= 1 and part.height() >= 1 else part
        self.setSeen(self._part)

    def setSeen(self, part: QRectF) -> None:
        """Show this part of the image."""
        seen = self._item.toPixels(part)
        if not seen.isEmpty() and seen != self._box.viewRect():
            self._box.setRange(seen, padding=0)

    def setMark(self, place: QPointF | None) -> None:
        """Mark a place of the image, or none."""
        self.mark.setVisible(place is not None)
        if place is not None:
            width, height = self._item.frame_size
            self.mark.setPos(place.x() * width, place.y() * height)

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Keep the scale at the edge."""
        super().resizeEvent(event)
        if hasattr(self, "scaleBar"):
            if self._own_zoom:
                self.setSeen(self._part)
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
        """Toggle between fitted and 1:1; with a zoom of its own, fit."""
        super().mouseDoubleClickEvent(event)
        if self._own_zoom:
            self.showPart(WHOLE)
        else:
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
        if self._own_zoom:
            self.showPart(self.seen)
        elif all(self._item.frame_size):
            self.moved.emit(self.seen)

    def _caption(self) -> None:
        text = place_scale(self.scaleBar, self.rect())
        self.caption.setParts(self._name, self._value, text)


def columns_for(count: int, width: int, height: int, aspect: float) -> int:
    """Return the number of columns in which `count` images of that aspect (width / height) are largest."""

    def size(columns: int) -> float:
        lines = -(-count // columns)
        return min(width / columns / aspect, height / lines)

    return max(range(1, max(1, count) + 1), key=size)
