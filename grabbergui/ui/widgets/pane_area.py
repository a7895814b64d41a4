"""One canvas, or all components of a frame side by side, zoomed and panned together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from PyQt5.QtCore import QEvent, QObject, QPointF, QRect, QRectF, pyqtSignal
from PyQt5.QtGui import QPainter, QPaintEvent, QPen, QResizeEvent
from PyQt5.QtWidgets import QGridLayout, QWidget

from grabbergui.core.pixels import DisplayImage
from grabbergui.models.image.components import ShownImage
from grabbergui.ui.widgets.component_pane import WHOLE, ComponentPane, PaneCaption, columns_for
from grabbergui.ui.widgets.image_canvas import ImageCanvas
from grabbergui.ui.widgets.image_overlays import CursorMark

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
        self._separate = False
        self._parts: dict[str, QRectF] = {}
        "The parts that were last seen of each component, while each pane has a zoom of its own."

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
            before, self._names, self._chosen = self._chosen, names, chosen
            self._keep_parts(before)
            self._make_panes(by_name)
        for name, shown in by_name.items():
            pane = self._panes[name]
            pane.setImage(name, shown.image, shown.width, shown.height)
            pane.setScale(shown.quantity.scale if shown.quantity is not None else None)
            if self._canvas is not None and not self._separate:
                pane.setSeen(self._canvas.seen)

    def setSeparate(self, separate: bool) -> None:
        """Give each pane a zoom of its own, or the canvas's to all."""
        if separate != self._separate:
            self._keep_parts(self._chosen)
            self._separate = separate
            for pane in self._panes.values():
                pane.setOwnZoom(separate)
            self._follow_canvas()

    @property
    def separate(self) -> bool:
        """Whether each pane has a zoom of its own."""
        return self._separate

    def _keep_parts(self, before: str) -> None:
        """Let each component keep its zoom when canvas and pane change places; `before` was in the canvas."""
        if not self._separate:
            return
        self._parts |= {name: pane.seen for name, pane in self._panes.items()}
        if before != self._chosen:
            self._restore(self._part_of_chosen())

    def forgetParts(self) -> None:
        """Forget what was seen of each component."""
        self._parts.clear()

    def setImage(self, image: DisplayImage, width: int, height: int) -> None:
        """Show an image of the chosen component in the canvas; the first one at the zoom that it last had."""
        if self._canvas is None:
            return
        # Read before: an empty canvas still has the zoom of another component, and will announce it.
        part = self._part_of_chosen() if self._canvas.empty else None
        self._canvas.setImage(image, width, height)
        if part is not None:
            self._restore(part)

    def _part_of_chosen(self) -> QRectF:
        """Return the part of the chosen component that was last seen."""
        return self._parts.get(self._chosen, WHOLE)

    def _restore(self, part: QRectF) -> None:
        """Show this part in the canvas, if each component has a zoom of its own."""
        if self._separate and self._canvas is not None:
            if part.width() < 1 or part.height() < 1:
                self._canvas.setSeen(part)
            else:
                self._canvas.fit()

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
        if self._separate:
            pane.setOwnZoom(True)
            pane.showPart(self._parts.get(name, WHOLE))
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
        canvas = self._canvas
        if canvas is None:
            return
        if self._separate:
            if not canvas.empty:  # an empty one announces the zoom of what it showed before
                self._parts[self._chosen] = canvas.seen
        elif self._panes:
            seen: QRectF = canvas.seen
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
