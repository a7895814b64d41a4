"""The window of the point cloud: dragging turns it, the wheel zooms."""

from __future__ import annotations

from PyQt5.QtCore import QPoint, QSize, Qt, pyqtSignal
from PyQt5.QtGui import QColor, QHideEvent, QMouseEvent, QPainter, QPaintEvent, QResizeEvent, QWheelEvent
from PyQt5.QtWidgets import QDialog, QVBoxLayout, QWidget

from grabbergui.core.pixels import DisplayImage
from grabbergui.models.picture.points import BACKGROUND
from grabbergui.ui.widgets.picture_items import as_qimage

_DEGREES_PER_PIXEL = 0.4
_WHEEL_STEP = 1.15
_TEXT = QColor(220, 220, 220)


class PointCloudView(QWidget):
    """Paints an image as large as itself; signals for what the mouse does."""

    turned = pyqtSignal(float, float)
    """Degrees to the right and up."""
    zoomed = pyqtSignal(float)
    """A factor; above 1 is nearer."""
    resized = pyqtSignal(int, int)
    """Width and height in pixels of the screen."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._image: DisplayImage | None = None
        self._text = ""
        self._last = QPoint()
        self.setAccessibleName(self.tr("Point cloud"))
        self.setToolTip(self.tr("Drag to turn, wheel to zoom"))
        self.setMinimumSize(240, 180)

    def setImage(self, image: DisplayImage) -> None:
        """Show an image."""
        self._image, self._text = image, ""
        self.update()

    def setProblem(self, text: str) -> None:
        """Show why there is no image."""
        self._image, self._text = None, text
        self.update()

    @property
    def problem(self) -> str:
        """Why there is no image; empty if there is one."""
        return self._text

    def sizeHint(self) -> QSize:
        """Large enough to see something."""
        return QSize(640, 480)

    def mousePressEvent(self, event: QMouseEvent | None) -> None:
        """Begin to turn."""
        if event is not None:
            self._last = event.pos()

    def mouseMoveEvent(self, event: QMouseEvent | None) -> None:
        """Turn with the mouse."""
        if event is not None and event.buttons() & Qt.MouseButton.LeftButton:
            moved, self._last = event.pos() - self._last, event.pos()
            self.turned.emit(moved.x() * _DEGREES_PER_PIXEL, -moved.y() * _DEGREES_PER_PIXEL)

    def wheelEvent(self, event: QWheelEvent | None) -> None:
        """Zoom."""
        if event is not None and event.angleDelta().y():
            self.zoomed.emit(_WHEEL_STEP ** (event.angleDelta().y() / 120))

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Ask for an image of the new size."""
        super().resizeEvent(event)
        ratio = self.devicePixelRatioF()
        self.resized.emit(round(self.width() * ratio), round(self.height() * ratio))

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Draw the image, or the reason why there is none."""
        painter = QPainter(self)
        painter.fillRect(self.rect(), QColor(BACKGROUND, BACKGROUND, BACKGROUND))
        if self._image is not None:
            painter.drawImage(self.rect(), as_qimage(self._image))
        elif self._text:
            painter.setPen(_TEXT)
            flags = int(Qt.AlignmentFlag.AlignCenter) | int(Qt.TextFlag.TextWordWrap)
            painter.drawText(self.rect().adjusted(16, 16, -16, -16), flags, self._text)


class PointCloudDialog(QDialog):
    """Holds the view; stays open beside the window."""

    hidden = pyqtSignal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle(self.tr("Point cloud"))
        self.view = PointCloudView(self)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.view)

    def hideEvent(self, event: QHideEvent | None) -> None:
        """Emit `hidden`."""
        super().hideEvent(event)
        self.hidden.emit()
