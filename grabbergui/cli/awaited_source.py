"""A source that a command waits for: it opens, and delivers again after it was lost."""

from __future__ import annotations

import argparse
import functools
import time
from collections.abc import Iterator
from contextlib import contextmanager

from grabbergui.cli.arguments import (
    Outage,
    add_lost_timeout,
    add_monitor,
    add_source,
    counted,
    opened,
    wait_time,
)
from grabbergui.cli.features import assignment, write
from grabbergui.core.errors import FrameTimeoutError, StreamEndedError
from grabbergui.core.frame import Frame
from grabbergui.core.frame_period import FRAME_WAIT, frame_wait
from grabbergui.core.frame_queue import FrameQueue
from grabbergui.core.grabber import Access, FrameGrabber
from grabbergui.core.uri import SourceUri

_LOOK = 0.5
"Seconds between checks whether the source is still there."


class AwaitedSource:
    """An open grabber that may be lost, and waits for its return."""

    def __init__(
        self, grabber: FrameGrabber, timeout: float | None = None, lost_timeout: float | None = None
    ) -> None:
        """Without a `timeout` in seconds, a frame is waited for as long as the camera's settings suggest."""
        self.grabber = grabber
        self.outage = Outage(grabber, lost_timeout)
        self._timeout = timeout

    def next_frame(self, queue: FrameQueue, so_far: int) -> Frame:
        """Wait for a frame until the timeout, not counting seconds in which the source is lost.

        Raises FrameTimeoutError, or TransportError if the source was lost for too long.
        """
        begun, timeout = time.monotonic(), self.timeout
        while True:
            try:
                return queue.get(min(timeout, _LOOK))
            except StreamEndedError:
                raise StreamEndedError(
                    f"{self.grabber.info.title} ended after {counted(so_far, 'frame')}"
                ) from None
            except FrameTimeoutError:
                self.outage.check()
                if queue.closed or self.outage.waited(begun) >= timeout:
                    raise self.no_frame(so_far) from None

    @functools.cached_property
    def timeout(self) -> float:
        """Seconds to wait for a frame, by the settings at the first use."""
        return frame_wait(self.grabber) if self._timeout is None else self._timeout

    def no_frame(self, so_far: int = 0) -> FrameTimeoutError:
        """Return the error for a missing frame, with its cause or what to check."""
        title, came = self.grabber.info.title, counted(so_far, "frame")
        scheme = SourceUri.parse(self.grabber.info.uri).scheme
        late = f"{title}: no frame within {round(self.timeout, 2):g} s after {came}"
        if scheme == "file":
            look = "whether its playback is paused (PlaybackActive), or slow (PlaybackSpeed)"
            return FrameTimeoutError(f"{late}; see {look}")
        if scheme in ("yarp", "ros2"):
            look = "whether its program sends images, and whether a camera there waits for a trigger"
            return FrameTimeoutError(f"{late}: {self.grabber.silence()}; see {look}")
        counters = self.grabber.statistics()
        if reason := self.grabber.silence():
            return FrameTimeoutError(f"{late}: {reason}")
        if counters.incomplete and scheme == "gige":
            look = (
                "whether smaller packets arrive (?packet_size=1400 behind the source), or longer pauses help"
            )
            look += " (?packet_delay=20us)"
        elif self.grabber.access is Access.MONITOR:
            look = "whether the application that controls it streams"
        else:
            look = "whether it waits for a trigger, and whether a firewall drops its packets"
        return FrameTimeoutError(
            f"{late} ({counters.packets} packets, {counters.incomplete} incomplete frames); see {look}"
        )


@contextmanager
def awaited_source(options: argparse.Namespace) -> Iterator[AwaitedSource]:
    """Yield the source of `add_options`, set and not started; close it after the block."""
    assignments = [assignment(text) for text in options.assignments]
    with opened(options.source, monitor=options.monitor) as grabber:
        source = AwaitedSource(grabber, options.timeout, options.lost_timeout)
        for key, text in assignments:
            write(grabber, key, text)
        try:
            yield source
        finally:
            source.outage.close()


def add_options(parser: argparse.ArgumentParser, *, awaited: str) -> None:
    """Add SOURCE and the options for taking frames; `awaited` is what `--timeout` waits for."""
    add_source(parser)
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        dest="assignments",
        help="write a feature before; repeatable",
    )
    parser.add_argument(
        "--timeout",
        type=wait_time,
        metavar="S",
        help=f"longest wait for {awaited} ({FRAME_WAIT:g}, and two frame periods)",
    )
    add_lost_timeout(parser)
    parser.add_argument("--keep-trigger", action="store_true", help="leave TriggerMode as it is")
    add_monitor(parser)
