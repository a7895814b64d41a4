"""The connection to sources: opening, streaming, closing, and what became of them."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from psygnal import Signal

from grabbergui import sources
from grabbergui.core.errors import (
    AccessDeniedError,
    DeviceLostError,
    FeatureError,
    GrabberError,
    TransportError,
)
from grabbergui.core.grabber import Access, ConnectionState, DeviceInfo, FrameGrabber
from grabbergui.core.uri import SourceUri
from grabbergui.models.error_text import error_text, lost_text, returned_text
from grabbergui.models.language import translate
from grabbergui.models.messages import ERROR_SECONDS, Cause, Message, MessageModel, Offer, Severity
from grabbergui.models.open_source import LinkState, OpenSource

CLOSE_PATIENCE = 10.0
"Seconds that a camera may take to be closed, before it is opened again by another name."
BACK_SECONDS = 10.0
"How long it is said that a source is back, or that it did not answer once."


class Connection:
    """Connects to sources, one of which is at hand. No call waits; signals come from the sources' threads.

    `connect_to` closes what is at hand once the other source is open, so that a wrong address costs nothing;
    `connect_beside` leaves it there. A source that is slow to close does not hold up the next one; its late
    answers are ignored.
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
    candidate_changed = Signal(object)
    """What is being opened in place of what is at hand (OpenSource); None once it is there or given up."""
    failed = Signal(str)
    """Something that was asked for did not work, in a sentence for people."""

    def __init__(
        self,
        create: Callable[[SourceUri], FrameGrabber] = sources.create,
        messages: MessageModel | None = None,
    ) -> None:
        self.messages = messages or MessageModel()
        """What is said of the sources: who does not answer, who is back, what was refused."""
        self._create = create
        self._source: OpenSource | None = None
        self._sources: tuple[OpenSource, ...] = ()
        self._candidate: OpenSource | None = None
        self._why_closed = ""
        self._lock = threading.Lock()
        self._passing = threading.RLock()
        "Held from one source at hand to the next: each is told to be put aside before another comes."
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
    def candidate(self) -> OpenSource | None:
        """What is being opened in place of what is at hand."""
        return self._candidate

    @property
    def sources(self) -> tuple[OpenSource, ...]:
        """All that is open or being opened, in that order."""
        return self._sources

    def connect_to(self, uri: str, *, start: bool = True) -> None:
        """Open a source in place of what is at hand, and `start` it; one that is aside is brought forward.

        What is at hand stays there until the other is open, unless it is the same or not open itself.
        Raises UsageError for a malformed URI; all else by `failed`.
        """
        parsed = SourceUri.parse(uri)
        self.messages.end(None, Cause.OPENING)
        self.give_up_candidate()
        before = self._source
        if (aside := self._aside(parsed)) is not None:
            self.bring_forward(aside)
        elif before is None or before.state is LinkState.OPENING or before.is_named(parsed):
            if before is not None:
                self._end(before, "")
            self._begin(parsed, start, at_hand=True)
        else:
            self._begin_instead(parsed, start, before)

    def replaced_by(self, uri: str) -> OpenSource | None:
        """The source that `connect_to` would close. Raises UsageError for a malformed URI."""
        return None if self._aside(SourceUri.parse(uri)) is not None else self._source

    def give_up_candidate(self) -> None:
        """Open nothing in place of what is at hand after all; does nothing where nothing was to be."""
        if (source := self._candidate) is not None and self._drop(source):
            self.candidate_changed.emit(None)

    def connect_beside(self, uri: str, *, start: bool = True) -> None:
        """Open one source more and leave what is at hand there. Raises UsageError as `connect_to`."""
        parsed = SourceUri.parse(uri)
        self.messages.end(None, Cause.OPENING)
        at_hand = self._source
        if at_hand is not None and (self._aside(parsed) or at_hand.is_named(parsed)):
            self._fail(translate("Connection", "{0} is open already").format(parsed))
        else:
            self._begin(parsed, start, at_hand=at_hand is None)

    def bring_forward(self, source: OpenSource) -> None:
        """Have another of the open sources at hand."""
        with self._passing:
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
        self.give_up_candidate()
        for source in self._sources:
            self._end(source, "")

    def _begin(self, uri: SourceUri, start: bool, *, at_hand: bool, access: Access = Access.CONTROL) -> None:
        source = OpenSource(uri, access)
        with self._lock:
            self._sources = (*self._sources, source)
            if at_hand:
                self._source = source
        self._change(source, LinkState.OPENING, f"Connecting to {uri}")
        self._submit_opening(source, start)

    def _begin_instead(self, uri: SourceUri, start: bool, before: OpenSource) -> None:
        source = OpenSource(uri)
        source.instead_of = before
        with self._lock:
            self._candidate = source
        self.candidate_changed.emit(source)
        self._submit_opening(source, start)

    def _submit_opening(self, source: OpenSource, start: bool) -> None:
        def failed(error: GrabberError) -> None:
            self._give_up(source, error_text(error, source.uri))

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
            self._begin(source.exact_uri, start=True, at_hand=True, access=Access.TAKE_OVER)

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
            failed=lambda error: self._complain(
                source, translate("Connection", "stopping failed: {0}").format(error_text(error))
            ),
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
        grabber.noticed.connect(lambda text: self.messages.notice(text, source), check_nargs=False)
        try:
            grabber.open(source.access)
        except GrabberError as error:
            if self._make_way(source, grabber.info):
                grabber.open(source.access)
            elif isinstance(error, AccessDeniedError):
                source.open_beside(error)
                if self._make_way(source, grabber.info):  # only now it has said who it is
                    grabber.close()
                    source.read_only = ""
                    grabber.open(source.access)
            else:
                raise
        source.equip()
        assert source.features is not None
        source.features.failed.connect(lambda error: self._feature_failed(source, error))

    def _make_way(self, source: OpenSource, info: DeviceInfo) -> bool:
        """Close what stands in the way of the same camera by another name, and wait. Whether that was so."""
        before = source.instead_of
        if before is None or not before.is_device(info):
            return False
        source.comes_back = before.exact_uri
        return self._take_place(source) and before.worker.close(CLOSE_PATIENCE)

    def _opened(self, source: OpenSource, start: bool) -> None:
        if source.abandoned.is_set():
            return
        if source.instead_of is not None and not self._take_place(source):
            return
        if self._change(source, LinkState.OPEN, ""):
            self._announce(source)
        if source.access is Access.TAKE_OVER and not source.read_only:
            text = translate("Connection", "this window has control now: values can be changed")
            self.messages.notice(text, source)
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
                source.no_picture = error_text(error)
            else:
                text = translate("Connection", "{0} does not start: {1}")
                self._complain(source, text.format(source.title, error_text(error)))

        source.worker.submit(job, done=done, failed=failed)

    def _noticed(self, source: OpenSource, state: ConnectionState, reason: str) -> None:
        """The grabber itself says what became of its connection. Any thread."""
        if state is ConnectionState.LOST and source.state is not LinkState.LOST:
            source.losses += 1
            source.lost_since = time.monotonic()
            self._change(source, LinkState.LOST, reason)
            self._say_lost(source, reason)
        elif state is ConnectionState.OPEN and source.state is LinkState.LOST and source.grabber is not None:
            streaming = source.grabber.streaming
            self._change(source, LinkState.STREAMING if streaming else LinkState.OPEN, reason)
            self._say_back(source, reason)
            source.lost_since = None

    def _say_lost(self, source: OpenSource, reason: str) -> None:
        if source not in self._sources:
            return
        text = translate("Connection", "reconnecting since {0}: {1}")
        text = text.format(time.strftime("%H:%M:%S"), lost_text(source.title, reason))
        self.messages.end(source, Cause.LINK)  # also for who dismissed the one before: this is news
        self.messages.post(Message(text, Severity.ERROR, source, Cause.LINK, count=source.losses))
        self.failed.emit(text)

    def _say_back(self, source: OpenSource, reason: str) -> None:
        if source not in self._sources or source.lost_since is None:
            return
        seconds = time.monotonic() - source.lost_since
        text = translate("Connection", "back after {0} s").format(f"{seconds:.{seconds < 1:d}f}")
        unlike = source.grabber.unlike_before if source.grabber is not None else ()
        if reason:
            text = f"{text}, {returned_text(unlike)}"
        severity = Severity.WARNING if unlike else Severity.NOTICE
        message = Message(text, severity, source, Cause.LINK, count=source.losses)
        self.messages.end(source, Cause.LINK)
        # What is other than before goes on being so: only the user can judge it, and dismiss it.
        self.messages.post(message, seconds=None if unlike else BACK_SECONDS)

    def _feature_failed(self, source: OpenSource, error: GrabberError) -> None:
        """A write, command or read did not work. While a source is lost, the loss alone is said."""
        if isinstance(error, DeviceLostError):
            return
        feature = None
        if isinstance(error, FeatureError) and source.features is not None:
            feature = source.features.feature(error.feature)
        text = error_text(error, feature=feature)
        if not isinstance(error, TransportError):
            self.messages.error(text, source)
        elif source.state is not LinkState.LOST:
            self.messages.post(Message(text, Severity.ERROR, source, Cause.LINK), seconds=BACK_SECONDS)

    # -- any thread ------------------------------------------------------------------------------
    def _change(self, source: OpenSource, state: LinkState, reason: str) -> bool:
        """Note a source's state and announce it. Whether it is the current one."""
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
            reason, _, _ = source.read_only.partition(";")  # what to do about it is on the button
            text = translate("Connection", "read only: {0}; values follow here but cannot be changed")
            if source.access is Access.TAKE_OVER:
                text = translate("Connection", "control was not given: {0}; still read only")
            offer = Offer(translate("Connection", "Take control"), self.take_control)
            self.messages.post(
                Message(text.format(reason), source=source, cause=Cause.ACCESS, offers=(offer,))
            )

    def _complain(self, source: OpenSource, message: str) -> None:
        if source in self._sources:
            self.messages.error(message, source)
            self.failed.emit(message)

    def _fail(self, message: str) -> None:
        """No source could be opened."""
        self.messages.post(Message(message, Severity.ERROR, cause=Cause.OPENING), seconds=ERROR_SECONDS)
        self.failed.emit(message)

    def _give_up(self, source: OpenSource, message: str) -> None:
        if self._drop(source):
            self.candidate_changed.emit(None)
            self._fail(message)
        elif self._end(source, message):
            self._fail(message)
            if source.comes_back is not None:
                self._begin(source.comes_back, start=True, at_hand=True)
            else:
                self._fill_hand()

    def _drop(self, candidate: OpenSource) -> bool:
        """Let go of what was to come to hand. Whether it still was."""
        with self._lock:
            if candidate is not self._candidate:
                return False
            self._candidate = candidate.instead_of = None
            self._leave(candidate)
        candidate.let_go()
        return True

    def _take_place(self, source: OpenSource) -> bool:
        """Have the candidate at hand, and close what it comes instead of. Whether it still was to come."""
        with self._passing:
            with self._lock:
                if source is not self._candidate:
                    return False
                before, at_hand = source.instead_of, self._source
                self._candidate = source.instead_of = None
                self._source = source
                if before is None or before not in self._sources:
                    before, self._sources = None, (*self._sources, source)
                else:
                    self._sources = tuple(source if other is before else other for other in self._sources)
                    self._leave(before)
            self.candidate_changed.emit(None)
            if at_hand is not None:
                self.closing.emit(at_hand)
        if before is not None:
            self.ending.emit(before)
            before.let_go()
            self.messages.forget(before)
        self.state_changed.emit(LinkState.OPENING, f"Connecting to {source.uri}")
        self.sources_changed.emit(self._sources)
        return True

    def _aside(self, uri: SourceUri) -> OpenSource | None:
        """The source aside that a URI names."""
        return next((s for s in self._sources if s is not self._source and s.is_named(uri)), None)

    def _fill_hand(self) -> None:
        """With nothing at hand, bring forward what was opened last."""
        if self._source is None and self._sources:
            self.bring_forward(self._sources[-1])

    def _end(self, source: OpenSource, reason: str) -> bool:
        with self._passing:
            with self._lock:
                if source not in self._sources:
                    return False
                self._sources = tuple(other for other in self._sources if other is not source)
                at_hand = source is self._source
                if at_hand:
                    self._source, self._why_closed = None, reason
                self._leave(source)
            if at_hand:
                self.closing.emit(source)
        self.ending.emit(source)
        source.let_go()
        self.messages.forget(source)
        if at_hand:
            self.state_changed.emit(LinkState.CLOSED, reason)
        self.sources_changed.emit(self._sources)
        return True

    def _leave(self, source: OpenSource) -> None:
        """Remember what is being closed, until its thread has ended. With the lock held."""
        self._leaving = [*(s for s in self._leaving if not s.worker.close(0)), source]
