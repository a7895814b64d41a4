"""Follows open sources: losses and returns, who has control, and notices of the camera."""

from __future__ import annotations

import time
from collections.abc import Callable

from grabbergui.core.grabber import ConnectionState, FrameGrabber
from grabbergui.models.messages import Cause
from grabbergui.models.open_source import LinkState, OpenSource
from grabbergui.models.open_sources import OpenSources
from grabbergui.models.source_messages import LinkMessages


class SourceWatch:
    """Brings what grabbers report of themselves into the state and the messages of their sources.

    It does so on the grabbers' threads.
    """

    def __init__(
        self, open_sources: OpenSources, reports: LinkMessages, take_control: Callable[[], None]
    ) -> None:
        """`take_control` is offered for a source that is open for reading only."""
        self._open_sources = open_sources
        self._reports = reports
        self._take_control = take_control
        open_sources.opened.connect(self._on_opened)

    def follow(self, source: OpenSource, grabber: FrameGrabber) -> None:
        """Follow a source's grabber, which is not open yet."""
        grabber.connection_changed.connect(
            lambda state, reason: self._on_connection_changed(source, state, reason), check_nargs=False
        )
        grabber.held_changed.connect(lambda held: self._on_held_changed(source, held), check_nargs=False)
        grabber.noticed.connect(lambda text: self._reports.model.notice(text, source), check_nargs=False)

    def _on_opened(self, source: OpenSource) -> None:
        self._reports.ready(source, self._take_control)

    def _on_connection_changed(self, source: OpenSource, state: ConnectionState, reason: str) -> None:
        if state is ConnectionState.LOST and (source.state, source.reason) != (LinkState.LOST, reason):
            if source.lost_since is None:  # otherwise the same loss has a new reason
                source.losses += 1
                source.lost_since = time.monotonic()
            self._open_sources.set_state(source, LinkState.LOST, reason)
            if source in self._open_sources.all:
                self._reports.lost(source, reason)
        elif state is ConnectionState.OPEN and source.state is LinkState.LOST and source.grabber is not None:
            streaming = source.grabber.streaming
            back = LinkState.STREAMING if streaming else LinkState.OPEN
            self._open_sources.set_state(source, back, reason)
            if source in self._open_sources.all and source.lost_since is not None:
                self._reports.back(source, time.monotonic() - source.lost_since, reason)
            source.lost_since = None
            if source.features is not None:
                source.features.reload()
        elif state is ConnectionState.OPEN and source.features is not None:
            source.features.reload()  # a remote camera's controls may be discovered late

    def _on_held_changed(self, source: OpenSource, held: bool) -> None:
        if source.note_held(held) and source.state.connected:
            # Show the new reason even if the old one was dismissed.
            self._reports.model.end(source, Cause.ACCESS)
            if source is self._open_sources.current:
                self._reports.ready(source, self._take_control)
