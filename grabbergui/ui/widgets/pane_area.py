"""One canvas, or all components of a frame side by side, zoomed and panned together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import pyqtgraph as pg
from PyQt5.QtCore import QEvent, QObject, QPointF, QRect, QRectF, Qt, pyqtSignal
from PyQt5.QtGui import QColor, QMouseEvent, QPainter, QPaintEvent, QPen, QResizeEvent
from PyQt5.QtWidgets import QApplication, QGridLayout, QWidget

from grabbergui.core.pixels import DisplayImage
from grabbergui.models.image.components import ShownImage
from grabbergui.models.image.quantities import ColourScale
from grabbergui.ui.widgets.image_canvas import ImageCanvas
from grabbergui.ui.widgets.image_items import DIMMED, CursorMark, ImageItem
from grabbergui.ui.widgets.plots import SCALE_MARGIN, ScaleBar, place_scale

# -- one pane ------------------------------------------------------------------------------------
_PAD = 6
"Between a caption and its edge, pixels."


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
        self._item.setImage(image, width, height)
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

    # -- Qt's own --------------------------------------------------------------------------------
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
        if all(self._item.frame_size):
            self.moved.emit(self._item.toFractions(self._box.viewRect()))

    def _caption(self) -> None:
        text = place_scale(self.scaleBar, self.rect())
        self.caption.setParts(self._name, self._value, text)


def columns_for(count: int, width: int, height: int, aspect: float) -> int:
    """Return the number of columns in which `count` images of that aspect (width / height) are largest."""

    def size(columns: int) -> float:
        lines = -(-count // columns)
        return min(width / columns / aspect, height / lines)

    return max(range(1, max(1, count) + 1), key=size)


# -- all panes -----------------------------------------------------------------------------------
GAP = 4
"Pixels between two panes."
FRAME = 2
"Pixels of the frame around the chosen one."


class PaneArea(QWidget):
    """Lays out panes around the canvas, which always shows the chosen component and has all tools.

    A component keeps its place: if another is chosen, canvas and pane change places.
    """

    paneChosen = pyqtSignal(str)
    """The name of the component that the user clicked on."""
    canvasPlaced = pyqtSignal()
    """The canvas was moved or resized."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._canvas: ImageCanvas | None = None
        self._panes: dict[str, ComponentPane] = {}
        self._names: tuple[str, ...] = ()
        self._chosen = ""
        self._columns = 0
        self._scale_text = self._value = ""

    def take(self, canvas: ImageCanvas) -> None:
        """Take the canvas, which is in this widget's grid already."""
        self._canvas = canvas
        self.caption = PaneCaption(canvas)
        """Name and value of the chosen component, while others are beside it."""
        self._mark = CursorMark()
        canvas.addOverlay(self._mark)
        canvas.installEventFilter(self)
        canvas.zoomChanged.connect(self._follow_canvas)
        canvas.cursorMoved.connect(self._on_canvas_cursor_moved)
        canvas.cursorLeft.connect(lambda: self._mark_cursor(None, None))

    @property
    def panes(self) -> Mapping[str, ComponentPane]:
        """The panes beside the canvas, by the names of their components."""
        return self._panes

    @property
    def canvasPlace(self) -> QRect:
        """The canvas's rectangle in the parent's coordinates."""
        assert self._canvas is not None
        place: QRect = self._canvas.geometry()
        return place.translated(self.pos())

    def setImages(self, order: Sequence[str], chosen: str, images: Sequence[ShownImage]) -> None:
        """Show these components beside the chosen one, in the frame's order; with none, the canvas alone."""
        by_name = {shown.label: shown for shown in images}
        names = tuple(name for name in order if name == chosen or name in by_name) if by_name else ()
        if (names, chosen) != (self._names, self._chosen):
            self._names, self._chosen = names, chosen
            self._make_panes(by_name)
        for name, shown in by_name.items():
            pane = self._panes[name]
            pane.setImage(name, shown.image, shown.width, shown.height)
            pane.setScale(shown.quantity.scale if shown.quantity is not None else None)
            if self._canvas is not None:
                pane.setSeen(self._canvas.seen)

    def setScaleText(self, text: str) -> None:
        """Show the scale of the chosen component as text, or none."""
        self._scale_text = text
        self._show_caption()

    def setValueTexts(self, values: Mapping[str, str]) -> None:
        """Show the values under the cursor, by the names of their components."""
        self._value = values.get(self._chosen, "")
        self._show_caption()
        for name, pane in self._panes.items():
            pane.setValueText(values.get(name, ""))

    def setDimmed(self, dimmed: bool) -> None:
        """Dim all panes, which are not current."""
        for pane in self._panes.values():
            pane.setDimmed(dimmed)

    # -- Qt's own --------------------------------------------------------------------------------
    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Arrange the panes so that their images are as large as possible."""
        super().resizeEvent(event)
        if self._panes:
            self._arrange()

    def eventFilter(self, watched: QObject | None, event: QEvent | None) -> bool:
        """Follow the canvas when the layout moves it."""
        if event is not None and event.type() in (QEvent.Type.Move, QEvent.Type.Resize):
            self.caption.arrange()
            self.canvasPlaced.emit()
            self.update()
        return super().eventFilter(watched, event)

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Frame the chosen component."""
        if not self._panes or self._canvas is None:
            return
        painter = QPainter(self)
        painter.setPen(QPen(self.palette().highlight().color(), FRAME))
        painter.drawRect(self._canvas.geometry().adjusted(-1, -1, 0, 0))

    # -- inside ----------------------------------------------------------------------------------
    def _make_panes(self, wanted: Mapping[str, ShownImage]) -> None:
        for name in [name for name in self._panes if name not in wanted]:
            pane = self._panes.pop(name)
            pane.hide()
            pane.setParent(None)
            pane.deleteLater()
        for name in wanted:
            if name not in self._panes:
                self._panes[name] = self._new_pane(name)
        if not self._panes:
            self._value = self._scale_text = ""
            self._mark.hide()
        self._columns = 0
        self._arrange()
        self._show_caption()

    def _new_pane(self, name: str) -> ComponentPane:
        pane, canvas = ComponentPane(self), self._canvas
        assert canvas is not None
        pane.chosen.connect(lambda: self.paneChosen.emit(name))
        pane.moved.connect(canvas.setSeen)
        pane.fitToggled.connect(canvas.toggleFit)
        pane.cursorMoved.connect(lambda place: self._on_pane_cursor_moved(pane, place))
        pane.cursorLeft.connect(canvas.forgetCursor)
        return pane

    def _arrange(self) -> None:
        grid, canvas = self.layout(), self._canvas
        if not isinstance(grid, QGridLayout) or canvas is None:
            return
        count = len(self._names) or 1
        width, height = canvas.imageSize
        columns = columns_for(count, self.width(), self.height(), width / height if height else 4 / 3)
        if columns == self._columns:
            return
        self._columns = columns
        margin = FRAME if self._panes else 0
        grid.setContentsMargins(margin, margin, margin, margin)
        grid.setSpacing(GAP if self._panes else 0)
        for index, name in enumerate(self._names or (self._chosen,)):
            pane = canvas if name == self._chosen else self._panes[name]
            grid.removeWidget(pane)
            grid.addWidget(pane, index // columns, index % columns)
            pane.show()
        lines = -(-count // columns)
        for line in range(max(lines, grid.rowCount())):
            grid.setRowStretch(line, int(line < lines))
        for column in range(max(columns, grid.columnCount())):
            grid.setColumnStretch(column, int(column < columns))
        self.update()

    def _show_caption(self) -> None:
        name = self._chosen if self._panes else ""
        self.caption.setParts(name, self._value, self._scale_text)

    def _follow_canvas(self, *_: object) -> None:
        if self._panes and self._canvas is not None:
            seen: QRectF = self._canvas.seen
            for pane in self._panes.values():
                pane.setSeen(seen)

    def _on_canvas_cursor_moved(self, x: int, y: int) -> None:
        canvas = self._canvas
        if self._panes and canvas is not None and canvas.underMouse():
            width, height = canvas.imageSize
            self._mark_cursor(QPointF((x + 0.5) / width, (y + 0.5) / height), None)

    def _on_pane_cursor_moved(self, pane: ComponentPane, place: QPointF) -> None:
        if self._canvas is not None:
            self._canvas.setCursorAt(place)
            self._mark_cursor(place, pane)

    def _mark_cursor(self, place: QPointF | None, source: ComponentPane | None) -> None:
        """Mark a place in all images but the one that the cursor is on: a pane, or the canvas if None."""
        for pane in self._panes.values():
            pane.setMark(None if pane is source else place)
        self._mark.setVisible(place is not None and source is not None)
        if place is not None and self._canvas is not None:
            width, height = self._canvas.imageSize
            self._mark.setPos(place.x() * width, place.y() * height)
