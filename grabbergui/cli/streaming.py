"""What commands that take a camera's frames share: their options, and why no frame came."""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from contextlib import contextmanager

from grabbergui.cli.features import assignment, write
from grabbergui.cli.numbers import counted, positive
from grabbergui.cli.opening import add_monitor, add_source, opened
from grabbergui.cli.outage import Outage, add_lost_timeout
from grabbergui.core.errors import FrameTimeoutError
from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import FrameQueue
from grabbergui.core.grabber import Access, FrameGrabber
from grabbergui.core.uri import SourceUri

_LOOK = 0.5
"Seconds between looks at whether the source is still there."


def add_options(parser: argparse.ArgumentParser, *, awaited: str) -> None:
    """SOURCE, and how its frames are had; `awaited` is what `--timeout` is for."""
    add_source(parser)
    parser.add_argument(
        "--set", action="append", default=[], metavar="NAME=VALUE", dest="assignments", help="set it first"
    )
    parser.add_argument(
        "--timeout", type=positive, default=5.0, metavar="S", help=f"longest wait for {awaited} (5)"
    )
    add_lost_timeout(parser)
    parser.add_argument("--keep-trigger", action="store_true", help="leave TriggerMode as it is")
    add_monitor(parser)


class FrameSource:
    """An open grabber that is waited for while it is lost."""

    def __init__(self, grabber: FrameGrabber, lost_timeout: float | None = None) -> None:
        self.grabber = grabber
        self.outage = Outage(grabber, lost_timeout)

    def next_frame(self, queue: FrameQueue, timeout: float, so_far: int) -> Frame:
        """Wait for a frame, at most `timeout` seconds of those in which the source is there.

        Raises FrameTimeoutError, TransportError if it was lost for too long.
        """
        begun = time.monotonic()
        while True:
            try:
                return queue.get(min(timeout, _LOOK))
            except FrameTimeoutError:
                self.outage.check()
                if queue.closed or self.outage.waited(begun) >= timeout:
                    raise self.no_frame(timeout, so_far) from None

    def no_frame(self, timeout: float, so_far: int = 0) -> FrameTimeoutError:
        """No frame came in time after so many: why, or what to look at."""
        title, came = self.grabber.info.title, counted(so_far, "frame")
        if SourceUri.parse(self.grabber.info.uri).scheme == "file":
            return FrameTimeoutError(f"{title} ended after {came}")
        if self.grabber.access is Access.MONITOR:
            look = "whether the application that controls it streams"
        else:
            look = "whether it waits for a trigger, and whether a firewall drops its packets"
        counters = self.grabber.statistics()
        return FrameTimeoutError(
            f"{title}: no frame within {timeout:g} s after {came} "
            f"({counters.packets} packets, {counters.incomplete} incomplete frames); see {look}"
        )


@contextmanager
def frame_source(options: argparse.Namespace) -> Iterator[FrameSource]:
    """The source as `add_options` has it, set and not yet started; closed behind the block."""
    assignments = [assignment(text) for text in options.assignments]
    with opened(options.source, monitor=options.monitor) as grabber:
        source = FrameSource(grabber, options.lost_timeout)
        for key, text in assignments:
            write(grabber, key, text)
        try:
            yield source
        finally:
            source.outage.close()
