"""The connection to sources: opening, streaming, closing, and what became of them."""

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
from grabbergui.models.changes.journal import ChangeJournal
from grabbergui.models.changes.noting import NotingGrabber
from grabbergui.models.features.tree import FeatureTreeModel
from grabbergui.models.features.worker import FeatureWorker

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

    def __init__(self, uri: SourceUri, access: Access = Access.CONTROL) -> None:
        self.uri = uri
        self.access = access
        "What is asked for on opening."
        self.state = LinkState.OPENING
        "Where it stands."
        self.reason = ""
        "Why, for people."
        self.worker = FeatureWorker(f"features {uri}")
        self.grabber: FrameGrabber | None = None
        "None until it is created, on the worker."
        self.hands: NotingGrabber | None = None
        "The operator's handle on the grabber: what is done with it can be looked at and undone."
        self.features: FeatureTreeModel | None = None
        "None until the grabber is open, and so is `hands`."
        self.journal = ChangeJournal()
        "What happened to its features."
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

    @property
    def short_title(self) -> str:
        """What tells it from its neighbours: the name without the maker's."""
        info = self.grabber.info if self.grabber is not None else None
        return (info.user_name or info.model or info.title) if info is not None else str(self.uri)

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
        if self.hands is not None:
            self.hands.close()
        if self.grabber is not None:
            self.grabber.close()


class Connection:
    """Connects to sources, one of which is at hand. No call waits; signals come from the sources' threads.

    `connect_to` closes what was at hand, `connect_beside` leaves it there. A source that is slow to close
    does not hold up the next one; its late answers are ignored.
    """

    state_changed = Signal(LinkState, str)
    """The new state of the source at hand, and why, for people."""
    opened = Signal(OpenSource)
    """A source is at hand and can be used: its grabber is open."""
    closing = Signal(OpenSource)
    """The source at hand is about to be closed or put aside: let go of its grabber."""
    ending = Signal(OpenSource)
    """A source, at hand or aside, is about to be closed: let go of its grabber."""
    sources_changed = Signal(tuple)
    """All sources (tuple[OpenSource, ...]): one more, one less, another at hand, or in another state."""
    failed = Signal(str)
    """Something that was asked for did not work, in a sentence for people."""
    noticed = Signal(str)
    """What a source says while its connection holds, in a sentence for people."""
    read_only = Signal(OpenSource)
    """A source is held by another program: it was opened beside that one, for looking only."""

    def __init__(self, create: Callable[[SourceUri], FrameGrabber] = sources.create) -> None:
        self._create = create
        self._source: OpenSource | None = None
        self._sources: tuple[OpenSource, ...] = ()
        self._why_closed = ""
        self._lock = threading.Lock()
        self._leaving: list[OpenSource] = []

    @property
    def state(self) -> LinkState:
        """Where the source at hand stands now. Any thread."""
        source = self._source
        return source.state if source is not None else LinkState.CLOSED

    @property
    def reason(self) -> str:
        """Why, for people."""
        source = self._source
        return source.reason if source is not None else self._why_closed

    @property
    def source(self) -> OpenSource | None:
        """What is at hand: open or being opened."""
        return self._source

    @property
    def sources(self) -> tuple[OpenSource, ...]:
        """All that is open or being opened, in that order."""
        return self._sources

    def connect_to(self, uri: str, *, start: bool = True) -> None:
        """Open a source in place of what is at hand, and `start` it; one that is aside is brought forward.

        Raises UsageError for a malformed URI; all else by `failed`.
        """
        parsed = SourceUri.parse(uri)
        if (aside := self._aside(parsed)) is not None:
            self.bring_forward(aside)
            return
        if (before := self._source) is not None:
            self._end(before, "")
        self._begin(parsed, start, at_hand=True)

    def connect_beside(self, uri: str, *, start: bool = True) -> None:
        """Open one source more and leave what is at hand there. Raises UsageError as `connect_to`."""
        parsed = SourceUri.parse(uri)
        at_hand = self._source
        if at_hand is not None and (self._aside(parsed) or _is_named(at_hand, parsed)):
            self.failed.emit(f"{parsed} is open already")
        else:
            self._begin(parsed, start, at_hand=at_hand is None)

    def bring_forward(self, source: OpenSource) -> None:
        """Have another of the open sources at hand."""
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

    def close(self, source: OpenSource) -> None:
        """Close one source, at hand or aside; the one opened last comes in its place."""
        self._end(source, "")
        self._fill_hand()

    def close_all(self) -> None:
        """Close every source."""
        for source in self._sources:
            self._end(source, "")

    def _begin(
        self, uri: SourceUri, start: bool, *, at_hand: bool, access: Access = Access.CONTROL
    ) -> None:
        source = OpenSource(uri, access)
        with self._lock:
            self._sources = (*self._sources, source)
            if at_hand:
                self._source = source
        self._change(source, LinkState.OPENING, f"Connecting to {uri}")

        def failed(error: GrabberError) -> None:
            self._give_up(source, str(error))

        source.worker.submit(
            lambda: self._open(source), done=lambda _: self._opened(source, start), failed=failed
        )

    def disconnect(self) -> None:
        """Close what is at hand; does nothing where nothing is."""
        if (source := self._source) is not None:
            self.close(source)

    def take_control(self) -> None:
        """Open a source that is open for reading only once more, to control it.

        The other program may have closed it meanwhile, or offer control to who asks on purpose, as ours do.
        """
        if (source := self._source) is not None and source.read_only:
            self._end(source, "")
            self._begin(source.uri, start=True, at_hand=True, access=Access.TAKE_OVER)

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
            self._change(source, LinkState.OPEN, "")

        source.worker.submit(
            source.grabber.stop,
            done=stopped,
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
        grabber.noticed.connect(lambda text: self._pass_on(source, text), check_nargs=False)
        try:
            grabber.open(source.access)
        except AccessDeniedError as error:
            self._open_beside(source, grabber, error)
        hands = NotingGrabber(grabber, source.journal)
        hands.open()
        features = FeatureTreeModel(hands, source.worker, hands.watch)
        features.structure_changed.connect(hands.learn)
        source.hands, source.features = hands, features

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
        if self._change(source, LinkState.OPEN, ""):
            self._announce(source)
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
        elif state is ConnectionState.OPEN and source.state is LinkState.LOST and source.grabber is not None:
            streaming = source.grabber.streaming
            self._change(source, LinkState.STREAMING if streaming else LinkState.OPEN, reason)

    # -- any thread ------------------------------------------------------------------------------
    def _change(self, source: OpenSource, state: LinkState, reason: str) -> bool:
        """Note and tell a source's state. Whether it is the one at hand."""
        with self._lock:
            if source not in self._sources:
                return False
            source.state, source.reason = state, reason
            at_hand = source is self._source
        if at_hand:
            self.state_changed.emit(state, reason)
        self.sources_changed.emit(self._sources)
        return at_hand

    def _announce(self, source: OpenSource) -> None:
        """Say that a source at hand can be used, and with which restriction."""
        self.opened.emit(source)
        if source.read_only:
            self.read_only.emit(source)

    def _pass_on(self, source: OpenSource, text: str) -> None:
        if source in self._sources:
            self.noticed.emit(text)

    def _complain(self, source: OpenSource, message: str) -> None:
        if source in self._sources:
            self.failed.emit(message)

    def _give_up(self, source: OpenSource, message: str) -> None:
        if self._end(source, message):
            self.failed.emit(message)
            self._fill_hand()

    def _aside(self, uri: SourceUri) -> OpenSource | None:
        """The source aside that a URI names."""
        return next((s for s in self._sources if s is not self._source and _is_named(s, uri)), None)

    def _fill_hand(self) -> None:
        """With nothing at hand, bring forward what was opened last."""
        if self._source is None and self._sources:
            self.bring_forward(self._sources[-1])

    def _end(self, source: OpenSource, reason: str) -> bool:
        with self._lock:
            if source not in self._sources:
                return False
            self._sources = tuple(other for other in self._sources if other is not source)
            at_hand = source is self._source
            if at_hand:
                self._source, self._why_closed = None, reason
            self._leaving = [*(s for s in self._leaving if not s.worker.close(0)), source]
        if at_hand:
            self.closing.emit(source)
        self.ending.emit(source)
        source.let_go()
        if at_hand:
            self.state_changed.emit(LinkState.CLOSED, reason)
        self.sources_changed.emit(self._sources)
        return True


def _is_named(source: OpenSource, uri: SourceUri) -> bool:
    """Whether a URI is how a source was asked for, or what it calls itself."""
    return source.uri == uri or (source.grabber is not None and source.grabber.info.uri == str(uri))
