"""The canvas of the image: zoom, pan, fit, the pixel under the cursor, and the tool that draws on it."""

from __future__ import annotations

import math

import pyqtgraph as pg
from PyQt5.QtCore import QEvent, QPointF, QRect, QRectF, Qt, pyqtSignal
from PyQt5.QtGui import QGuiApplication, QMouseEvent, QResizeEvent
from PyQt5.QtWidgets import QWidget

from grabbergui.core.pixels import DisplayImage, Region
from grabbergui.ui.widgets.image_items import DIMMED, ImageItem
from grabbergui.ui.widgets.image_overlays import ImageMarks, PixelValues

MAXIMUM_ZOOM = 64.0
"Screen pixels for one pixel of the frame, on a screen at 100 %."
MINIMUM_FRACTION = 0.25
"Smallest zoom, as a share of the size that fits."


class ImageCanvas(pg.GraphicsView):  # type: ignore[misc]  # the library has no types
    """Shows an image; wheel zooms about the cursor, dragging pans, a double click fits.

    It reports the visible part of the frame and its size on the screen; the image is made elsewhere.
    """

    viewChanged = pyqtSignal(object, object)
    """The visible Region of the frame, and (width, height) in screen pixels that it takes."""
    zoomChanged = pyqtSignal(float, bool)
    """Screen pixels for one of the frame (0 without an image), and whether the image is kept fitted."""
    cursorMoved = pyqtSignal(int, int)
    """Column and line under the cursor."""
    cursorLeft = pyqtSignal()
    """The cursor left the image."""
    painted = pyqtSignal()
    """An image has reached the screen."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent, background=None)
        self.setFrameShape(self.NoFrame)
        self._box = pg.ViewBox(lockAspect=True, invertY=True, enableMenu=False, defaultPadding=0)
        self._box.setBorder(None)
        self._item = ImageItem(self.painted.emit)
        self._fitted = True
        self._empty = True
        self._cursor: tuple[int, int] | None = None
        self._pointer: QPointF | None = None
        "Where in this widget the mouse is."
        self.setCentralItem(self._box)
        self.marks = ImageMarks()
        """Lines over the image."""
        self.values = PixelValues()
        """Values written on single pixels."""
        self._box.addItem(self._item, ignoreBounds=True)
        self._box.addItem(self.marks, ignoreBounds=True)
        self._box.addItem(self.values, ignoreBounds=True)
        self._box.disableAutoRange()
        self._box.sigRangeChanged.connect(self._announce)
        self._box.sigRangeChangedManually.connect(self._on_box_moved_by_hand)

    @property
    def zoom(self) -> float:
        """Screen pixels for one pixel of the frame."""
        rect = self._box.viewRect()
        return self._box.width() * self.devicePixelRatioF() / rect.width() if rect.width() > 0 else 1.0

    @property
    def fitted(self) -> bool:
        """Whether the whole image stays in view when the window or the frame changes its size."""
        return self._fitted

    @property
    def cursorPixel(self) -> tuple[int, int] | None:
        """Column and line under the cursor, or None."""
        return self._cursor

    def setImage(self, image: DisplayImage, width: int, height: int) -> None:
        """Show an image of a frame of that size in pixels."""
        other_size = (width, height) != self._item.frame_size
        centre = self.seen.center()
        self._item.setImage(image, width, height)
        self._item.show()
        self.marks.cover(width, height)
        self.values.cover(width, height)
        if other_size or self._empty:
            self._empty = False
            self._limit()
            if self._fitted:
                self.fit()
            else:
                self.centreOn(centre)

    @property
    def empty(self) -> bool:
        """Whether no image is shown."""
        return self._empty

    @property
    def seen(self) -> QRectF:
        """The visible part in fractions of the image; beyond 0 … 1 if the view is larger."""
        return self._item.toFractions(self._box.viewRect())

    def setSeen(self, part: QRectF) -> None:
        """Show this part of the image, in fractions of it, as if the user had moved it."""
        if not self._empty:
            self._fitted = False
            self._box.setRange(self._item.toPixels(part), padding=0)
            self._announce()

    def centreOn(self, place: QPointF) -> None:
        """Show this place in the middle, in fractions of the image, at the same zoom; nothing if fitted."""
        width, height = self._item.frame_size
        if not self._empty and not self._fitted:
            seen = QRectF(self._box.viewRect())
            seen.moveCenter(QPointF(place.x() * width, place.y() * height))
            seen.moveTopLeft(QPointF(round(seen.left()), round(seen.top())))  # as in `_zoom_to`
            self._box.setRange(seen, padding=0)
            self._announce()

    def setCursorAt(self, place: QPointF) -> None:
        """Put the cursor's readout on the pixel at this place, in fractions of the image."""
        width, height = self._item.frame_size
        if not self._empty:
            x, y = math.floor(place.x() * width), math.floor(place.y() * height)
            self._cursor = (min(x, width - 1), min(y, height - 1))
            self.cursorMoved.emit(*self._cursor)

    def follow(self, position: QPointF) -> None:
        """Put the cursor's readout on the pixel at this place in the widget."""
        self._pointer = position
        point = self._box.mapSceneToView(QPointF(self.mapToScene(position.toPoint())))
        x, y = math.floor(point.x()), math.floor(point.y())
        width, height = self._item.frame_size
        if self._empty or not (0 <= x < width and 0 <= y < height):
            self.forgetCursor()
            return
        self._cursor = (x, y)
        self.setCursor(Qt.CursorShape.CrossCursor)
        self.cursorMoved.emit(x, y)

    def forgetCursor(self) -> None:
        """Report that the cursor is on no pixel."""
        if self._cursor is not None:
            self._cursor = None
            self.unsetCursor()
            self.cursorLeft.emit()

    def copyShown(self) -> None:
        """Copy the part of the image that is shown, with what is drawn over it, to the clipboard."""
        width, height = self._item.frame_size
        first, last = self.frameToView(0, 0).toPoint(), self.frameToView(width, height).toPoint()
        shown = QRect(first, last).intersected(self.rect())
        clipboard = QGuiApplication.clipboard()
        if not self._empty and clipboard is not None:
            clipboard.setPixmap(self.grab(shown))

    def toggleFit(self) -> None:
        """Fit, or return to 1:1 if the image is fitted."""
        if self._fitted:
            self.oneToOne()
        else:
            self.fit()

    def setDimmed(self, dimmed: bool) -> None:
        """Dim the image, which is not current."""
        self._item.setOpacity(DIMMED if dimmed else 1.0)

    def addOverlay(self, item: pg.GraphicsObject) -> None:
        """Add an item over the image, in its coordinates."""
        self._box.addItem(item, ignoreBounds=True)

    def clear(self) -> None:
        """Show nothing."""
        self._item.hide()
        self._item.clear()
        self.marks.cover(0, 0)
        self.values.setTexts({})
        self._empty = True
        self.zoomChanged.emit(0.0, self._fitted)

    def fit(self) -> None:
        """Show all of the frame, and keep showing all of it."""
        self._fitted = True
        width, height = self._item.frame_size
        if width and height:
            self._box.setRange(QRectF(0, 0, width, height), padding=0)
            self._announce()

    def oneToOne(self) -> None:
        """Show one screen pixel for each pixel of the frame, about the same centre."""
        self._zoom_to(1.0)

    def zoomBy(self, factor: float) -> None:
        """Zoom by a factor about the same centre."""
        self._zoom_to(self.zoom * factor)

    def frameToView(self, x: float, y: float) -> QPointF:
        """Return the place of a point of the frame in this widget."""
        return QPointF(self.mapFromScene(self._box.mapViewToScene(QPointF(x, y))))

    def viewToFrame(self, position: QPointF) -> QPointF:
        """Return the point of the image at a place in this widget, or the nearest one."""
        point = self._box.mapSceneToView(QPointF(self.mapToScene(position.toPoint())))
        width, height = self._item.frame_size
        return QPointF(min(max(point.x(), 0.0), width), min(max(point.y(), 0.0), height))

    def viewToImage(self, position: QPointF) -> QPointF:
        """Return the point at a place in this widget in the image's pixels, also beside the image."""
        return QPointF(self._box.mapSceneToView(QPointF(self.mapToScene(position.toPoint()))))

    @property
    def imageSize(self) -> tuple[int, int]:
        """Width and height of the whole image in its own pixels."""
        return self._item.frame_size

    def changeEvent(self, event: QEvent | None) -> None:
        """Paint what is around the image in the colour of another theme; perhaps no frame follows."""
        super().changeEvent(event)
        if event is not None and event.type() in (QEvent.Type.PaletteChange, QEvent.Type.StyleChange):
            self.resetCachedContent()
            self.viewport().update()

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Keep the image fitted, or else its zoom."""
        zoom, fitted = (self.zoom, self._fitted) if hasattr(self, "_item") else (1.0, False)
        super().resizeEvent(event)
        if hasattr(self, "_item") and not self._empty:
            self._limit()
            if fitted:
                self.fit()
            else:
                self._zoom_to(zoom)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Follow the cursor. pyqtgraph's own signal leaves out moves that come fast, the last one too."""
        super().mouseMoveEvent(event)
        self.follow(event.localPos())

    def leaveEvent(self, event: QEvent) -> None:
        """Report that the cursor is on no pixel."""
        super().leaveEvent(event)
        self._pointer = None
        self.forgetCursor()

    def mouseDoubleClickEvent(self, event: QEvent) -> None:
        """Toggle between fitted and 1:1."""
        super().mouseDoubleClickEvent(event)
        self.toggleFit()

    def _zoom_to(self, zoom: float) -> None:
        if self._empty:
            return
        self._fitted = False
        ratio = self.devicePixelRatioF()
        scale = ratio / min(max(zoom, self._least()), MAXIMUM_ZOOM * ratio)
        width, height = self._box.width() * scale, self._box.height() * scale
        centre = self._box.viewRect().center()
        # A whole pixel at the corner, so that pixels of frame and screen coincide at 1:1.
        left, top = round(centre.x() - width / 2), round(centre.y() - height / 2)
        self._box.setRange(QRectF(left, top, width, height), padding=0)
        self._announce()

    def _least(self) -> float:
        width, height = self._item.frame_size
        if not width or not height:
            return 0.01
        fits = min(self._box.width() / width, self._box.height() / height) * self.devicePixelRatioF()
        return float(min(1.0, fits) * MINIMUM_FRACTION)

    def _limit(self) -> None:
        least, ratio = self._least(), self.devicePixelRatioF()
        self._box.setLimits(
            minXRange=self._box.width() / MAXIMUM_ZOOM,
            maxXRange=self._box.width() * ratio / least,
        )

    def _announce(self, *_: object) -> None:
        if self._empty:
            return
        frame = QRectF(0, 0, *self._item.frame_size)
        seen = self._box.viewRect().intersected(frame)
        zoom = self.zoom
        self.zoomChanged.emit(zoom, self._fitted)
        if self._pointer is not None:  # another pixel is there now
            self.follow(self._pointer)
        if seen.isEmpty():
            return
        left, top = math.floor(seen.left()), math.floor(seen.top())
        region = Region(left, top, math.ceil(seen.right()) - left, math.ceil(seen.bottom()) - top)
        size = (max(1, round(region.width * zoom)), max(1, round(region.height * zoom)))
        self.viewChanged.emit(region, size)

    def _on_box_moved_by_hand(self, *_: object) -> None:
        self._fitted = False
        self._announce()
