"""Items of images: the image, and over it values of pixels, crosshair, grid, regions, and the cursor."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

import pyqtgraph as pg
from PyQt5.QtCore import QPointF, QRectF
from PyQt5.QtGui import QImage, QPainter
from PyQt5.QtWidgets import QStyleOptionGraphicsItem, QWidget
from PyQt5.sip import voidptr

from grabbergui.core.pixels import DisplayImage

DIMMED = 0.35
"Opacity of an image that is not current."


class ImageItem(pg.GraphicsObject):  # type: ignore[misc]  # the library has no types
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

    def toPixels(self, part: QRectF) -> QRectF:
        """Return a part of the frame, given in fractions of it, in the frame's pixels."""
        width, height = self._size
        return QRectF(part.x() * width, part.y() * height, part.width() * width, part.height() * height)

    def toFractions(self, rect: QRectF) -> QRectF:
        """Return a rectangle in fractions of the frame; (0, 0, 1, 1) while there is no frame."""
        width, height = self._size
        if not width or not height:
            return QRectF(0, 0, 1, 1)
        return QRectF(rect.x() / width, rect.y() / height, rect.width() / width, rect.height() / height)

    def setImage(self, image: DisplayImage, width: int, height: int) -> None:
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
