"""Opens sources: in place of the current one, in addition to it, or to control it."""

from __future__ import annotations

from collections.abc import Callable

from psygnal import Signal

from grabbergui import sources
from grabbergui.core.errors import AccessDeniedError, GrabberError
from grabbergui.core.grabber import Access, FrameGrabber
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.uri import SourceUri
from grabbergui.models.error_text import error_text
from grabbergui.models.language import translate
from grabbergui.models.messages import Cause, MessageModel
from grabbergui.models.open_source import LinkState, OpenSource
from grabbergui.models.open_sources import OpenSources
from grabbergui.models.source_messages import LinkMessages
from grabbergui.models.source_watch import SourceWatch
from grabbergui.models.stream_control import StreamControl

CLOSE_PATIENCE = 10.0
"Seconds to wait for a camera to close before it is opened again under another URI."


class SourceOpener:
    """Opens sources, each on its own thread.

    Methods return immediately. `connect_to` replaces the current source once the new one is open, so that a
    wrong address does no harm; `open_additional` keeps it. `reports.failed` reports failures.
    """

    refused = Signal(str, str)
    """The requested URI of a source that could not be opened, and the reason as display text."""

    def __init__(
        self,
        create: Callable[[SourceUri], FrameGrabber] = sources.create,
        messages: MessageModel | None = None,
    ) -> None:
        self.messages = messages or MessageModel()
        self.reports = LinkMessages(self.messages)
        self.open_sources = OpenSources(self.messages)
        self.stream = StreamControl(self.open_sources, self.reports)
        self._watch = SourceWatch(self.open_sources, self.reports, self._ask_for_control)
        self.confirm_control: Callable[[OpenSource, Callable[[], None]], None] = lambda source, take: take()
        "Asks before control is taken from another program, and calls the function if it may be."
        self.create = create
        "Makes the grabber of a URI."
        self._played: SourceUri | None = None
        "The recording that `play` opened last."

    def connect_to(self, uri: str, *, start: bool = True) -> None:
        """Open a source in place of the current one and `start` it; make a background source current.

        The current source stays until the new one is open, unless it is the same or not open yet. If several
        are open, it stays open in the background. Raises UsageError for a malformed URI; `reports.failed`
        reports other failures.
        """
        self._connect_to(SourceUri.parse(uri), start, beside=len(self.open_sources.all) > 1)

    def _connect_to(self, parsed: SourceUri, start: bool, *, beside: bool) -> None:
        """Connect; with `beside`, the current source stays open."""
        self.messages.end(None, Cause.OPENING)
        self.open_sources.cancel_pending()
        before = self.open_sources.current
        if (background := self.open_sources.in_background(parsed)) is not None:
            self.open_sources.make_current(background)
        elif before is None or before.state is LinkState.OPENING or before.is_named(parsed):
            if before is not None:
                self.open_sources.remove(before, "")
            self._begin(parsed, start, current=True)
        else:
            self._begin_pending(parsed, start, None if beside else before)

    def replaced_by(self, uri: str, *, playing: bool = False) -> OpenSource | None:
        """Return the source that `connect_to`, or `play`, would close. Raises UsageError like these."""
        parsed, current = SourceUri.parse(uri), self.open_sources.current
        if self.open_sources.in_background(parsed) is not None:
            return None
        if playing and current is not None and current.uri.scheme != parsed.scheme:
            return self.open_sources.in_background(self._played) if self._played is not None else None
        if playing or current is None:
            return current
        several = len(self.open_sources.all) > 1 and not current.is_named(parsed)
        return None if several else current

    def play(self, uri: str) -> None:
        """Make a recording current, and keep the camera that was current open.

        A recording that is current, or was played before, is replaced. Raises UsageError for a malformed URI.
        """
        replaced = self.replaced_by(uri, playing=True)
        self._played = parsed = SourceUri.parse(uri)
        before = self.open_sources.current
        in_background = self.open_sources.in_background(parsed) is not None
        if before is None or before.uri.scheme == parsed.scheme or in_background:
            self._connect_to(parsed, start=True, beside=False)
            return
        self.messages.end(None, Cause.OPENING)
        self.open_sources.make_current(self._begin(parsed, start=True, current=False))
        if replaced is not None:
            self.open_sources.remove(replaced, "")

    def open_additional(self, uri: str) -> None:
        """Open and start one more source and keep the current one. Raises UsageError for a malformed URI."""
        parsed = SourceUri.parse(uri)
        self.messages.end(None, Cause.OPENING)
        current = self.open_sources.current
        if current is not None and (self.open_sources.in_background(parsed) or current.is_named(parsed)):
            self._report_not_opened(translate("Connection", "{0} is open already").format(parsed))
        else:
            self._begin(parsed, start=True, current=current is None)

    def take_control(self) -> None:
        """Reopen the current source to control it, if it is open for reading only.

        The other program may have closed it by now, or yield control on request, as grabbergui does.
        """
        if (source := self.open_sources.current) is not None and source.read_only:
            self.open_sources.remove(source, "")
            self._begin(source.exact_uri, start=True, current=True, access=Access.TAKE_OVER)

    def _ask_for_control(self) -> None:
        """Take control of the current source, after a question if another program has it."""
        if (source := self.open_sources.current) is None or not source.read_only:
            return
        if source.held:
            self.confirm_control(source, self.take_control)
        else:
            self.take_control()

    def _begin(
        self, uri: SourceUri, start: bool, *, current: bool, access: Access = Access.CONTROL
    ) -> OpenSource:
        source = OpenSource(uri, access, lambda: self.open_sources.all)
        self.open_sources.add(source, current=current)
        self._submit_opening(source, start)
        return source

    def _begin_pending(self, uri: SourceUri, start: bool, before: OpenSource | None) -> None:
        source = OpenSource(uri, among=lambda: self.open_sources.all)
        source.replaces = before
        self.open_sources.add_pending(source)
        self._submit_opening(source, start)

    def _submit_opening(self, source: OpenSource, start: bool) -> None:
        def failed(error: GrabberError) -> None:
            self._give_up(source, error_text(error, source.uri))

        source.worker.submit(
            lambda: self._open(source), done=lambda _: self._opened(source, start), failed=failed
        )

    def _open(self, source: OpenSource) -> None:
        if source.abandoned.is_set():
            return
        grabber = self.create(source.uri)
        source.grabber = grabber
        self._watch.follow(source, grabber)
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
        source.features.failed.connect(lambda error: self.reports.feature_failed(source, error))

    def _make_way(self, source: OpenSource, info: DeviceInfo) -> bool:
        """Close the current source and wait if it is the same camera. Return whether it was closed."""
        before = source.replaces
        if before is None and source is self.open_sources.pending:
            before = self.open_sources.current
        if before is None or not before.is_device(info):
            return False
        source.replaces = before
        source.reopen_on_failure = before.exact_uri
        return self.open_sources.take_place(source) and before.worker.close(CLOSE_PATIENCE)

    def _opened(self, source: OpenSource, start: bool) -> None:
        if source.abandoned.is_set():
            return
        if source is self.open_sources.pending:
            if not self.open_sources.take_place(source):
                return
            if source.state is LinkState.LOST:
                self.reports.lost(source, source.reason)
        if self.open_sources.reach(source, LinkState.OPEN):
            self.open_sources.opened.emit(source)
        if source.access is Access.TAKE_OVER and not source.read_only:
            self.reports.took_control(source)
        if start:
            self.stream.start_source(source)

    def _report_not_opened(self, message: str) -> None:
        self.reports.not_opened(message, lasting=self.open_sources.current is None)

    def _give_up(self, source: OpenSource, message: str) -> None:
        if not source.abandoned.is_set():
            self.refused.emit(str(source.uri), message)
        if self.open_sources.drop_pending(source):
            self._report_not_opened(message)
        elif self.open_sources.remove(source, message):
            if source.reopen_on_failure is not None:
                self._begin(source.reopen_on_failure, start=True, current=True)
            else:
                self.open_sources.ensure_current()
            self._report_not_opened(message)
