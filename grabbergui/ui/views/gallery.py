"""The open sources side by side, while there are several."""

from __future__ import annotations

from PyQt5.QtWidgets import QHBoxLayout, QScrollArea, QWidget

from grabbergui.ui.loader import load_form
from grabbergui.ui.views.camera_tile import CameraTile

TILE_WIDTH = 204
TILE_HEIGHT = 156


class Gallery(QWidget):
    """A row of tiles, in the order they were added; not there while it is empty."""

    scrollArea: QScrollArea
    tilesLayout: QHBoxLayout

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        load_form("gallery", self)
        self._tiles: list[CameraTile] = []
        bar = self.scrollArea.horizontalScrollBar()
        below = bar.sizeHint().height() if bar is not None else 0
        self.setFixedHeight(TILE_HEIGHT + 10 + below // 2)
        self.hide()

    @property
    def tiles(self) -> list[CameraTile]:
        """From left to right."""
        return list(self._tiles)

    def addTile(self) -> CameraTile:
        """One more, on the right."""
        tile = CameraTile(self)
        tile.setFixedSize(TILE_WIDTH, TILE_HEIGHT)
        self.tilesLayout.insertWidget(len(self._tiles), tile)
        self._tiles.append(tile)
        self.show()
        return tile

    def removeTile(self, tile: CameraTile) -> None:
        """Take one away."""
        self._tiles.remove(tile)
        self.tilesLayout.removeWidget(tile)
        tile.hide()
        tile.deleteLater()
        self.setVisible(bool(self._tiles))
