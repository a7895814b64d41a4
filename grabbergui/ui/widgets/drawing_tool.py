"""The tool that draws on the image: regions, lines."""

from __future__ import annotations

import math
from enum import Enum

from PyQt5.QtCore import QEvent, QLineF, QObject, QPointF, QRectF, Qt, pyqtSignal
from PyQt5.QtGui import QKeyEvent, QMouseEvent

from grabbergui.core.pixels import Region
from grabbergui.models.measuring import Line
from grabbergui.ui.widgets.image_canvas import ImageCanvas
from grabbergui.ui.widgets.image_overlays import Mark

LEAST_DRAG = 2.0
"Shortest drag in pixels of the image; a shorter one is ignored."


class Purpose(Enum):
    """The shape that is drawn."""

    SENSOR_REGION = "sensor region"
    FOCUS_REGION = "focus region"
    PROFILE_LINE = "profile line"
    EXPOSURE_REGION = "exposure region"
    BALANCE_REGION = "balance region"


class DrawingTool(QObject):
    """Takes the mouse from the canvas, from `begin` until a shape is drawn or Escape is pressed."""

    regionDrawn = pyqtSignal(Purpose, Region)
    """In pixels of the image as it is displayed, within it."""
    lineDrawn = pyqtSignal(Purpose, Line)
    ended = pyqtSignal()
    """A shape was drawn, or cancelled."""

    def __init__(self, canvas: ImageCanvas) -> None:
        super().__init__(canvas)
        self._canvas = canvas
        self._purpose: Purpose | None = None
        self._start: QPointF | None = None
        canvas.installEventFilter(self)
        viewport = canvas.viewport()
        assert viewport is not None
        viewport.installEventFilter(self)

    @property
    def purpose(self) -> Purpose | None:
        """The shape in progress."""
        return self._purpose

    @property
    def started(self) -> bool:
        """Whether the drag has begun."""
        return self._start is not None

    def begin(self, purpose: Purpose) -> None:
        """Draw a shape for this purpose with the next drag of the mouse."""
        self._purpose, self._start = purpose, None
        self._canvas.setFocus(Qt.FocusReason.OtherFocusReason)

    def cancel(self) -> None:
        """Cancel; does nothing if nothing is being drawn."""
        if self._purpose is not None:
            self._end()

    def eventFilter(self, watched: QObject | None, event: QEvent | None) -> bool:
        """Keep the events of the drag from the canvas."""
        if self._purpose is None or event is None:
            return False
        if isinstance(event, QKeyEvent) and event.key() == Qt.Key.Key_Escape:
            if event.type() == QEvent.Type.KeyPress:
                self.cancel()
            return True
        if watched is self._canvas or not isinstance(event, QMouseEvent):
            return False
        return self._on_mouse(event)

    def _on_mouse(self, event: QMouseEvent) -> bool:
        point = self._canvas.viewToFrame(event.localPos())
        kind = event.type()
        self._canvas.follow(event.localPos())
        if kind == QEvent.Type.MouseButtonPress and event.button() == Qt.MouseButton.LeftButton:
            self._start = point
        elif kind == QEvent.Type.MouseMove and self._start is not None:
            self._canvas.marks.setShape(Mark.DRAFT, self._shape(self._start, point))
            return True
        elif kind == QEvent.Type.MouseButtonRelease and self._start is not None:
            self._finish(self._start, point)
        return kind != QEvent.Type.MouseMove

    def _shape(self, start: QPointF, end: QPointF) -> QRectF | QLineF:
        if self._purpose is Purpose.PROFILE_LINE:
            return QLineF(start, end)
        return QRectF(start, end).normalized()

    def _finish(self, start: QPointF, end: QPointF) -> None:
        purpose = self._purpose
        assert purpose is not None
        length = QLineF(start, end).length()
        self._end()
        if length < LEAST_DRAG:
            return
        if purpose is Purpose.PROFILE_LINE:
            self.lineDrawn.emit(purpose, Line(int(start.x()), int(start.y()), int(end.x()), int(end.y())))
            return
        box = QRectF(start, end).normalized()
        if box.isEmpty():  # a straight stroke, or one beside the image
            return
        # Every pixel that the box touches.
        left, top = math.floor(box.left()), math.floor(box.top())
        right, bottom = math.ceil(box.right()), math.ceil(box.bottom())
        region = Region(left, top, max(1, right - left), max(1, bottom - top))
        self.regionDrawn.emit(purpose, region.clipped(*self._canvas.imageSize))

    def _end(self) -> None:
        self._purpose = self._start = None
        self._canvas.marks.setShape(Mark.DRAFT, None)
        self.ended.emit()
