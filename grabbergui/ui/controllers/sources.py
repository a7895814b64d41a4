"""The sources: the list to choose from, the tiles of the open ones, and how the current one is doing."""

from __future__ import annotations

import logging
from collections.abc import Callable

from PyQt5.QtCore import QObject, Qt, QTimer
from PyQt5.QtWidgets import QMessageBox

from grabbergui.core.errors import UsageError
from grabbergui.core.uri import SIMULATED
from grabbergui.models.error_text import error_text
from grabbergui.models.messages import MessageModel
from grabbergui.models.open_source import LinkState, OpenSource
from grabbergui.models.other_program import holder_name, recordings_of
from grabbergui.models.source_opener import SourceOpener
from grabbergui.models.sources import FEWEST, ListedSource, SourceListModel, typed_uri, with_description
from grabbergui.ui.controllers.recording import Confirm
from grabbergui.ui.controllers.source_context import SourceContext
from grabbergui.ui.gui_thread import Bridge
from grabbergui.ui.shown_text import question_box
from grabbergui.ui.views.source_list import SourceListView
from grabbergui.ui.widgets.task_stack import TaskRow, TaskStack

log = logging.getLogger(__name__)


SHOWN_AFTER_MS = 300
"Milliseconds until the notice that another source is being opened: most open sooner."


class SourcesController(QObject):
    """Shows the sources found, and connects to the one that is chosen or typed."""

    def __init__(
        self,
        view: SourceListView,
        model: SourceListModel,
        opener: SourceOpener,
        context: SourceContext,
        tasks: TaskStack,
        confirm: Confirm,
        messages: MessageModel,
    ) -> None:
        super().__init__(view)
        self._files = context.files
        self._messages = messages
        self._view = view
        self._model = model
        self._opener = opener
        self._open_sources = open_sources = opener.open_sources
        self._preferences = context.preferences
        self._tasks = tasks
        self._confirm = confirm
        self._row: TaskRow | None = None
        "The source that is being opened in place of the current one."
        bridge = Bridge(self)
        bridge.bind(model.changed, self._on_model_changed)
        bridge.bind(model.searching, view.setSearching)
        bridge.bind(open_sources.state_changed, self._on_source_state_changed)
        bridge.bind(opener.refused, model.note_problem)
        bridge.bind(open_sources.pending_changed, self._on_pending_changed)
        bridge.bind(open_sources.changed, self._on_sources_changed)
        view.connectRequested.connect(self.connect_to)
        view.stillRequested.connect(lambda uri: self.connect_to(uri, start=False))
        view.besideRequested.connect(self.open_additional)
        view.addressEntered.connect(self._on_view_address_entered)
        view.disconnectRequested.connect(self.disconnect_current)
        view.refreshRequested.connect(model.refresh)
        view.forgetRequested.connect(self._on_view_forget_requested)
        view.descriptionRequested.connect(self._on_view_description_requested)
        view.setRecent(context.preferences.recent)
        self.question: QMessageBox | None = None
        "The question whether to take control from another program, while it is open."
        opener.confirm_control = self._confirm_control
        self._restore()
        self._show()

    def connect_to(self, uri: str, *, start: bool = True) -> None:
        """Open a source, and `start` it. A malformed URI is posted as a message."""
        uri = typed_uri(uri)
        try:
            replaced = self._opener.replaced_by(uri)
        except UsageError as error:
            self._messages.error(error_text(error))
        else:
            self._confirm([replaced], lambda: self._opener.connect_to(uri, start=start))

    def play(self, uri: str) -> None:
        """Play a recording, and keep the current source open. A malformed URI is posted as a message."""
        try:
            replaced = self._opener.replaced_by(uri, playing=True)
        except UsageError as error:
            self._messages.error(error_text(error))
        else:
            self._confirm([replaced], lambda: self._opener.play(uri))

    def disconnect_current(self) -> None:
        """Close the current source."""
        self._confirm([self._open_sources.current], self._open_sources.close_current)

    def open_additional(self, uri: str) -> None:
        """Open an additional source. A malformed URI is posted as a message."""
        try:
            self._opener.open_additional(typed_uri(uri))
        except UsageError as error:
            self._messages.error(error_text(error))

    def _confirm_control(self, source: OpenSource, take: Callable[[], None]) -> None:
        """Call `take` if the user agrees that another program loses control."""
        recordings = recordings_of(source.denied)
        detail = self.tr("The other program receives no more images: a recording there ends.")
        if recordings:
            detail = self.tr("It is recording {0}; the recording ends.").format(", ".join(recordings))
        holder = holder_name(source.denied) or self.tr("another program")
        self.question = box = question_box(
            self._view.window() or self._view,
            self.tr("Take control of {0} from {1}?").format(source.title, holder),
            detail,
        )
        box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        agree = box.addButton(self.tr("Take control"), QMessageBox.ButtonRole.AcceptRole)
        leave = box.addButton(self.tr("Leave it there"), QMessageBox.ButtonRole.RejectRole)
        box.setDefaultButton(leave)
        box.setEscapeButton(leave)

        def answered() -> None:
            self.question = None
            if box.clickedButton() is agree:
                take()

        box.finished.connect(lambda _: answered())
        box.open()

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
        simulated = all(line.info.uri.startswith(SIMULATED) for line in lines)
        several = sum(line.connected for line in lines) >= FEWEST  # their tiles need the room
        self._view.hintLabel.setVisible(simulated and not several)

    def _on_source_state_changed(self, state: LinkState, _: str) -> None:
        source = self._open_sources.current
        uri = str(source.uri) if source is not None else ""
        if source is not None and source.grabber is not None and (state.connected or state is LinkState.LOST):
            # A source found is listed under the URI that names it exactly, e.g. by its serial number.
            uri = source.grabber.info.uri
        self._view.setCurrent(uri, state is not LinkState.CLOSED)
        if state is LinkState.OPEN and source is not None:
            self._model.note_problem(str(source.uri), "")
            self._preferences.note_source(str(source.uri))
            self._view.setRecent(self._preferences.recent)

    def _on_pending_changed(self, pending: OpenSource | None) -> None:
        if self._row is not None:
            self._tasks.end(self._row)
            self._row = None
        if pending is not None:
            QTimer.singleShot(SHOWN_AFTER_MS, lambda: self._show_pending(pending))

    def _show_pending(self, pending: OpenSource) -> None:
        if pending is not self._open_sources.pending or self._row is not None:
            return
        self._row = self._tasks.begin(self.tr("Connecting"))
        self._row.setText(str(pending.uri))
        self._row.cancelRequested.connect(self._open_sources.cancel_pending)

    def _on_sources_changed(self, _: tuple[OpenSource, ...]) -> None:
        sources = self._open_sources.all  # the emitted ones may be older than those of the last call
        known = {str(s.uri): s for s in sources if s.state.connected or s.state is LinkState.LOST}
        self._model.set_open(
            {uri: s.grabber.info for uri, s in known.items() if s.grabber is not None},
            [uri for uri, s in known.items() if s.state is LinkState.LOST],
        )
