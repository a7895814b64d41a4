"""The tiles of the open sources."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

from PyQt5.QtCore import QObject, QRectF, QSize, Qt, QTimer

from grabbergui.core.pixels import Region
from grabbergui.models.image.components import ShownImage
from grabbergui.models.open_source import OpenSource
from grabbergui.models.sources import GalleryModel, Tile
from grabbergui.models.status import Condition, StatusModel
from grabbergui.ui.controllers.recording import Confirm
from grabbergui.ui.controllers.source_context import SourceContext
from grabbergui.ui.gui_thread import Bridge
from grabbergui.ui.views.bases import SourcePanesView
from grabbergui.ui.views.gallery import CameraTile, Gallery
from grabbergui.ui.widgets.component_pane import ComponentPane

TILE_PERIOD_MS = 100
"Milliseconds between two images of a tile, which cost a tenth of a live image."
PANE_PERIOD_MS = 40
"Milliseconds between two images of a camera that is shown beside the current one."


class GalleryController(QObject):
    """Shows a tile for each open source; a click makes it current."""

    def __init__(
        self,
        view: Gallery,
        image: SourcePanesView,
        model: GalleryModel,
        context: SourceContext,
        status: StatusModel,
        confirm: Confirm,
    ) -> None:
        super().__init__(view)
        self._preferences = context.preferences
        self._status = status
        self._confirm = confirm
        self._view = view
        self._model = model
        self._open_sources = context.open_sources
        self._image = image
        self._panes = context.preferences.panes
        "How many sources are shown side by side, the current one among them."
        self._latest: dict[Tile, ShownImage] = {}
        "The newest image of each source."
        self._shown: dict[Tile, CameraTile] = {}
        image.sourceChosen.connect(self._on_image_source_chosen)
        bridge = Bridge(self)
        # The current source may have changed since the signal: only the model knows.
        bridge.bind(model.changed, lambda _: self._show())
        bridge.bind(context.open_sources.opened, lambda _: self._show())
        self._timer = QTimer(self)
        self._timer.setInterval(TILE_PERIOD_MS if self._panes == 1 else PANE_PERIOD_MS)
        self._timer.timeout.connect(self._refresh)
        image.setSeparateZoom(context.preferences.separate_zoom)

    def take_next(self) -> None:
        """Make the next open source current, starting over after the last."""
        sources, current = self._open_sources.all, self._open_sources.current
        if current in sources and len(sources) > 1:
            self._open_sources.make_current(sources[(sources.index(current) + 1) % len(sources)])

    def show_panes(self, count: int) -> None:
        """Show so many sources side by side, as far as they are open."""
        self._panes = self._preferences.panes = count
        self._timer.setInterval(TILE_PERIOD_MS if count == 1 else PANE_PERIOD_MS)
        self._refresh()

    def separate_zoom(self, separate: bool) -> None:
        """Let each source shown have a zoom of its own, or the same for all."""
        self._preferences.separate_zoom = separate
        self._image.setSeparateZoom(separate)

    def _on_image_source_chosen(self, name: str) -> None:
        for tile in self._shown:
            if tile.source.title == name:
                self._open_sources.make_current(tile.source)

    def _show(self) -> None:
        tiles = self._model.tiles
        for tile in [tile for tile in self._shown if tile not in tiles]:
            self._view.removeTile(self._shown.pop(tile))
            self._latest.pop(tile, None)
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
            self._show_beside()

    def _close(self, source: OpenSource) -> None:
        self._confirm([source], lambda: self._open_sources.close(source))

    def _refresh(self) -> None:
        for tile, view in self._shown.items():
            status = self._status.of(tile.source)
            view.setState(status.tile, status.tone)
            view.setRecording(status.recorded)
            view.setDimmed(status.condition is Condition.LOST)
            pane = self._image.paneArea.panes.get(tile.source.title)
            seen = pane is not None or not view.visibleRegion().isEmpty() or self._panes > 1
            if seen and (shown := tile.image.take()) is not None:
                self._latest[tile] = shown
                view.setImage(shown.image)
                if pane is None:
                    tile.image.set_viewport(None, view.thumbnail.roomInPixels(shown.width, shown.height))
                else:
                    tile.image.set_viewport(*self._part_seen(shown, pane))
        self._show_beside()

    def _show_beside(self) -> None:
        """Show the newest images of the first sources beside the current one's, if that is wanted."""
        current = self._open_sources.current
        others = [tile for tile in self._shown if tile.source is not current and tile in self._latest]
        beside = others[: self._panes - 1] if current is not None else []
        images = [replace(self._latest[tile], label=tile.source.title, others=()) for tile in beside]
        order = [tile.source.title for tile in self._shown]
        self._image.setSourcesBeside(order, current.title if current is not None else "", images)

    def _part_seen(self, shown: ShownImage, pane: ComponentPane) -> tuple[Region, tuple[int, int]]:
        """Return the part of an image that its pane shows, and the pixels of the screen that it takes."""
        seen = pane.seen if self._image.paneArea.separate else self._image.canvas.seen
        part = seen.intersected(QRectF(0, 0, 1, 1))
        left, top = math.floor(part.left() * shown.width), math.floor(part.top() * shown.height)
        width = max(1, math.ceil(part.right() * shown.width) - left)
        height = max(1, math.ceil(part.bottom() * shown.height) - top)
        ratio = pane.devicePixelRatioF()
        room = QSize(width, height).scaled(pane.size() * ratio, Qt.AspectRatioMode.KeepAspectRatio)
        return Region(left, top, width, height), (max(1, room.width()), max(1, room.height()))
