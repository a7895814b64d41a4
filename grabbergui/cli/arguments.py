"""Arguments that commands share: their types, which refuse bad values at once, and the source to open."""

from __future__ import annotations

import argparse
import math
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from grabbergui import sources
from grabbergui.core.errors import AccessDeniedError, GrabberError, TransportError
from grabbergui.core.uri import is_ip_address
from grabbergui.setup.seen import Seen, somebody_types

if TYPE_CHECKING:  # help needs no numpy
    from grabbergui.core.features import Feature
    from grabbergui.core.grabber import ConnectionState, FrameGrabber

LONGEST = 2_000_000
"""Seconds, 23 days: Qt and the system count the milliseconds of a wait in 31 bits."""


def count(text: str) -> int:
    """Parse a whole number of at least 1."""
    return _whole(text, 1, None)


def count_or_none(text: str) -> int:
    """Parse a whole number of at least 0."""
    return _whole(text, 0, None)


def port(text: str) -> int:
    """Parse a TCP port; 0 stands for any free one."""
    return _whole(text, 0, 0xFFFF)


def key(text: str) -> int:
    """Parse a number of 32 bits, decimal or hexadecimal."""
    try:
        return _whole(text, 0, 0xFFFFFFFF)
    except argparse.ArgumentTypeError:
        raise argparse.ArgumentTypeError(f"'{text}' is not a number from 0 to 0xFFFFFFFF") from None


def positive(text: str) -> float:
    """Parse a finite number above 0."""
    value = _finite(text)
    if value <= 0:
        raise argparse.ArgumentTypeError(f"'{text}' is not more than 0")
    return value


def not_negative(text: str) -> float:
    """Parse a finite number of at least 0."""
    value = _finite(text)
    if value < 0:
        raise argparse.ArgumentTypeError(f"'{text}' is less than 0")
    return value


def part(text: str) -> float:
    """Parse a share: `1%` or `0.01`."""
    value = not_negative(text.removesuffix("%")) / (100 if text.endswith("%") else 1)
    if value > 1:
        raise argparse.ArgumentTypeError(f"'{text}' is more than 100%; write 1% or 0.01")
    return value


def seconds(text: str) -> float:
    """Parse a duration of at least 0: `5ms`, `0.005s` or `0.005`."""
    if text.endswith("ms"):
        value = not_negative(text.removesuffix("ms")) / 1000
    else:
        value = not_negative(text.removesuffix("s"))
    if value > LONGEST:
        raise argparse.ArgumentTypeError(f"'{text}' is longer than {LONGEST} s")
    return value


def wait_time(text: str) -> float:
    """Parse a duration above 0, as `seconds` does."""
    value = seconds(text)
    if value == 0:
        raise argparse.ArgumentTypeError(f"'{text}' is not more than 0")
    return value


def ipv4(text: str) -> str:
    """Parse an IPv4 address in dotted notation."""
    if not is_ip_address(text):
        raise argparse.ArgumentTypeError(f"'{text}' is not an IPv4 address, such as 192.168.0.10")
    return text


def counted(number: int, noun: str) -> str:
    """Return `1 frame` or `2 frames`."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def _whole(text: str, least: int, most: int | None) -> int:
    try:
        value = int(text, 0)
    except ValueError:
        value = least - 1
    if value < least or (most is not None and value > most):
        limits = f"of at least {least}" if most is None else f"from {least} to {most}"
        raise argparse.ArgumentTypeError(f"'{text}' is not a whole number {limits}")
    return value


def _finite(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"'{text}' is not a number")
    return value


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


def remember_values(uri: str, features: Iterable[Feature]) -> None:
    """Keep the values of enumerations and switches for completion, if somebody types."""
    if somebody_types():
        Seen().keep_values(uri, features)


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
        self._before = 0.0
        self._exceeded = False
        self._timer: threading.Timer | None = None
        grabber.connection_changed.connect(self._on_connection_changed)

    @property
    def present(self) -> bool:
        """Whether the source is lost now."""
        return self._since is not None

    @property
    def seconds(self) -> float:
        """For how long the source has been lost in all."""
        since = self._since
        return self._before + (0.0 if since is None else self._clock() - since)

    def waited(self, since: float) -> float:
        """Return seconds since `since` or the source's return, whichever is later; 0 while it is lost."""
        return 0.0 if self.present else self._clock() - max(since, self._ended)

    def check(self) -> None:
        """Raise TransportError if the source was lost for longer than the limit, or `on_exceeded` ran."""
        since, limit = self._since, self._limit
        if self._exceeded or (since is not None and limit is not None and self._clock() - since >= limit):
            raise TransportError(
                f"{self._grabber.info.title} was lost and did not come back within {limit:g} s:"
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
                self._ended = self._clock()
                self._before += self._ended - self._since
                self._since = None
            self._stop_timer()
            return
        self._reason = reason
        if self._since is None:
            self._since = self._clock()
            if self._limit is not None:
                self._timer = threading.Timer(min(self._limit, threading.TIMEOUT_MAX), self._exceed)
                self._timer.daemon = True
                self._timer.start()

    def _exceed(self) -> None:
        self._exceeded = True
        self._on_exceeded()

    def _stop_timer(self) -> None:
        timer, self._timer = self._timer, None
        if timer is not None:
            timer.cancel()
