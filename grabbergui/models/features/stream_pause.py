"""The stream stops for a moment, for what cannot be changed while it runs."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from grabbergui.core.errors import GrabberError
from grabbergui.core.grabber import FrameGrabber


@contextmanager
def stream_paused(
    grabber: FrameGrabber, needed: bool = True, stays: Callable[[GrabberError], None] | None = None
) -> Iterator[None]:
    """Stop a running stream for the block, and start it again with triggers as they are then.

    Does nothing where it does not run, or is not `needed`. Raises what stopping and starting raises; with
    `stays`, that is called instead when the stream does not start again.
    """
    if not needed or not grabber.streaming:
        yield
        return
    grabber.stop()
    try:
        yield
    finally:
        try:
            grabber.start(keep_trigger=True)
        except GrabberError as error:
            if stays is None:
                raise
            stays(error)
