"""What lies over a picture and is as large as it."""

from __future__ import annotations

import pyqtgraph as pg
from PyQt5.QtCore import QRectF


class PictureOverlay(pg.GraphicsObject):  # type: ignore[misc]  # the library has no types
    """An item in the picture's coordinates: x to the right, y down, one unit a pixel."""

    def __init__(self, level: float) -> None:
        """`level` is its place among what lies over the picture: the higher, the further in front."""
        super().__init__()
        self.setZValue(level)
        self._bounds = QRectF()

    def cover(self, width: int, height: int) -> None:
        """Be as large as a picture of that size, and be painted anew."""
        bounds = QRectF(0, 0, width, height)
        if bounds != self._bounds:
            self.prepareGeometryChange()
            self._bounds = bounds
        self.update()

    def boundingRect(self) -> QRectF:
        """The whole picture."""
        return self._bounds
