"""Items that paint images and text: in the canvas, as thumbnails, over single pixels."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

import pyqtgraph as pg
from PyQt5.QtCore import QPointF, QRectF, QSize, Qt
from PyQt5.QtGui import QColor, QFont, QImage, QPainter, QPaintEvent
from PyQt5.QtWidgets import QStyle, QStyleOption, QStyleOptionGraphicsItem, QWidget
from PyQt5.sip import voidptr

from grabbergui.core.pixels import DisplayImage


class PictureItem(pg.GraphicsObject):  # type: ignore[misc]  # the library has no types
    """A frame in a scene whose unit is the frame's pixel.

    The image covers what the view showed when it was asked for and has about the screen's resolution, so
    painting is mostly a copy. Enlarged, its pixels stay sharp squares.
    """

    def __init__(self, painted: Callable[[], None]) -> None:
        super().__init__()
        self._painted = painted
        self._fresh = False
        self._size = (0, 0)
        self._image: QImage | None = None
        self._target = QRectF()

    @property
    def frame_size(self) -> tuple[int, int]:
        """Width and height of the whole frame."""
        return self._size

    def setPicture(self, image: DisplayImage, width: int, height: int) -> None:
        """Show an image of a frame of that size."""
        if (width, height) != self._size:
            self.prepareGeometryChange()
            self._size = (width, height)
        self._image = as_qimage(image)
        region = image.region
        self._target = QRectF(region.x, region.y, region.width, region.height)
        self._fresh = True
        self.update()

    def clear(self) -> None:
        """Show nothing."""
        self._image = None
        self.update()

    def boundingRect(self) -> QRectF:
        """The whole frame."""
        return QRectF(0, 0, *self._size)

    def paint(
        self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None
    ) -> None:
        """Draw the image, pixel by pixel where it has the screen's resolution."""
        image = self._image
        if image is None:
            return
        place = painter.worldTransform().mapRect(self._target)
        device = painter.device()
        ratio = device.devicePixelRatioF() if device is not None else 1.0
        if (
            abs(place.width() * ratio - image.width()) < 2
            and abs(place.height() * ratio - image.height()) < 2
        ):
            painter.resetTransform()
            image.setDevicePixelRatio(ratio)
            # A whole device pixel: between two, every pixel would be interpolated.
            painter.drawImage(
                QPointF(round(place.x() * ratio) / ratio, round(place.y() * ratio) / ratio), image
            )
        else:
            image.setDevicePixelRatio(1.0)
            painter.setRenderHint(QPainter.SmoothPixmapTransform, False)
            painter.drawImage(self._target, image)
        if self._fresh:
            self._fresh = False
            self._painted()


def as_qimage(image: DisplayImage) -> QImage:
    """Return a QImage over the same bytes, which live as long as it does."""
    pixels = image.pixels
    height, width = pixels.shape[:2]
    kind = QImage.Format_RGB888 if pixels.ndim == 3 else QImage.Format_Grayscale8
    qimage: Any = QImage(voidptr(pixels.ctypes.data), width, height, pixels.strides[0], kind)
    qimage.pixels = pixels  # QImage does not own the bytes
    return cast(QImage, qimage)


class PictureOverlay(pg.GraphicsObject):  # type: ignore[misc]  # the library has no types
    """An item in the picture's coordinates: x to the right, y down, one unit a pixel."""

    def __init__(self, level: float) -> None:
        """`level` is its place among what lies over the picture: the higher, the further in front."""
        super().__init__()
        self.setZValue(level)
        self._bounds = QRectF()

    def cover(self, width: int, height: int) -> None:
        """Cover a picture of that size, and repaint."""
        bounds = QRectF(0, 0, width, height)
        if bounds != self._bounds:
            self.prepareGeometryChange()
            self._bounds = bounds
        self.update()

    def boundingRect(self) -> QRectF:
        """The whole picture."""
        return self._bounds


LEGIBLE_ZOOM = 40.0
"Screen pixels per pixel of the picture from which its value has room."
_LINE = 12
"Height of a line of text, pixels."
_BEHIND = QColor(0, 0, 0, 150)
"Outline of the text: it must stand out from white pixels too."


class PixelValues(pg.GraphicsObject):  # type: ignore[misc]  # the library has no types
    """Text on single pixels of the picture as it is displayed."""

    def __init__(self) -> None:
        super().__init__()
        self.setZValue(5)
        self._size = (0, 0)
        self._texts: dict[tuple[int, int], str] = {}

    @property
    def texts(self) -> dict[tuple[int, int], str]:
        """The texts shown, by column and line."""
        return self._texts

    def setSize(self, width: int, height: int) -> None:
        """The size of the picture."""
        if (width, height) != self._size:
            self.prepareGeometryChange()
            self._size = (width, height)

    def setTexts(self, texts: dict[tuple[int, int], str]) -> None:
        """Replace the texts, by column and line."""
        if texts or self._texts:
            self._texts = texts
            self.update()

    def boundingRect(self) -> QRectF:
        """The whole picture."""
        return QRectF(0, 0, *self._size)

    def paint(
        self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None
    ) -> None:
        """Write each text in the middle of its pixel."""
        if not self._texts:
            return
        to_screen = painter.worldTransform()
        painter.resetTransform()
        font = QFont(painter.font())
        font.setPixelSize(_LINE - 1)
        painter.setFont(font)
        painter.setPen(QColor(255, 255, 255))
        for (x, y), text in self._texts.items():
            pixel = to_screen.mapRect(QRectF(x, y, 1, 1))
            place = painter.boundingRect(pixel, Qt.AlignmentFlag.AlignCenter, text)
            painter.fillRect(place.adjusted(-3, -1, 3, 1), _BEHIND)
            painter.drawText(pixel, Qt.AlignmentFlag.AlignCenter, text)


DIMMED = 0.35
"Opacity of a picture that is not current."


class Thumbnail(QWidget):
    """Paints one image in the middle, in its own proportions; without zoom or readout."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._image: QImage | None = None
        self._dimmed = False

    @property
    def image(self) -> QImage | None:
        """The image shown."""
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
        """Return the screen pixels that a picture of that size takes here."""
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
