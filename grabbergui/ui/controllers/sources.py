"""The sources: the list to choose from, the tiles of the open ones, and how the current one is doing."""

from __future__ import annotations

import logging
import time
from functools import partial

from PyQt5.QtCore import QObject, QTimer, pyqtSignal

from grabbergui.core.errors import UsageError
from grabbergui.core.uri import SIMULATED
from grabbergui.models.connection import Connection
from grabbergui.models.diagnosis import Diagnosis, Observation, Stage, diagnose
from grabbergui.models.error_text import error_text
from grabbergui.models.image.live_image import ImageModel
from grabbergui.models.messages import Cause, Message, MessageModel, Offer, Severity
from grabbergui.models.open_source import LinkState, OpenSource
from grabbergui.models.sources import GalleryModel, ListedSource, SourceListModel, Tile, with_description
from grabbergui.models.status import MOST_STEP, Condition, SourceStatus, StatusModel
from grabbergui.ui.application import Preferences
from grabbergui.ui.controllers.recording import Confirm
from grabbergui.ui.gui_thread import Bridge
from grabbergui.ui.views.bases import FileQuestions, LiveImageView, StatusView
from grabbergui.ui.views.gallery import CameraTile, Gallery
from grabbergui.ui.views.source_list import SourceListView
from grabbergui.ui.widgets.labels import TaskRow, TaskStack

log = logging.getLogger(__name__)

# -- the list ------------------------------------------------------------------------------------
SHOWN_AFTER_MS = 300
"Milliseconds until the notice that another source is being opened: most open sooner."


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
        files: FileQuestions,
    ) -> None:
        super().__init__(view)
        self._files = files
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
        view.descriptionRequested.connect(self._on_view_description_requested)
        view.setRecent(preferences.recent)
        self._restore()
        self._show()

    def connect_to(self, uri: str, *, start: bool = True) -> None:
        """Open a source, and `start` it. A malformed URI is posted as a message."""
        try:
            replaced = self._connection.replaced_by(uri)
        except UsageError as error:
            self._messages.error(error_text(error))
        else:
            self._confirm([replaced], lambda: self._connection.connect_to(uri, start=start))

    def play(self, uri: str) -> None:
        """Play a recording, and keep the current source open. A malformed URI is posted as a message."""
        try:
            replaced = self._connection.replaced_by(uri, playing=True)
        except UsageError as error:
            self._messages.error(error_text(error))
        else:
            self._confirm([replaced], lambda: self._connection.play(uri))

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

    def _on_view_description_requested(self, uri: str) -> None:
        kinds = self.tr("GenICam descriptions (*.xml *.zip)")
        if chosen := self._files.to_open(self.tr("Description of this camera"), kinds):
            self.connect_to(with_description(uri, chosen))

    def _restore(self) -> None:
        for uri in self._preferences.typed:
            try:
                self._model.add(uri)
            except UsageError as error:
                log.info("a remembered source is left out: %s", error)

    def _on_model_changed(self, _: tuple[ListedSource, ...]) -> None:
        self._show()  # the emitted ones may be older

    def _show(self) -> None:
        lines = self._model.sources
        self._view.setSources(lines)
        self._view.hintLabel.setVisible(all(line.info.uri.startswith(SIMULATED) for line in lines))

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

    def _on_connection_sources_changed(self, _: tuple[OpenSource, ...]) -> None:
        sources = self._connection.sources  # the emitted ones may be older than those of the last call
        known = {str(s.uri): s for s in sources if s.state.connected or s.state is LinkState.LOST}
        self._model.set_open(
            {uri: s.grabber.info for uri, s in known.items() if s.grabber is not None},
            [uri for uri, s in known.items() if s.state is LinkState.LOST],
        )


# -- the tiles -----------------------------------------------------------------------------------
TILE_PERIOD_MS = 100
"Milliseconds between two images of a tile, which cost a tenth of a live image."


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
        self._timer.setInterval(TILE_PERIOD_MS)
        self._timer.timeout.connect(self._refresh)

    def take_next(self) -> None:
        """Make the next open source current, starting over after the last."""
        sources, current = self._connection.sources, self._connection.source
        if current in sources and len(sources) > 1:
            self._connection.make_current(sources[(sources.index(current) + 1) % len(sources)])

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
            if not view.visibleRegion().isEmpty() and (shown := tile.image.take()) is not None:
                view.setImage(shown.image)
                room = view.thumbnail.roomInPixels(shown.width, shown.height)
                tile.image.set_viewport(None, room)


# -- the status ----------------------------------------------------------------------------------
STATUS_PERIOD_MS = 200
"Milliseconds between two readings of the models."
_RUNNING = (Condition.STARTING, Condition.LIVE, Condition.PLAYING, Condition.STALLED)
"Conditions in which images are expected."


class StatusController(QObject):
    """Reads the models several times a second, and updates the views."""

    titleChanged = pyqtSignal(str)
    """The window's title, without the program's name."""
    lockChanged = pyqtSignal(str)
    """Why no feature can be written now; empty if they can."""

    def __init__(
        self,
        strip: StatusView,
        view: LiveImageView,
        connection: Connection,
        image: ImageModel,
        status: StatusModel,
        messages: MessageModel,
        parent: QObject,
    ) -> None:
        super().__init__(parent)
        self._strip = strip
        self._view = view
        self._connection = connection
        self._image = image
        self._status = status
        self._messages = messages
        self._shown: OpenSource | None = None
        self._shown_for = 0.0
        self._looked = time.monotonic()
        self._title = self._lock = ""
        bridge = Bridge(self)
        bridge.bind(messages.changed, self._show_messages)
        bridge.bind(connection.state_changed, lambda *_: self.refresh())
        bridge.bind(connection.sources_changed, lambda _: self.refresh())
        self._timer = QTimer(self)
        self._timer.setInterval(STATUS_PERIOD_MS)
        self._timer.timeout.connect(self.refresh)
        self._timer.start()
        self.refresh()

    def refresh(self) -> None:
        """Read everything now."""
        source = self._connection.source
        now = time.monotonic()
        step, self._looked = min(now - self._looked, MOST_STEP), now
        if source is not self._shown:
            self._shown, self._shown_for = source, 0.0
            self._strip.clearFigures()
        self._shown_for += step
        self._status.refresh()
        status = self._status.of(source)
        self._strip.setState(status.text, status.tone)
        self._strip.setTitle(*(source.names if source is not None else ("",)))
        self._show_title(source, status)
        self._show_lock(status)
        if source is not None:
            self._show_figures(status)
            self._note_trigger(source, status)
        self._explain(source, status)
        self._show_age(status)
        self._messages.expire()
        self._show_messages()

    def _show_messages(self) -> None:
        self._strip.setMessages(self._messages.shown(self._connection.source))

    def _show_title(self, source: OpenSource | None, status: SourceStatus) -> None:
        title = status.title(source.title) if source is not None else ""
        if title != self._title:
            self._title = title
            self.titleChanged.emit(title)

    def _show_lock(self, status: SourceStatus) -> None:
        lock = ""
        if status.condition is Condition.LOST:
            lock = self.tr("The camera does not answer; its last known settings are shown until it is back.")
        if lock != self._lock:
            self._lock = lock
            self.lockChanged.emit(lock)

    def _show_figures(self, status: SourceStatus) -> None:
        statistics, frame = status.statistics, self._image.frame
        if statistics is None:
            return
        known = f"{frame.width} × {frame.height}  {frame.pixel_format}" if frame is not None else ""
        self._strip.setFormat(known)
        running = status.condition in (*_RUNNING, Condition.PAUSED, Condition.WAITING)
        # The state of the last second would look current.
        self._strip.setRates(*((statistics.frame_rate, self._image.painted_rate) if running else (0, 0)))
        self._strip.setBandwidth(statistics.bandwidth if running else 0)
        self._strip.setLosses(status.health.text, status.loss_tone, status.health.detail)

    def _show_age(self, status: SourceStatus) -> None:
        """Note on the last image of a source that is lost."""
        last = self._image.last_received
        lost = status.condition is Condition.LOST and last is not None
        self._view.setAge(time.monotonic() - last if lost and last is not None else None)

    # -- why there is no image -----------------------------------------------------------------
    def _explain(self, source: OpenSource | None, status: SourceStatus) -> None:
        """Explain a missing image: in the middle of an empty view, else in a message."""
        note = self._note(source, status)
        if self._view.empty:
            self._view.setNote(*note)
        else:
            self._view.setNote("")
        summary, advice, stage = note
        if source is None:
            return
        if stage is None or self._view.empty:
            self._messages.end(source, Cause.IMAGE)
        else:
            text = f"{summary} {advice}".strip()
            self._messages.post(Message(text, Severity.WARNING, source, Cause.IMAGE))

    def _note(self, source: OpenSource | None, status: SourceStatus) -> tuple[str, str, Stage | None]:
        """Return the note on a missing image: its reason, the remedy, and the stage at which it is lost."""
        condition = status.condition
        if source is None:
            return (
                self.tr("Nothing is connected."),
                self.tr("Choose one of the sources (F8), or type its address; sim: is the simulated camera."),
                None,
            )
        if condition is Condition.CONNECTING:
            return self.tr("Connecting to {0} …").format(source.uri), "", None
        if condition is Condition.WAITING:
            return self.tr("Waiting for a trigger"), "", None
        if condition is Condition.READ_ONLY and source.no_frames:
            summary = self.tr("The image goes to the program that has control.")
            return summary, source.no_frames, Stage.PACKETS
        found = self._diagnosis(source, status) if condition in _RUNNING else None
        return (found.summary, found.advice, found.stage) if found is not None else ("", "", None)

    def _diagnosis(self, source: OpenSource, status: SourceStatus) -> Diagnosis | None:
        if source.grabber is None or status.statistics is None:
            return None
        return diagnose(
            Observation(
                source=source.title,
                address=source.grabber.info.address,
                bus=source.grabber.info.bus,
                seconds=self._shown_for,
                silent=status.seconds,
                statistics=status.statistics,
                received=self._image.received,
                problem=self._image.problem,
                painted=0 if self._view.empty else 1,
                mean=self._image.mean,
                facts=status.facts,
                silence=source.grabber.silence(),
            )
        )

    # -- triggering ------------------------------------------------------------------------------
    def _note_trigger(self, source: OpenSource, status: SourceStatus) -> None:
        """Offer the trigger from the first wait until it is switched off: each frame may need it."""
        trigger = status.facts.trigger_source
        if trigger is None or not source.state.connected:
            self._messages.end(source, Cause.TRIGGER)
        elif status.condition is Condition.WAITING:
            offers = [Offer(self.tr("Trigger off"), lambda: self._trigger_off(source))]
            if status.facts.software_trigger:
                offers.insert(0, Offer(self.tr("Send trigger"), lambda: self._send_trigger(source)))
            text = self.tr("frames arrive when triggered by {0}").format(trigger)
            message = Message(text, Severity.NOTICE, source, Cause.TRIGGER, tuple(offers))
            self._messages.post(message)

    @staticmethod
    def _send_trigger(source: OpenSource) -> None:
        if source.features is not None:
            source.features.execute("TriggerSoftware")

    @staticmethod
    def _trigger_off(source: OpenSource) -> None:
        if source.features is not None:
            source.features.write("TriggerMode", "Off")
