"""The connection to one source: opening, streaming, closing, and what became of it."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from enum import Enum

from psygnal import Signal

from grabbergui import sources
from grabbergui.core.errors import AccessDeniedError, GrabberError
from grabbergui.core.grabber import Access, ConnectionState, FrameGrabber
from grabbergui.core.uri import SourceUri
from grabbergui.models.feature_tree import FeatureTreeModel
from grabbergui.models.feature_worker import FeatureWorker

log = logging.getLogger(__name__)


class LinkState(Enum):
    """Where the connection stands, as the window shows it."""

    CLOSED = "closed"
    OPENING = "opening"
    OPEN = "open"
    STREAMING = "streaming"
    LOST = "lost"

    @property
    def connected(self) -> bool:
        """Whether there is a source whose features can be used."""
        return self in (LinkState.OPEN, LinkState.STREAMING)


class OpenSource:
    """One source from being opened to being closed, and the one thread that calls it."""

    def __init__(self, uri: SourceUri) -> None:
        self.uri = uri
        self.worker = FeatureWorker(f"features {uri}")
        self.grabber: FrameGrabber | None = None
        "None until it is created, on the worker."
        self.features: FeatureTreeModel | None = None
        "None until the grabber is open."
        self.streaming_since: float | None = None
        "`time.monotonic` of the last start."
        self.read_only = ""
        "Why values can be looked at but not changed, for people; empty where they can be changed."
        self.no_picture = ""
        "Why the picture cannot be had beside the program that has control."
        self.abandoned = threading.Event()
        "Set when nobody wants it any more; a job that has not begun then does nothing."

    @property
    def title(self) -> str:
        """The name for people."""
        return self.grabber.info.title if self.grabber is not None else str(self.uri)

    def let_go(self) -> None:
        """Close it after the job at hand, on its own thread, which then ends. Never waits."""
        self.abandoned.set()
        if self.features is not None:
            self.features.close()
        self.worker.submit(self._close)
        self.worker.close(0)

    def _close(self) -> None:
        if self.features is not None:
            self.features.close()  # made by a job that was under way when it was let go
        if self.grabber is not None:
            self.grabber.close()


class Connection:
    """Connects to one source at a time. No call waits; signals come from the source's own thread.

    `connect_to` closes what was open. A source that is slow to close does not hold up the next one; its
    late answers are ignored.
    """

    state_changed = Signal(LinkState, str)
    """The new state, and why, for people."""
    opened = Signal(OpenSource)
    """A source can be used: its grabber is open."""
    closing = Signal(OpenSource)
    """A source is about to be closed: let go of its grabber."""
    failed = Signal(str)
    """Something that was asked for did not work, in a sentence for people."""
    read_only = Signal(OpenSource)
    """A source is held by another program: it was opened beside that one, for looking only."""

    def __init__(self, create: Callable[[SourceUri], FrameGrabber] = sources.create) -> None:
        self._create = create
        self._source: OpenSource | None = None
        self._state = LinkState.CLOSED
        self._reason = ""
        self._lock = threading.Lock()
        self._leaving: list[OpenSource] = []

    @property
    def state(self) -> LinkState:
        """Where it stands now. Any thread."""
        return self._state

    @property
    def reason(self) -> str:
        """Why, for people."""
        return self._reason

    @property
    def source(self) -> OpenSource | None:
        """What is open or being opened."""
        return self._source

    def connect_to(self, uri: str, *, start: bool = True) -> None:
        """Open a source, and `start` it. Raises UsageError for a malformed URI; all else by `failed`."""
        parsed = SourceUri.parse(uri)
        self.disconnect()
        source = OpenSource(parsed)
        with self._lock:
            self._source = source
        self._change(source, LinkState.OPENING, f"Connecting to {parsed}")

        def failed(error: GrabberError) -> None:
            self._give_up(source, str(error))

        source.worker.submit(
            lambda: self._open(source), done=lambda _: self._opened(source, start), failed=failed
        )

    def disconnect(self) -> None:
        """Close what is open; does nothing where nothing is."""
        if (source := self._source) is not None:
            self._end(source, "")

    def take_control(self) -> None:
        """Open a source that is open for reading only once more; it may have been given up meanwhile."""
        if (source := self._source) is not None and source.read_only:
            self.connect_to(str(source.uri))

    def start(self) -> None:
        """Start streaming, on the source's own thread."""
        if (source := self._source) is not None and self._state is LinkState.OPEN:
            self._start(source)

    def stop(self) -> None:
        """Stop streaming, on the source's own thread."""
        source = self._source
        if source is None or source.grabber is None or self._state is not LinkState.STREAMING:
            return
        source.worker.submit(
            source.grabber.stop,
            done=lambda _: self._change(source, LinkState.OPEN, ""),
            failed=lambda error: self._complain(source, f"stopping failed: {error}"),
        )

    def wait_closed(self, timeout: float) -> bool:
        """Whether every source that was let go is closed and its thread ended, within `timeout` seconds."""
        deadline = time.monotonic() + timeout
        with self._lock:
            leaving = list(self._leaving)
        ended = [s for s in leaving if s.worker.close(max(0.0, deadline - time.monotonic()))]
        with self._lock:
            self._leaving = [source for source in self._leaving if source not in ended]
        return len(ended) == len(leaving)

    # -- on the source's own thread ---------------------------------------------------------------
    def _open(self, source: OpenSource) -> None:
        if source.abandoned.is_set():
            return
        grabber = self._create(source.uri)
        source.grabber = grabber
        grabber.connection_changed.connect(
            lambda state, reason: self._noticed(source, state, reason), check_nargs=False
        )
        try:
            grabber.open()
        except AccessDeniedError as error:
            self._open_beside(source, grabber, error)
        source.features = FeatureTreeModel(grabber, source.worker)

    @staticmethod
    def _open_beside(source: OpenSource, grabber: FrameGrabber, denied: AccessDeniedError) -> None:
        """Look at what another program controls. Raises `denied` where even that is not possible."""
        try:
            grabber.open(Access.MONITOR)
        except GrabberError as error:
            log.info("%s, for reading only: %s", source.uri, error)
            raise denied from error
        source.read_only = str(denied)

    def _opened(self, source: OpenSource, start: bool) -> None:
        if source.abandoned.is_set():
            return
        self._change(source, LinkState.OPEN, "")
        self.opened.emit(source)
        if source.read_only:
            self.read_only.emit(source)
        if start:
            self._start(source)

    def _start(self, source: OpenSource) -> None:
        def job() -> None:
            if not source.abandoned.is_set() and source.grabber is not None:
                source.streaming_since = time.monotonic()
                source.grabber.start()

        def done(_: None) -> None:
            self._change(source, LinkState.STREAMING, "")

        def failed(error: GrabberError) -> None:
            if source.read_only and isinstance(error, AccessDeniedError):
                source.no_picture = str(error)
            else:
                self._complain(source, f"{source.title} does not start: {error}")

        source.worker.submit(job, done=done, failed=failed)

    def _noticed(self, source: OpenSource, state: ConnectionState, reason: str) -> None:
        """The grabber itself says what became of its connection. Any thread."""
        if state is ConnectionState.LOST:
            self._change(source, LinkState.LOST, reason)
            self._complain(source, reason or f"the connection to {source.title} was lost")
        elif state is ConnectionState.OPEN and self._state is LinkState.LOST and source.grabber is not None:
            streaming = source.grabber.streaming
            self._change(source, LinkState.STREAMING if streaming else LinkState.OPEN, reason)

    # -- any thread ------------------------------------------------------------------------------
    def _change(self, source: OpenSource, state: LinkState, reason: str) -> None:
        with self._lock:
            if source is not self._source:
                return
            self._state, self._reason = state, reason
        self.state_changed.emit(state, reason)

    def _complain(self, source: OpenSource, message: str) -> None:
        if source is self._source:
            self.failed.emit(message)

    def _give_up(self, source: OpenSource, message: str) -> None:
        if self._end(source, message):
            self.failed.emit(message)

    def _end(self, source: OpenSource, reason: str) -> bool:
        with self._lock:
            if source is not self._source:
                return False
            self._source = None
            self._state, self._reason = LinkState.CLOSED, reason
            self._leaving = [*(s for s in self._leaving if not s.worker.close(0)), source]
        self.closing.emit(source)
        source.let_go()
        self.state_changed.emit(LinkState.CLOSED, reason)
        return True
