"""What commands that open a source share."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager

from grabbergui import sources
from grabbergui.core.errors import AccessDeniedError, FrameTimeoutError
from grabbergui.core.grabber import Access, FrameGrabber
from grabbergui.core.uri import SourceUri


def add_source(parser: argparse.ArgumentParser) -> None:
    """The SOURCE argument."""
    parser.add_argument("source", metavar="SOURCE", help="sim:, gige:, gige:192.168.0.10, gige:SERIAL …")


@contextmanager
def opened(uri: str, *, reading: bool = False) -> Iterator[FrameGrabber]:
    """The source, opened, and closed behind the block.

    With `reading`, control is done without where another application has it.
    """
    grabber = sources.create(uri)
    try:
        grabber.open(Access.CONTROL)
    except AccessDeniedError:
        if not reading:
            raise
        grabber.open(Access.MONITOR)
    try:
        yield grabber
    finally:
        grabber.close()


def no_frame(grabber: FrameGrabber, timeout: float, so_far: int = 0) -> FrameTimeoutError:
    """No frame came in time after so many: what to look at."""
    if SourceUri.parse(grabber.info.uri).scheme == "file":
        return FrameTimeoutError(f"{grabber.info.title} ended after {so_far} frames")
    counters = grabber.statistics()
    return FrameTimeoutError(
        f"{grabber.info.title}: no frame within {timeout:g} s after {so_far} frames "
        f"({counters.packets} packets, {counters.incomplete} incomplete frames); "
        "see whether it waits for a trigger, and whether a firewall drops its packets"
    )
