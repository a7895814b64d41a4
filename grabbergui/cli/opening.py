"""What commands that open a source share."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager

from grabbergui import sources
from grabbergui.core.errors import AccessDeniedError, GrabberError
from grabbergui.core.grabber import Access, FrameGrabber


def add_source(parser: argparse.ArgumentParser) -> None:
    """The SOURCE argument."""
    parser.add_argument("source", metavar="SOURCE", help="sim:, gige:, gige:192.168.0.10, gige:SERIAL …")


def add_monitor(parser: argparse.ArgumentParser) -> None:
    """`--monitor`, for `opened`."""
    parser.add_argument(
        "--monitor",
        action="store_true",
        help="only look on, beside the application that controls it; a GigE camera must multicast for that",
    )


@contextmanager
def opened(uri: str, *, reading: bool = False, monitor: bool | None = None) -> Iterator[FrameGrabber]:
    """The source, opened, and closed behind the block.

    With `reading`, control is done without where another application has it. `monitor` is whether
    `--monitor` was given; None where the command does not offer it.
    """
    grabber = sources.create(uri)
    if monitor:
        grabber.open(Access.MONITOR)
    else:
        _take_control(grabber, reading=reading, hint="" if monitor is None else ", or look on with --monitor")
    try:
        yield grabber
    finally:
        grabber.close()


def _take_control(grabber: FrameGrabber, *, reading: bool, hint: str) -> None:
    """Open it, or say what else can be done where another application has control."""
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
