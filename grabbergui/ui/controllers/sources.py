"""The sources: the list to choose from, and the tiles of those that are open."""

from __future__ import annotations

import logging
from functools import partial

from PyQt5.QtCore import QObject, QTimer

from grabbergui.core.errors import UsageError
from grabbergui.models.connection import Connection
from grabbergui.models.error_text import error_text
from grabbergui.models.messages import MessageModel
from grabbergui.models.open_source import LinkState, OpenSource
from grabbergui.models.sources import GalleryModel, ListedSource, SourceListModel, Tile
from grabbergui.models.status import Condition, StatusModel
from grabbergui.ui.controllers.recording import Confirm
from grabbergui.ui.gui_thread import Bridge
from grabbergui.ui.preferences import Preferences
from grabbergui.ui.views.gallery import CameraTile, Gallery
from grabbergui.ui.views.source_list import SourceListView
from grabbergui.ui.widgets.labels import TaskRow, TaskStack

log = logging.getLogger(__name__)

SIMULATED = "sim"
SHOWN_AFTER_MS = 300
"Of opening in place of the current source: a shorter notice would only make the picture jump."


class SourcesController(QObject):
    """Shows the sources found, and connects to the one that is chosen or typed."""

    def __init__(
        self,
        view: SourceListView,
        model: SourceListModel,
        connection: Connection,
        preferences: Preferences,
        tasks: TaskStack,
        confirm: Confirm,
        messages: MessageModel,
    ) -> None:
        super().__init__(view)
        self._messages = messages
        self._view = view
        self._model = model
        self._connection = connection
        self._preferences = preferences
        self._tasks = tasks
        self._confirm = confirm
        self._row: TaskRow | None = None
        "The source that is being opened in place of the current one."
        bridge = Bridge(self)
        bridge.bind(model.changed, self._on_model_changed)
        bridge.bind(model.searching, view.setSearching)
        bridge.bind(connection.state_changed, self._on_connection_state_changed)
        bridge.bind(connection.pending_changed, self._on_connection_pending_changed)
        bridge.bind(connection.sources_changed, self._on_connection_sources_changed)
        view.connectRequested.connect(self.connect_to)
        view.stillRequested.connect(lambda uri: self.connect_to(uri, start=False))
        view.besideRequested.connect(self.open_additional)
        view.addressEntered.connect(self._on_view_address_entered)
        view.disconnectRequested.connect(self.disconnect_current)
        view.refreshRequested.connect(model.refresh)
        view.forgetRequested.connect(self._on_view_forget_requested)
        view.setRecent(preferences.recent)
        self._restore()
        view.setSources(model.sources)

    def connect_to(self, uri: str, *, start: bool = True) -> None:
        """Open a source, and `start` it. A malformed URI is posted as a message."""
        try:
            replaced = self._connection.replaced_by(uri)
        except UsageError as error:
            self._messages.error(error_text(error))
        else:
            self._confirm([replaced], lambda: self._connection.connect_to(uri, start=start))

    def disconnect_current(self) -> None:
        """Close the current source."""
        self._confirm([self._connection.source], self._connection.disconnect)

    def open_additional(self, uri: str) -> None:
        """Open an additional source. A malformed URI is posted as a message."""
        try:
            self._connection.open_additional(uri)
        except UsageError as error:
            self._messages.error(error_text(error))

    def _on_view_address_entered(self, text: str) -> None:
        try:
            uri = self._model.add(text)
        except UsageError as error:
            self._messages.error(error_text(error))
            return
        self._view.addressEdit.clear()
        self._preferences.typed = self._model.added_by_user
        self.connect_to(str(uri))

    def _on_view_forget_requested(self, uri: str) -> None:
        self._model.remove(uri)
        self._preferences.typed = self._model.added_by_user

    def _restore(self) -> None:
        for uri in self._preferences.typed:
            try:
                self._model.add(uri)
            except UsageError as error:
                log.info("a remembered source is left out: %s", error)

    def _on_model_changed(self, sources: tuple[ListedSource, ...]) -> None:
        self._view.setSources(sources)

    def _on_connection_state_changed(self, state: LinkState, _: str) -> None:
        source = self._connection.source
        uri = str(source.uri) if source is not None else ""
        if source is not None and source.grabber is not None and (state.connected or state is LinkState.LOST):
            # A source found is listed under the URI that names it exactly, e.g. by its serial number.
            uri = source.grabber.info.uri
        self._view.setCurrent(uri, state is not LinkState.CLOSED)
        if state is LinkState.OPEN and source is not None:
            self._preferences.note_source(str(source.uri))
            self._view.setRecent(self._preferences.recent)
        self._view.hintLabel.setVisible(source is None or source.uri.scheme == SIMULATED)

    def _on_connection_pending_changed(self, pending: OpenSource | None) -> None:
        if self._row is not None:
            self._tasks.end(self._row)
            self._row = None
        if pending is not None:
            QTimer.singleShot(SHOWN_AFTER_MS, lambda: self._show_pending(pending))

    def _show_pending(self, pending: OpenSource) -> None:
        if pending is not self._connection.pending or self._row is not None:
            return
        self._row = self._tasks.begin(self.tr("Connecting"))
        self._row.setText(str(pending.uri))
        self._row.cancelRequested.connect(self._connection.cancel_pending)

    def _on_connection_sources_changed(self, sources: tuple[OpenSource, ...]) -> None:
        known = {str(s.uri): s for s in sources if s.state.connected or s.state is LinkState.LOST}
        self._model.set_open(
            {uri: s.grabber.info for uri, s in known.items() if s.grabber is not None},
            [uri for uri, s in known.items() if s.state is LinkState.LOST],
        )


PERIOD_MS = 100
"Between two pictures of a tile: enough to see what goes on there, at a tenth of the cost."


class GalleryController(QObject):
    """Shows a tile for each open source; a click makes it current."""

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
        # The current source may have changed since the signal: only the model knows.
        bridge.bind(model.changed, lambda _: self._show())
        bridge.bind(connection.opened, lambda _: self._show())
        self._timer = QTimer(self)
        self._timer.setInterval(PERIOD_MS)
        self._timer.timeout.connect(self._refresh)

    def take_next(self) -> None:
        """Make the next open source current, starting over after the last."""
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
            view.setNames(*tile.source.names)
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
