"""The open sources of a window, one of which is current."""

from __future__ import annotations

import threading
import time

from psygnal import Signal

from grabbergui.core.uri import SourceUri
from grabbergui.models.messages import MessageModel
from grabbergui.models.open_source import LinkState, OpenSource


class OpenSources:
    """The sources that are open or being opened; one is current, and one may be pending to replace it.

    Methods return immediately, on any thread; signals are emitted on the thread that makes the change. A
    source that is slow to close delays no other; its late answers are ignored.
    """

    state_changed = Signal(LinkState, str)
    """The new state of the current source, and the reason as display text."""
    opened = Signal(OpenSource)
    """A source has become current and its grabber is open."""
    closing = Signal(OpenSource)
    """The current source is about to be closed or to move to the background: release its grabber."""
    ending = Signal(OpenSource)
    """A source, current or in the background, is about to be closed: release its grabber."""
    changed = Signal(tuple)
    """All sources (tuple[OpenSource, ...]): one was added, removed, made current, or changed its state."""
    pending_changed = Signal(object)
    """The source (OpenSource) that will replace the current one; None after that, or if it is cancelled."""

    def __init__(self, messages: MessageModel) -> None:
        """`messages` forgets those about a source that is closed."""
        self._messages = messages
        self._current: OpenSource | None = None
        self._all: tuple[OpenSource, ...] = ()
        self._pending: OpenSource | None = None
        self._why_closed = ""
        self._lock = threading.Lock()
        self._switching = threading.RLock()
        "Held while the current source changes, so that `closing` of each is emitted before the next one."
        self._leaving: list[OpenSource] = []

    @property
    def state(self) -> LinkState:
        """State of the current source."""
        source = self._current
        return source.state if source is not None else LinkState.CLOSED

    @property
    def reason(self) -> str:
        """Reason for the state, as display text."""
        source = self._current
        return source.reason if source is not None else self._why_closed

    @property
    def current(self) -> OpenSource | None:
        """The current source: open or being opened."""
        return self._current

    @property
    def pending(self) -> OpenSource | None:
        """The source that will replace the current one once it is open."""
        return self._pending

    @property
    def all(self) -> tuple[OpenSource, ...]:
        """All sources that are open or being opened, in the order of opening."""
        return self._all

    def in_background(self, uri: SourceUri) -> OpenSource | None:
        """Return the background source that a URI names."""
        return next((each for each in self._all if each is not self._current and each.is_named(uri)), None)

    def make_current(self, source: OpenSource) -> None:
        """Make another of the open sources the current one."""
        with self._switching:
            with self._lock:
                if source not in self._all or source is self._current:
                    return
                before, self._current = self._current, source
                state, reason = source.state, source.reason
            if before is not None:
                self.closing.emit(before)
        self.state_changed.emit(LinkState.OPENING, f"Showing {source.title}")
        if state is not LinkState.OPENING:
            self.opened.emit(source)
            self.state_changed.emit(state, reason)
        self.changed.emit(self._all)

    def ensure_current(self) -> None:
        """If no source is current, make the one opened last current."""
        if self._current is None and self._all:
            self.make_current(self._all[-1])

    def close(self, source: OpenSource) -> None:
        """Close a source; if it was current, the one opened last becomes current."""
        self.remove(source, "")
        self.ensure_current()

    def close_current(self) -> None:
        """Close the current source; does nothing if there is none."""
        if (source := self._current) is not None:
            self.close(source)

    def close_all(self) -> None:
        """Close every source."""
        self.cancel_pending()
        for source in self._all:
            self.remove(source, "")

    def cancel_pending(self) -> None:
        """Cancel the pending source, if any, and keep the current one."""
        if (source := self._pending) is not None:
            self.drop_pending(source)

    def wait_closed(self, timeout: float) -> bool:
        """Wait up to `timeout` seconds; return whether the threads of all released sources have ended."""
        deadline = time.monotonic() + timeout
        with self._lock:
            leaving = list(self._leaving)
        ended = [s for s in leaving if s.worker.close(max(0.0, deadline - time.monotonic()))]
        with self._lock:
            self._leaving = [source for source in self._leaving if source not in ended]
        return len(ended) == len(leaving)

    def add(self, source: OpenSource, *, current: bool) -> None:
        """Add a source that is being opened."""
        with self._lock:
            self._all = (*self._all, source)
            if current:
                self._current = source
        self.set_state(source, LinkState.OPENING, f"Connecting to {source.uri}")

    def add_pending(self, source: OpenSource) -> None:
        """Add a source that will take the place of another one (`replaces`) once it is open."""
        with self._lock:
            self._pending = source
        self.pending_changed.emit(source)

    def drop_pending(self, source: OpenSource) -> bool:
        """Release a source if it is still pending. Return whether it was."""
        with self._lock:
            if source is not self._pending:
                return False
            self._pending = source.replaces = None
            self._leave(source)
        source.release()
        self.pending_changed.emit(None)
        return True

    def take_place(self, source: OpenSource) -> bool:
        """Make the pending source current, and close the one it replaces. Return whether it was pending."""
        with self._switching:
            with self._lock:
                if source is not self._pending:
                    return False
                before, current = source.replaces, self._current
                self._pending = source.replaces = None
                self._current = source
                if before is None or before not in self._all:
                    before, self._all = None, (*self._all, source)
                else:
                    self._all = tuple(source if other is before else other for other in self._all)
                    self._leave(before)
            self.pending_changed.emit(None)
            if current is not None:
                self.closing.emit(current)
        if before is not None:
            self._release(before)
        self.state_changed.emit(LinkState.OPENING, f"Connecting to {source.uri}")
        self.changed.emit(self._all)
        return True

    def remove(self, source: OpenSource, reason: str) -> bool:
        """Remove and close a source, and make no other one current. Return whether it was open."""
        with self._switching:
            with self._lock:
                if source not in self._all:
                    return False
                self._all = tuple(other for other in self._all if other is not source)
                current = source is self._current
                if current:
                    self._current, self._why_closed = None, reason
                self._leave(source)
            if current:
                self.closing.emit(source)
        self._release(source)
        if current:
            self.state_changed.emit(LinkState.CLOSED, reason)
        self.changed.emit(self._all)
        return True

    def reach(self, source: OpenSource, state: LinkState) -> bool:
        """Set the state that a call resulted in, unless the source was lost before the call ended.

        Return whether the source is the current one.
        """
        return self.set_state(source, state, "", keeps_loss=True)

    def set_state(
        self, source: OpenSource, state: LinkState, reason: str, *, keeps_loss: bool = False
    ) -> bool:
        """Set and announce a source's state. Return whether the source is the current one."""
        with self._lock:
            if source is self._pending:
                source.state, source.reason = state, reason
            if source not in self._all:
                return False
            if keeps_loss and source.state is LinkState.LOST:
                state, reason = source.state, source.reason
            source.state, source.reason = state, reason
            current = source is self._current
        if current:
            self.state_changed.emit(state, reason)
        self.changed.emit(self._all)
        return current

    def _release(self, source: OpenSource) -> None:
        """Announce the end of a source that is no longer among the sources, and close it."""
        self.ending.emit(source)
        source.release()
        self._messages.forget(source)

    def _leave(self, source: OpenSource) -> None:
        """Keep a source until its thread has ended. Call with the lock held."""
        self._leaving = [*(s for s in self._leaving if not s.worker.close(0)), source]
