"""What commands that take a camera's frames share: their options, and why no frame came."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager

from grabbergui.cli.features import assignment
from grabbergui.cli.numbers import counted, positive
from grabbergui.cli.opening import add_monitor, add_source, opened
from grabbergui.core.errors import FrameTimeoutError
from grabbergui.core.grabber import Access, ConnectionState, FrameGrabber
from grabbergui.core.uri import SourceUri


def add_options(parser: argparse.ArgumentParser, *, awaited: str) -> None:
    """SOURCE, and how its frames are had; `awaited` is what `--timeout` is for."""
    add_source(parser)
    parser.add_argument(
        "--set", action="append", default=[], metavar="NAME=VALUE", dest="assignments", help="set it first"
    )
    parser.add_argument(
        "--timeout", type=positive, default=5.0, metavar="S", help=f"longest wait for {awaited} (5)"
    )
    parser.add_argument("--keep-trigger", action="store_true", help="leave TriggerMode as it is")
    add_monitor(parser)


class FrameSource:
    """An open grabber, and what became of its connection."""

    def __init__(self, grabber: FrameGrabber) -> None:
        self.grabber = grabber
        self._lost = ""
        grabber.connection_changed.connect(self._on_connection_changed)

    def no_frame(self, timeout: float, so_far: int = 0) -> FrameTimeoutError:
        """No frame came in time after so many: why, or what to look at."""
        title, came = self.grabber.info.title, counted(so_far, "frame")
        if SourceUri.parse(self.grabber.info.uri).scheme == "file":
            return FrameTimeoutError(f"{title} ended after {came}")
        if self._lost:
            return FrameTimeoutError(
                f"{title} was lost after {came} and did not come back within {timeout:g} s: {self._lost}"
            )
        if self.grabber.access is Access.MONITOR:
            look = "whether the application that controls it streams"
        else:
            look = "whether it waits for a trigger, and whether a firewall drops its packets"
        counters = self.grabber.statistics()
        return FrameTimeoutError(
            f"{title}: no frame within {timeout:g} s after {came} "
            f"({counters.packets} packets, {counters.incomplete} incomplete frames); see {look}"
        )

    def _on_connection_changed(self, state: ConnectionState, reason: str) -> None:
        self._lost = reason if state is ConnectionState.LOST else ""


@contextmanager
def frame_source(options: argparse.Namespace) -> Iterator[FrameSource]:
    """The source as `add_options` has it, set and not yet started; closed behind the block."""
    assignments = [assignment(text) for text in options.assignments]
    with opened(options.source, monitor=options.monitor) as grabber:
        source = FrameSource(grabber)
        for name, value in assignments:
            grabber.write_feature(name, value)
        yield source
