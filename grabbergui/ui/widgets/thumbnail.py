"""A small picture that is as large as there is room for."""

from __future__ import annotations

from PyQt5.QtCore import QRectF, QSize, Qt
from PyQt5.QtGui import QImage, QPainter, QPaintEvent
from PyQt5.QtWidgets import QStyle, QStyleOption, QWidget

from grabbergui.core.pixels import DisplayImage
from grabbergui.ui.widgets.picture_item import as_qimage

DIMMED = 0.35
"Opacity of a picture that is not of now."


class Thumbnail(QWidget):
    """Paints one image in the middle, in its own proportions; nothing can be done with it."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._image: QImage | None = None
        self._dimmed = False

    @property
    def image(self) -> QImage | None:
        """What is shown."""
        return self._image

    def setPicture(self, image: DisplayImage | None) -> None:
        """Show an image, or none."""
        self._image = as_qimage(image) if image is not None else None
        self.update()

    def setDimmed(self, dimmed: bool) -> None:
        """Show the image darker."""
        if dimmed != self._dimmed:
            self._dimmed = dimmed
            self.update()

    def roomInPixels(self, width: int, height: int) -> tuple[int, int]:
        """How many pixels of the screen a picture of that size takes here."""
        ratio = self.devicePixelRatioF()
        size = QSize(width, height).scaled(self.size() * ratio, Qt.AspectRatioMode.KeepAspectRatio)
        return max(1, size.width()), max(1, size.height())

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Draw the image, or an empty place."""
        painter, option = QPainter(self), QStyleOption()
        option.initFrom(self)
        if (style := self.style()) is not None:
            style.drawPrimitive(QStyle.PrimitiveElement.PE_Widget, option, painter, self)
        if self._image is None:
            return
        size = self._image.size().scaled(self.size(), Qt.AspectRatioMode.KeepAspectRatio)
        target = QRectF(0, 0, size.width(), size.height())
        target.moveCenter(QRectF(self.rect()).center())
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
        painter.setOpacity(DIMMED if self._dimmed else 1.0)
        painter.drawImage(target, self._image)
