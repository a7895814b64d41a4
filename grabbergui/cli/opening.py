"""What commands that open a source share."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager

from grabbergui import sources
from grabbergui.core.errors import AccessDeniedError
from grabbergui.core.grabber import Access, FrameGrabber


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
