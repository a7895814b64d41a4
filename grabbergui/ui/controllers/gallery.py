"""Joins the tiles of the open sources to the sources."""

from __future__ import annotations

from functools import partial

from PyQt5.QtCore import QObject, QTimer

from grabbergui.models.connection import Connection
from grabbergui.models.gallery import GalleryModel, Tile
from grabbergui.models.open_source import OpenSource
from grabbergui.models.status import Condition, StatusModel
from grabbergui.ui.bridge import Bridge
from grabbergui.ui.controllers.recording import Confirm
from grabbergui.ui.views.camera_tile import CameraTile
from grabbergui.ui.views.gallery import Gallery

PERIOD_MS = 100
"Between two pictures of a tile: enough to see what goes on there, at a tenth of the cost."


class GalleryController(QObject):
    """Shows a tile for each open source; takes one to hand that is clicked."""

    def __init__(
        self,
        view: Gallery,
        model: GalleryModel,
        connection: Connection,
        status: StatusModel,
        confirm: Confirm,
    ) -> None:
        super().__init__(view)
        self._status = status
        self._confirm = confirm
        self._view = view
        self._model = model
        self._connection = connection
        self._shown: dict[Tile, CameraTile] = {}
        bridge = Bridge(self)
        # What is shown then may be newer than what was told: only the model knows.
        bridge.bind(model.changed, lambda _: self._show())
        bridge.bind(connection.opened, lambda _: self._show())
        self._timer = QTimer(self)
        self._timer.setInterval(PERIOD_MS)
        self._timer.timeout.connect(self._refresh)

    def take_next(self) -> None:
        """Take the source to hand that stands behind the one at hand; after the last, the first."""
        sources, at_hand = self._connection.sources, self._connection.source
        if at_hand in sources and len(sources) > 1:
            self._connection.make_current(sources[(sources.index(at_hand) + 1) % len(sources)])

    def _show(self) -> None:
        tiles = self._model.tiles
        for tile in [tile for tile in self._shown if tile not in tiles]:
            self._view.removeTile(self._shown.pop(tile))
        for tile in tiles:
            view = self._shown.get(tile)
            if view is None:
                view = self._shown[tile] = self._view.addTile()
                view.chosen.connect(partial(self._connection.make_current, tile.source))
                view.closeRequested.connect(partial(self._close, tile.source))
            view.setTitle(tile.source.short_title, tile.source.title)
            view.setCurrent(tile.source is self._connection.source)
        if tiles and not self._timer.isActive():
            self._timer.start()
        elif not tiles:
            self._timer.stop()

    def _close(self, source: OpenSource) -> None:
        self._confirm([source], lambda: self._connection.close(source))

    def _refresh(self) -> None:
        for tile, view in self._shown.items():
            status = self._status.of(tile.source)
            view.setState(status.tile, status.tone)
            view.setRecording(status.recorded)
            view.setDimmed(status.condition is Condition.LOST)
            if not view.visibleRegion().isEmpty() and (picture := tile.picture.take()) is not None:
                view.setPicture(picture.image)
                room = view.thumbnail.roomInPixels(picture.width, picture.height)
                tile.picture.set_viewport(None, room)
