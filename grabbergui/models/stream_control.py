"""Starts and stops the streams of open sources."""

from __future__ import annotations

from grabbergui.core.errors import AccessDeniedError, GrabberError
from grabbergui.models.error_text import error_text
from grabbergui.models.language import translate
from grabbergui.models.open_source import LinkState, OpenSource
from grabbergui.models.open_sources import OpenSources
from grabbergui.models.source_messages import LinkMessages


class StreamControl:
    """Starts and stops the streams of open sources on their own threads. Methods return immediately."""

    def __init__(self, open_sources: OpenSources, reports: LinkMessages) -> None:
        self._open_sources = open_sources
        self._reports = reports

    def start(self) -> None:
        """Start the stream of the current source, if it is open and stopped."""
        if (source := self._open_sources.current) is not None and source.state is LinkState.OPEN:
            self.start_source(source)

    def start_source(self, source: OpenSource) -> None:
        """Start the stream of a source once its thread has done what was asked before."""

        def job() -> None:
            if not source.abandoned.is_set() and source.grabber is not None:
                source.grabber.start()

        def done(_: None) -> None:
            self._open_sources.reach(source, LinkState.STREAMING)

        def failed(error: GrabberError) -> None:
            if source.read_only and isinstance(error, AccessDeniedError):
                source.no_frames = error_text(error)
                self._open_sources.set_state(source, source.state, source.reason)  # *Start* says why
            else:
                text = translate("Connection", "{0} does not start: {1}")
                self._report(source, text.format(source.title, error_text(error)))

        source.worker.submit(job, done=done, failed=failed)

    def stop(self) -> None:
        """Stop the stream of the current source."""
        source = self._open_sources.current
        if source is None or source.grabber is None or source.state is not LinkState.STREAMING:
            return

        def stopped(_: None) -> None:
            self._open_sources.reach(source, LinkState.OPEN)

        def failed(error: GrabberError) -> None:
            self._report(source, translate("Connection", "stopping failed: {0}").format(error_text(error)))

        source.worker.submit(source.grabber.stop, done=stopped, failed=failed)

    def _report(self, source: OpenSource, text: str) -> None:
        if source in self._open_sources.all:
            self._reports.stream_failed(source, text)
