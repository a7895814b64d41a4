"""The tool that moves and resizes the camera's region on the image, by handles."""

from __future__ import annotations

import pyqtgraph as pg
from PyQt5.QtCore import QEvent, QObject, QPointF, QRectF, Qt, pyqtSignal
from PyQt5.QtGui import QColor, QKeyEvent, QMouseEvent, QPainter, QPen
from PyQt5.QtWidgets import QStyleOptionGraphicsItem, QWidget

from grabbergui.core.pixels import Region
from grabbergui.models.image.orientation import Orientation
from grabbergui.models.image.region_edit import Grip, RegionLimits, dragged, grip_at
from grabbergui.ui.widgets.image_canvas import ImageCanvas
from grabbergui.ui.widgets.image_overlays import write_plate

REACH = 9
"Screen pixels from a side within which the mouse takes it."
HANDLE = 9
"Screen pixels of a handle's side."
MARGIN = 0.06
"Part of the image that is shown around it, so that its handles can be taken."
FINE = 1024
"Parts of a pixel in which the mouse is followed."
_INK, _SENSOR = QColor("#ffffff"), QColor(255, 255, 255, 120)


class RegionOverlay(pg.GraphicsObject):  # type: ignore[misc]  # the library has no types
    """The sensor's outline and the region with its handles, in the image's coordinates."""

    def __init__(self) -> None:
        super().__init__()
        self.setZValue(20)
        self.hide()
        self._sensor = self._region = QRectF()
        self._text = ""

    def show_region(self, sensor: QRectF, region: QRectF, text: str) -> None:
        """Show the region, with a text at its corner."""
        self.prepareGeometryChange()
        self._sensor, self._region, self._text = sensor, region, text
        self.update()
        self.show()

    def boundingRect(self) -> QRectF:
        """The sensor and a little more, for handles and lines."""
        reach = 0.1 * max(self._sensor.width(), self._sensor.height())
        return self._sensor.adjusted(-reach, -reach, reach, reach)

    def paint(
        self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None
    ) -> None:
        """Draw bright over dark, to be seen on any image."""
        for ink, width, style in (
            (QColor(0, 0, 0, 110), 3, Qt.PenStyle.SolidLine),
            (_SENSOR, 1, Qt.PenStyle.DashLine),
        ):
            self._frame(painter, self._sensor, ink, width, style)
        for ink, width in ((QColor(0, 0, 0, 160), 3), (_INK, 1)):
            self._frame(painter, self._region, ink, width, Qt.PenStyle.SolidLine)
        place, to_screen = painter.transform().mapRect(self._region), painter.transform()
        painter.resetTransform()
        painter.setPen(QPen(QColor(0, 0, 0, 200), 1))
        painter.setBrush(_INK)
        for x in (place.left(), place.center().x(), place.right()):
            for y in (place.top(), place.center().y(), place.bottom()):
                handle = QRectF(x - HANDLE / 2, y - HANDLE / 2, HANDLE, HANDLE)
                if QPointF(x, y) == place.center():
                    painter.drawEllipse(handle.adjusted(-2, -2, 2, 2))
                else:
                    painter.drawRect(handle)
        write_plate(painter, place.topLeft() + QPointF(HANDLE, HANDLE), self._text)
        painter.setTransform(to_screen)

    @staticmethod
    def _frame(painter: QPainter, rect: QRectF, ink: QColor, width: int, style: Qt.PenStyle) -> None:
        pen = QPen(ink, width, style)
        pen.setCosmetic(True)
        painter.setPen(pen)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.drawRect(rect)


class RegionTool(QObject):
    """Takes the mouse from the canvas where a handle is, from `begin` until Enter or `end`.

    Elsewhere the canvas and its other tools have it, so that another region can be drawn.
    """

    regionChosen = pyqtSignal(Region)
    """A drag ended: the region in pixels of the sensor, as the camera accepts it."""
    ended = pyqtSignal()

    def __init__(self, canvas: ImageCanvas) -> None:
        super().__init__(canvas)
        self._canvas = canvas
        self._overlay = RegionOverlay()
        canvas.addOverlay(self._overlay)
        self._limits: RegionLimits | None = None
        self._frame = Region(0, 0, 1, 1)
        "The part of the sensor that the image shows, in pixels of the sensor."
        self._orientation = Orientation()
        self._region = self._frame
        self._grip: Grip | None = None
        self._from = QPointF()
        "Where the drag began, in pixels of the sensor."
        self._before = self._frame
        canvas.installEventFilter(self)
        viewport = canvas.viewport()
        assert viewport is not None
        viewport.installEventFilter(self)

    @property
    def active(self) -> bool:
        """Whether the region is shown with its handles."""
        return self._limits is not None

    @property
    def region(self) -> Region:
        """The region as it is drawn."""
        return self._region

    def begin(self, frame: Region, limits: RegionLimits, orientation: Orientation) -> None:
        """Show the handles. `frame` is what the image shows, in pixels of the sensor."""
        self._limits = limits
        self._canvas.setFocus(Qt.FocusReason.OtherFocusReason)
        self.setFrame(frame, orientation)

    def setFrame(self, frame: Region, orientation: Orientation) -> None:
        """Follow an image of another part of the sensor; does nothing during a drag."""
        if self._limits is None or self._grip is not None:
            return
        self._frame, self._orientation, self._region = frame, orientation, frame
        self._show()
        # The sensor may be much larger; what is beyond the view can be reached by a drag, or by zooming out.
        self._canvas.setSeen(QRectF(-MARGIN, -MARGIN, 1 + 2 * MARGIN, 1 + 2 * MARGIN))

    def end(self) -> None:
        """Hide the handles; does nothing if they are not shown."""
        if self._limits is not None:
            self._limits = self._grip = None
            self._overlay.hide()
            self._canvas.unsetCursor()
            self._canvas.fit()
            self.ended.emit()

    def eventFilter(self, watched: QObject | None, event: QEvent | None) -> bool:
        """Keep drags of handles, and Enter, from the canvas."""
        if self._limits is None or event is None:
            return False
        if isinstance(event, QKeyEvent) and event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            if event.type() == QEvent.Type.KeyPress:
                self.end()
            return True
        if watched is self._canvas or not isinstance(event, QMouseEvent):
            return False
        return self._on_mouse(event)

    def _on_mouse(self, event: QMouseEvent) -> bool:
        place = self._to_sensor(event.localPos())
        kind = event.type()
        if self._grip is None:
            grip = grip_at(self._region, place.x(), place.y(), REACH * self._pixel())
            if grip is None or event.buttons() & ~Qt.MouseButton.LeftButton:
                return False  # another region is drawn
            self._point(grip)
            if kind == QEvent.Type.MouseButtonPress:
                self._grip, self._from, self._before = grip, place, self._region
            return not event.buttons() or self._grip is not None
        if kind == QEvent.Type.MouseMove and self._limits is not None:
            moved = place - self._from
            self._region = dragged(self._before, self._grip, moved.x(), moved.y(), self._limits)
            self._show()
        elif kind == QEvent.Type.MouseButtonRelease:
            self._grip = None
            if self._region != self._before:
                self.regionChosen.emit(self._region)
        return True

    def _point(self, grip: Grip) -> None:
        """Show by the cursor what a drag from here does."""
        turned = self._orientation.quarter_turns % 2
        mirrored = self._orientation.mirrored_x ^ self._orientation.mirrored_y
        shapes: dict[Grip, tuple[Qt.CursorShape, Qt.CursorShape]] = {
            Grip.MIDDLE: (Qt.CursorShape.SizeAllCursor,) * 2,
            Grip.LEFT: (Qt.CursorShape.SizeHorCursor, Qt.CursorShape.SizeVerCursor),
            Grip.TOP: (Qt.CursorShape.SizeVerCursor, Qt.CursorShape.SizeHorCursor),
            Grip.TOP_LEFT: (Qt.CursorShape.SizeFDiagCursor, Qt.CursorShape.SizeBDiagCursor),
            Grip.TOP_RIGHT: (Qt.CursorShape.SizeBDiagCursor, Qt.CursorShape.SizeFDiagCursor),
        }
        shapes[Grip.RIGHT], shapes[Grip.BOTTOM] = shapes[Grip.LEFT], shapes[Grip.TOP]
        shapes[Grip.BOTTOM_RIGHT] = shapes[Grip.TOP_LEFT]
        shapes[Grip.BOTTOM_LEFT] = shapes[Grip.TOP_RIGHT]
        corner = grip.value.count(True) == 2
        self._canvas.setCursor(shapes[grip][bool(turned) ^ (mirrored and corner)])

    def _show(self) -> None:
        assert self._limits is not None
        region = self._region
        text = f"{region.x}, {region.y}   {region.width} × {region.height}"
        self._overlay.show_region(self._to_view(self._limits.whole), self._to_view(region), text)

    def _pixel(self) -> float:
        """Return how many pixels of the sensor are one of the screen."""
        return float(self._canvas.devicePixelRatioF() / self._canvas.zoom)

    def _to_view(self, region: Region) -> QRectF:
        frame = self._frame
        inside = Region(region.x - frame.x, region.y - frame.y, region.width, region.height)
        seen = self._orientation.to_view(inside, frame.width, frame.height)
        return QRectF(seen.x, seen.y, seen.width, seen.height)

    def _to_sensor(self, position: QPointF) -> QPointF:
        place, fine = self._canvas.viewToImage(position), FINE
        at = Region(round(place.x() * fine), round(place.y() * fine), 0, 0)
        frame = self._frame
        found = self._orientation.to_frame(at, frame.width * fine, frame.height * fine)
        return QPointF(frame.x + found.x / fine, frame.y + found.y / fine)
