"""Delivering a stream to one consumer: its thread, its counters, and what happens when it fails."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from typing import Protocol

from grabbergui.core.errors import FrameTimeoutError, GrabberError
from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import FrameQueue, RateMeter

log = logging.getLogger(__name__)

WAIT = 0.5
"Seconds that a sink waits for a frame before it looks whether it shall end."


class FrameSource(Protocol):
    """Anything that frames are taken from, as a FrameGrabber is."""

    def open_queue(self, depth: int = 2) -> FrameQueue:
        """Return a new queue of the frames that arrive from now on."""
        ...


class FrameSink:
    """Calls a consumer with each frame, on a thread of its own, until `stop`.

    A consumer that is too slow loses the oldest frames. One that raises gets the next frame; the failure is
    reported, and again only when it is another one, or happens again after a frame that was consumed. If the
    source is closed the sink ends, unless it `reopens`: then it waits for the source to deliver again.

    A consumer may return False for a frame that it passes over; such a frame does not count.
    """

    def __init__(
        self,
        source: FrameSource,
        consume: Callable[[Frame], object],
        *,
        name: str,
        depth: int = 2,
        wait: float = WAIT,
        reopens: bool = False,
        between: Callable[[], object] | None = None,
        failed: Callable[[Exception, Frame], object] | None = None,
    ) -> None:
        """Open a queue of `depth` frames at once; `start` begins to deliver.

        `between` is called on the sink's thread before each wait of at most `wait` seconds, and at the end.
        `failed` gets a failure and its frame, on that thread; by default it is logged.
        """
        self.name = name
        self.consumed = 0
        "Frames that the consumer took without an error."
        self._source = source
        self._consume = consume
        self._depth = depth
        self._wait = wait
        self._reopens = reopens
        self._between = between
        self._failed = failed
        self._problem = ""
        self._dropped = 0
        "Of queues that were closed."
        self._rate = RateMeter()
        self._stopping = threading.Event()
        self._queue = source.open_queue(depth)
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)

    @property
    def dropped(self) -> int:
        """Frames that the consumer was too slow for."""
        return self._dropped + self._queue.dropped

    @property
    def rate(self) -> float:
        """Frames consumed per second, over the last two seconds."""
        return self._rate.rates()[0]

    def start(self) -> None:
        """Begin to deliver. Once only."""
        self._thread.start()

    def stop(self, timeout: float | None = None) -> bool:
        """Deliver no more. Return whether the thread ended within `timeout` seconds; may be called again.

        The consumer itself may call it, and is not waited for.
        """
        self._stopping.set()
        self._queue.close()
        if self._thread.ident is None or self._thread is threading.current_thread():
            return True
        self._thread.join(timeout)
        return not self._thread.is_alive()

    # -- the sink's thread -------------------------------------------------------------------------
    def _run(self) -> None:
        while not self._stopping.is_set():
            self._pause()
            if self._queue.closed and not self._open_again():
                break
            try:
                frame = self._queue.get(self._wait)
            except FrameTimeoutError:
                continue
            self._deliver(frame)
        self._pause()

    def _pause(self) -> None:
        if self._between is not None:
            try:
                self._between()
            except Exception:
                log.exception("%s", self.name)

    def _open_again(self) -> bool:
        """Return whether there is a queue again; a closed source must not be asked without a rest."""
        if not self._reopens or self._stopping.wait(self._wait):
            return False
        self._dropped += self._queue.dropped
        self._queue = self._source.open_queue(self._depth)
        if self._stopping.is_set():
            self._queue.close()
        return True

    def _deliver(self, frame: Frame) -> None:
        try:
            passed_over = self._consume(frame) is False
        except Exception as error:
            # Whatever it is: a damaged payload may be shorter than it claims, and the next one may do.
            self._report(error, frame)
        else:
            if not passed_over:
                self.consumed += 1
                self._rate.add()
                self._problem = ""

    def _report(self, error: Exception, frame: Frame) -> None:
        problem = f"{type(error).__name__}: {error}"
        if problem == self._problem:
            return
        self._problem = problem
        if not isinstance(error, GrabberError):
            log.error("%s: frame %d (%s)", self.name, frame.frame_id, frame.pixel_format, exc_info=error)
        elif self._failed is None:
            log.warning("%s: %s", self.name, error)
        if self._failed is not None:
            self._failed(error, frame)
