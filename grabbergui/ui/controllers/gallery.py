"""The tiles of the open sources."""

from __future__ import annotations

from functools import partial

from PyQt5.QtCore import QObject, QTimer

from grabbergui.models.open_source import OpenSource
from grabbergui.models.open_sources import OpenSources
from grabbergui.models.sources import GalleryModel, Tile
from grabbergui.models.status import Condition, StatusModel
from grabbergui.ui.controllers.recording import Confirm
from grabbergui.ui.gui_thread import Bridge
from grabbergui.ui.views.gallery import CameraTile, Gallery

TILE_PERIOD_MS = 100
"Milliseconds between two images of a tile, which cost a tenth of a live image."


class GalleryController(QObject):
    """Shows a tile for each open source; a click makes it current."""

    def __init__(
        self,
        view: Gallery,
        model: GalleryModel,
        open_sources: OpenSources,
        status: StatusModel,
        confirm: Confirm,
    ) -> None:
        super().__init__(view)
        self._status = status
        self._confirm = confirm
        self._view = view
        self._model = model
        self._open_sources = open_sources
        self._shown: dict[Tile, CameraTile] = {}
        bridge = Bridge(self)
        # The current source may have changed since the signal: only the model knows.
        bridge.bind(model.changed, lambda _: self._show())
        bridge.bind(open_sources.opened, lambda _: self._show())
        self._timer = QTimer(self)
        self._timer.setInterval(TILE_PERIOD_MS)
        self._timer.timeout.connect(self._refresh)

    def take_next(self) -> None:
        """Make the next open source current, starting over after the last."""
        sources, current = self._open_sources.all, self._open_sources.current
        if current in sources and len(sources) > 1:
            self._open_sources.make_current(sources[(sources.index(current) + 1) % len(sources)])

    def _show(self) -> None:
        tiles = self._model.tiles
        for tile in [tile for tile in self._shown if tile not in tiles]:
            self._view.removeTile(self._shown.pop(tile))
        for tile in tiles:
            view = self._shown.get(tile)
            if view is None:
                view = self._shown[tile] = self._view.addTile()
                view.chosen.connect(partial(self._open_sources.make_current, tile.source))
                view.closeRequested.connect(partial(self._close, tile.source))
            view.setNames(*tile.source.names)
            view.setCurrent(tile.source is self._open_sources.current)
        if tiles and not self._timer.isActive():
            self._timer.start()
        elif not tiles:
            self._timer.stop()

    def _close(self, source: OpenSource) -> None:
        self._confirm([source], lambda: self._open_sources.close(source))

    def _refresh(self) -> None:
        for tile, view in self._shown.items():
            status = self._status.of(tile.source)
            view.setState(status.tile, status.tone)
            view.setRecording(status.recorded)
            view.setDimmed(status.condition is Condition.LOST)
            if not view.visibleRegion().isEmpty() and (shown := tile.image.take()) is not None:
                view.setImage(shown.image)
                room = view.thumbnail.roomInPixels(shown.width, shown.height)
                tile.image.set_viewport(None, room)
