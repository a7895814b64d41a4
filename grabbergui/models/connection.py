"""The open sources of a window: opening, closing, and the current one."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from psygnal import Signal

from grabbergui import sources
from grabbergui.core.errors import AccessDeniedError, GrabberError
from grabbergui.core.grabber import Access, ConnectionState, FrameGrabber
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.uri import SourceUri
from grabbergui.models.error_text import error_text
from grabbergui.models.language import translate
from grabbergui.models.messages import Cause, MessageModel
from grabbergui.models.open_source import LinkState, OpenSource
from grabbergui.models.source_messages import LinkMessages

CLOSE_PATIENCE = 10.0
"Seconds to wait for a camera to close before it is opened again under another URI."


class Connection:
    """Opens and closes sources; one of them is current.

    Methods return immediately; signals are emitted on the sources' threads. `connect_to` replaces the current
    source once the new one is open, so that a wrong address does no harm; `open_additional` keeps it. A
    source that is slow to close does not delay the next one; its late answers are ignored.
    """

    state_changed = Signal(LinkState, str)
    """The new state of the current source, and the reason as display text."""
    opened = Signal(OpenSource)
    """A source has become current and its grabber is open."""
    closing = Signal(OpenSource)
    """The current source is about to be closed or to move to the background: release its grabber."""
    ending = Signal(OpenSource)
    """A source, current or in the background, is about to be closed: release its grabber."""
    sources_changed = Signal(tuple)
    """All sources (tuple[OpenSource, ...]): one was added, removed, made current, or changed its state."""
    pending_changed = Signal(object)
    """The source (OpenSource) that will replace the current one; None after that, or if it is cancelled."""
    failed = Signal(str)
    """A request failed; a sentence as display text."""
    refused = Signal(str, str)
    """The requested URI of a source that could not be opened, and the reason as display text."""

    def __init__(
        self,
        create: Callable[[SourceUri], FrameGrabber] = sources.create,
        messages: MessageModel | None = None,
    ) -> None:
        self.messages = messages or MessageModel()
        self._link_messages = LinkMessages(self.messages)
        self._create = create
        self._source: OpenSource | None = None
        self._sources: tuple[OpenSource, ...] = ()
        self._pending: OpenSource | None = None
        self._played: SourceUri | None = None
        "The recording that `play` opened last."
        self._why_closed = ""
        self._lock = threading.Lock()
        self._switching = threading.RLock()
        "Held while the current source changes, so that `closing` of each is emitted before the next one."
        self._leaving: list[OpenSource] = []

    @property
    def state(self) -> LinkState:
        """State of the current source. Any thread."""
        source = self._source
        return source.state if source is not None else LinkState.CLOSED

    @property
    def reason(self) -> str:
        """Reason for the state, as display text."""
        source = self._source
        return source.reason if source is not None else self._why_closed

    @property
    def source(self) -> OpenSource | None:
        """The current source: open or being opened."""
        return self._source

    @property
    def pending(self) -> OpenSource | None:
        """The source that will replace the current one once it is open."""
        return self._pending

    @property
    def sources(self) -> tuple[OpenSource, ...]:
        """All sources that are open or being opened, in the order of opening."""
        return self._sources

    def connect_to(self, uri: str, *, start: bool = True) -> None:
        """Open a source in place of the current one and `start` it; make a background source current.

        The current source stays until the new one is open, unless it is the same or not open yet. If several
        are open, it stays open in the background. Raises UsageError for a malformed URI; `failed` reports
        other failures.
        """
        self._connect_to(SourceUri.parse(uri), start, beside=len(self._sources) > 1)

    def _connect_to(self, parsed: SourceUri, start: bool, *, beside: bool) -> None:
        """Connect; with `beside`, the current source stays open."""
        self.messages.end(None, Cause.OPENING)
        self.cancel_pending()
        before = self._source
        if (background := self._in_background(parsed)) is not None:
            self.make_current(background)
        elif before is None or before.state is LinkState.OPENING or before.is_named(parsed):
            if before is not None:
                self._end(before, "")
            self._begin(parsed, start, current=True)
        else:
            self._begin_pending(parsed, start, None if beside else before)

    def replaced_by(self, uri: str, *, playing: bool = False) -> OpenSource | None:
        """Return the source that `connect_to`, or `play`, would close. Raises UsageError like these."""
        parsed, current = SourceUri.parse(uri), self._source
        if self._in_background(parsed) is not None:
            return None
        if playing and current is not None and current.uri.scheme != parsed.scheme:
            return self._in_background(self._played) if self._played is not None else None
        if playing or current is None:
            return current
        several = len(self._sources) > 1 and not current.is_named(parsed)
        return None if several else current

    def cancel_pending(self) -> None:
        """Cancel the pending source, if any, and keep the current one."""
        if (source := self._pending) is not None and self._drop(source):
            self.pending_changed.emit(None)

    def play(self, uri: str) -> None:
        """Make a recording current, and keep the camera that was current open.

        A recording that is current, or was played before, is replaced. Raises UsageError for a malformed URI.
        """
        replaced = self.replaced_by(uri, playing=True)
        self._played = parsed = SourceUri.parse(uri)
        before = self._source
        if before is None or before.uri.scheme == parsed.scheme or self._in_background(parsed) is not None:
            self._connect_to(parsed, start=True, beside=False)
            return
        self.messages.end(None, Cause.OPENING)
        self.make_current(self._begin(parsed, start=True, current=False))
        if replaced is not None:
            self._end(replaced, "")

    def open_additional(self, uri: str) -> None:
        """Open and start one more source and keep the current one. Raises UsageError for a malformed URI."""
        parsed = SourceUri.parse(uri)
        self.messages.end(None, Cause.OPENING)
        current = self._source
        if current is not None and (self._in_background(parsed) or current.is_named(parsed)):
            self._report_not_opened(translate("Connection", "{0} is open already").format(parsed))
        else:
            self._begin(parsed, start=True, current=current is None)

    def take_control(self) -> None:
        """Reopen the current source to control it, if it is open for reading only.

        The other program may have closed it by now, or yield control on request, as grabbergui does.
        """
        if (source := self._source) is not None and source.read_only:
            self._end(source, "")
            self._begin(source.exact_uri, start=True, current=True, access=Access.TAKE_OVER)

    def _begin(
        self, uri: SourceUri, start: bool, *, current: bool, access: Access = Access.CONTROL
    ) -> OpenSource:
        source = OpenSource(uri, access, lambda: self._sources)
        with self._lock:
            self._sources = (*self._sources, source)
            if current:
                self._source = source
        self._change(source, LinkState.OPENING, f"Connecting to {uri}")
        self._submit_opening(source, start)
        return source

    def _begin_pending(self, uri: SourceUri, start: bool, before: OpenSource | None) -> None:
        source = OpenSource(uri, among=lambda: self._sources)
        source.replaces = before
        with self._lock:
            self._pending = source
        self.pending_changed.emit(source)
        self._submit_opening(source, start)

    def _submit_opening(self, source: OpenSource, start: bool) -> None:
        def failed(error: GrabberError) -> None:
            self._give_up(source, error_text(error, source.uri))

        source.worker.submit(
            lambda: self._open(source), done=lambda _: self._opened(source, start), failed=failed
        )

    def make_current(self, source: OpenSource) -> None:
        """Make another of the open sources the current one."""
        with self._switching:
            with self._lock:
                if source not in self._sources or source is self._source:
                    return
                before, self._source = self._source, source
                state, reason = source.state, source.reason
            if before is not None:
                self.closing.emit(before)
        self.state_changed.emit(LinkState.OPENING, f"Showing {source.title}")
        if state is not LinkState.OPENING:
            self._announce(source)
            self.state_changed.emit(state, reason)
        self.sources_changed.emit(self._sources)

    def start(self) -> None:
        """Start streaming, on the source's own thread."""
        if (source := self._source) is not None and source.state is LinkState.OPEN:
            self._start(source)

    def stop(self) -> None:
        """Stop streaming, on the source's own thread."""
        source = self._source
        if source is None or source.grabber is None or source.state is not LinkState.STREAMING:
            return

        def stopped(_: None) -> None:
            self._reach(source, LinkState.OPEN)

        def failed(error: GrabberError) -> None:
            text = translate("Connection", "stopping failed: {0}")
            self._report_failure(source, text.format(error_text(error)))

        source.worker.submit(source.grabber.stop, done=stopped, failed=failed)

    def close(self, source: OpenSource) -> None:
        """Close a source; if it was current, the one opened last becomes current."""
        self._end(source, "")
        self._ensure_current()

    def disconnect(self) -> None:
        """Close the current source; does nothing if there is none."""
        if (source := self._source) is not None:
            self.close(source)

    def close_all(self) -> None:
        """Close every source."""
        self.cancel_pending()
        for source in self._sources:
            self._end(source, "")

    def wait_closed(self, timeout: float) -> bool:
        """Wait up to `timeout` seconds; return whether the threads of all released sources have ended."""
        deadline = time.monotonic() + timeout
        with self._lock:
            leaving = list(self._leaving)
        ended = [s for s in leaving if s.worker.close(max(0.0, deadline - time.monotonic()))]
        with self._lock:
            self._leaving = [source for source in self._leaving if source not in ended]
        return len(ended) == len(leaving)

    def _open(self, source: OpenSource) -> None:
        if source.abandoned.is_set():
            return
        grabber = self._create(source.uri)
        source.grabber = grabber
        grabber.connection_changed.connect(
            lambda state, reason: self._on_grabber_connection_changed(source, state, reason),
            check_nargs=False,
        )
        grabber.held_changed.connect(lambda held: self._on_held_changed(source, held), check_nargs=False)
        grabber.noticed.connect(lambda text: self.messages.notice(text, source), check_nargs=False)
        try:
            grabber.open(source.access)
        except GrabberError as error:
            if self._make_way(source, grabber.info):
                grabber.open(source.access)
            elif isinstance(error, AccessDeniedError):
                source.open_read_only(error)
                if self._make_way(source, grabber.info):  # its identity is known only when it is open
                    grabber.close()
                    source.read_only = ""
                    grabber.open(source.access)
            else:
                raise
        source.load_features()
        assert source.features is not None
        source.features.failed.connect(lambda error: self._link_messages.feature_failed(source, error))

    def _make_way(self, source: OpenSource, info: DeviceInfo) -> bool:
        """Close the current source and wait if it is the same camera. Return whether it was closed."""
        before = source.replaces or (self._source if source is self._pending else None)
        if before is None or not before.is_device(info):
            return False
        source.replaces = before
        source.reopen_on_failure = before.exact_uri
        return self._take_place(source) and before.worker.close(CLOSE_PATIENCE)

    def _opened(self, source: OpenSource, start: bool) -> None:
        if source.abandoned.is_set():
            return
        if source is self._pending:
            if not self._take_place(source):
                return
            if source.state is LinkState.LOST:
                self.failed.emit(self._link_messages.lost(source, source.reason))
        if self._reach(source, LinkState.OPEN):
            self._announce(source)
        if source.access is Access.TAKE_OVER and not source.read_only:
            self._link_messages.took_control(source)
        if start:
            self._start(source)

    def _start(self, source: OpenSource) -> None:
        def job() -> None:
            if not source.abandoned.is_set() and source.grabber is not None:
                source.grabber.start()

        def done(_: None) -> None:
            self._reach(source, LinkState.STREAMING)

        def failed(error: GrabberError) -> None:
            if source.read_only and isinstance(error, AccessDeniedError):
                source.no_frames = error_text(error)
            else:
                text = translate("Connection", "{0} does not start: {1}")
                self._report_failure(source, text.format(source.title, error_text(error)))

        source.worker.submit(job, done=done, failed=failed)

    def _on_grabber_connection_changed(self, source: OpenSource, state: ConnectionState, reason: str) -> None:
        if state is ConnectionState.LOST and (source.state, source.reason) != (LinkState.LOST, reason):
            if source.lost_since is None:  # otherwise the same loss has a new reason
                source.losses += 1
                source.lost_since = time.monotonic()
            self._change(source, LinkState.LOST, reason)
            if source in self._sources:
                self.failed.emit(self._link_messages.lost(source, reason))
        elif state is ConnectionState.OPEN and source.state is LinkState.LOST and source.grabber is not None:
            streaming = source.grabber.streaming
            self._change(source, LinkState.STREAMING if streaming else LinkState.OPEN, reason)
            if source in self._sources and source.lost_since is not None:
                self._link_messages.back(source, time.monotonic() - source.lost_since, reason)
            source.lost_since = None
            if source.features is not None:
                source.features.reload()
        elif state is ConnectionState.OPEN and source.features is not None:
            source.features.reload()  # a remote camera's controls may be discovered late

    def _on_held_changed(self, source: OpenSource, held: bool) -> None:
        if source.note_held(held) and source.state.connected:
            self.messages.end(source, Cause.ACCESS)  # show the new reason even if the old one was dismissed
            if source is self._source:
                self._link_messages.ready(source, self.take_control)

    def _reach(self, source: OpenSource, state: LinkState) -> bool:
        """Set the state that a call resulted in, unless the source was lost before the call ended."""
        return self._change(source, state, "", keeps_loss=True)

    def _change(self, source: OpenSource, state: LinkState, reason: str, *, keeps_loss: bool = False) -> bool:
        """Set and announce a source's state. Return whether the source is the current one."""
        with self._lock:
            if source is self._pending:
                source.state, source.reason = state, reason
            if source not in self._sources:
                return False
            if keeps_loss and source.state is LinkState.LOST:
                state, reason = source.state, source.reason
            source.state, source.reason = state, reason
            current = source is self._source
        if current:
            self.state_changed.emit(state, reason)
        self.sources_changed.emit(self._sources)
        return current

    def _announce(self, source: OpenSource) -> None:
        """Announce that the current source can be used, and any restriction."""
        self.opened.emit(source)
        self._link_messages.ready(source, self.take_control)

    def _report_failure(self, source: OpenSource, message: str) -> None:
        if source in self._sources:
            self.messages.error(message, source)
            self.failed.emit(message)

    def _report_not_opened(self, message: str) -> None:
        self._link_messages.not_opened(message, lasting=self._source is None)
        self.failed.emit(message)

    def _give_up(self, source: OpenSource, message: str) -> None:
        if not source.abandoned.is_set():
            self.refused.emit(str(source.uri), message)
        if self._drop(source):
            self.pending_changed.emit(None)
            self._report_not_opened(message)
        elif self._end(source, message):
            if source.reopen_on_failure is not None:
                self._begin(source.reopen_on_failure, start=True, current=True)
            else:
                self._ensure_current()
            self._report_not_opened(message)

    def _drop(self, pending: OpenSource) -> bool:
        """Release a source if it is still pending. Return whether it was."""
        with self._lock:
            if pending is not self._pending:
                return False
            self._pending = pending.replaces = None
            self._leave(pending)
        pending.release()
        return True

    def _take_place(self, source: OpenSource) -> bool:
        """Make the pending source current, and close the one it replaces. Return whether it was pending."""
        with self._switching:
            with self._lock:
                if source is not self._pending:
                    return False
                before, current = source.replaces, self._source
                self._pending = source.replaces = None
                self._source = source
                if before is None or before not in self._sources:
                    before, self._sources = None, (*self._sources, source)
                else:
                    self._sources = tuple(source if other is before else other for other in self._sources)
                    self._leave(before)
            self.pending_changed.emit(None)
            if current is not None:
                self.closing.emit(current)
        if before is not None:
            self._release(before)
        self.state_changed.emit(LinkState.OPENING, f"Connecting to {source.uri}")
        self.sources_changed.emit(self._sources)
        return True

    def _in_background(self, uri: SourceUri) -> OpenSource | None:
        """Return the background source that a URI names."""
        return next((s for s in self._sources if s is not self._source and s.is_named(uri)), None)

    def _ensure_current(self) -> None:
        """If no source is current, make the one opened last current."""
        if self._source is None and self._sources:
            self.make_current(self._sources[-1])

    def _end(self, source: OpenSource, reason: str) -> bool:
        """Remove and close a source. Return whether it was open."""
        with self._switching:
            with self._lock:
                if source not in self._sources:
                    return False
                self._sources = tuple(other for other in self._sources if other is not source)
                current = source is self._source
                if current:
                    self._source, self._why_closed = None, reason
                self._leave(source)
            if current:
                self.closing.emit(source)
        self._release(source)
        if current:
            self.state_changed.emit(LinkState.CLOSED, reason)
        self.sources_changed.emit(self._sources)
        return True

    def _release(self, source: OpenSource) -> None:
        """Announce the end of a source that is no longer among the sources, and close it."""
        self.ending.emit(source)
        source.release()
        self.messages.forget(source)

    def _leave(self, source: OpenSource) -> None:
        """Keep a source until its thread has ended. Call with the lock held."""
        self._leaving = [*(s for s in self._leaving if not s.worker.close(0)), source]
