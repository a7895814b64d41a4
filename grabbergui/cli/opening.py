"""Shared by commands that open a source: its options, its control, and the wait for a lost source."""

from __future__ import annotations

import argparse
import math
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from grabbergui import sources
from grabbergui.cli import wait_time
from grabbergui.core.errors import AccessDeniedError, GrabberError, TransportError
from grabbergui.setup.completion import Seen, somebody_types

if TYPE_CHECKING:  # help needs no numpy
    from grabbergui.core.grabber import ConnectionState, FrameGrabber


def add_source(parser: argparse.ArgumentParser) -> None:
    """Add the SOURCE argument."""
    parser.add_argument(
        "source", metavar="SOURCE", help="the camera or recording, such as gige: or gige:SERIAL"
    )


def add_monitor(parser: argparse.ArgumentParser) -> None:
    """Add `--monitor`, for `opened`."""
    parser.add_argument(
        "--monitor",
        action="store_true",
        help="only read, while another program has control; a GigE camera must multicast its stream",
    )


@contextmanager
def opened(uri: str, *, reading: bool = False, monitor: bool | None = None) -> Iterator[FrameGrabber]:
    """Open the source, and close it after the block.

    With `reading`, a source that another application controls is opened without control. `monitor` is whether
    `--monitor` was given; None if the command does not have it.
    """
    from grabbergui.core.grabber import Access

    grabber = sources.create(uri)
    if monitor:
        grabber.open(Access.MONITOR)
    else:
        _take_control(grabber, reading=reading, hint="" if monitor is None else ", or look on with --monitor")
    try:
        if somebody_types():
            Seen().keep_features(uri, sorted(each.name for each in grabber.feature_tree().descriptions()))
        yield grabber
    finally:
        grabber.close()


def _take_control(grabber: FrameGrabber, *, reading: bool, hint: str) -> None:
    """Open the grabber; if another application has control, raise an error with the alternatives."""
    from grabbergui.core.grabber import Access

    try:
        grabber.open(Access.CONTROL)
    except AccessDeniedError as denied:
        if not (reading or hint):
            raise
        try:
            grabber.open(Access.MONITOR)
        except GrabberError:
            raise denied from None
        if reading:
            return
        grabber.close()
        raise AccessDeniedError(f"{denied}{hint}") from denied


def add_lost_timeout(parser: argparse.ArgumentParser) -> None:
    """Add `--lost-timeout`, for `Outage`."""
    parser.add_argument(
        "--lost-timeout",
        type=wait_time,
        metavar="S",
        help="give up a lost source after S seconds; without it, wait forever",
    )


class Outage:
    """Watches whether a grabber is lost, and for how long. Any thread."""

    def __init__(
        self,
        grabber: FrameGrabber,
        limit: float | None,
        *,
        on_exceeded: Callable[[], None] = lambda: None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """`on_exceeded` is called on its own thread once the grabber has been lost for `limit` seconds."""
        self._grabber = grabber
        self._limit = limit
        self._on_exceeded = on_exceeded
        self._clock = clock
        self._reason = ""
        self._since: float | None = None
        self._ended = -math.inf
        self._timer: threading.Timer | None = None
        grabber.connection_changed.connect(self._on_connection_changed)

    @property
    def present(self) -> bool:
        """Whether the source is lost now."""
        return self._since is not None

    def waited(self, since: float) -> float:
        """Return seconds since `since` or the source's return, whichever is later; 0 while it is lost."""
        return 0.0 if self.present else self._clock() - max(since, self._ended)

    def check(self) -> None:
        """Raise TransportError if the source has been lost for longer than the limit."""
        since = self._since
        if since is not None and self._limit is not None and self._clock() - since >= self._limit:
            raise TransportError(
                f"{self._grabber.info.title} was lost and did not come back within {self._limit:g} s:"
                f" {self._reason}"
            )

    def close(self) -> None:
        """Stop watching. May be called twice."""
        self._grabber.connection_changed.disconnect(self._on_connection_changed, missing_ok=True)
        self._stop_timer()

    def _on_connection_changed(self, state: ConnectionState, reason: str) -> None:
        from grabbergui.core.grabber import ConnectionState

        if state is not ConnectionState.LOST:
            if self._since is not None:
                self._since, self._ended = None, self._clock()
            self._stop_timer()
            return
        self._reason = reason
        if self._since is None:
            self._since = self._clock()
            if self._limit is not None:
                self._timer = threading.Timer(min(self._limit, threading.TIMEOUT_MAX), self._on_exceeded)
                self._timer.daemon = True
                self._timer.start()

    def _stop_timer(self) -> None:
        timer, self._timer = self._timer, None
        if timer is not None:
            timer.cancel()
