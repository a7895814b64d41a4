"""Frames to many consumers, none of which can slow the camera or each other.

A `FrameFanout` puts each frame into one `FrameQueue` per consumer. A `FrameSink` takes the frames of a queue
to its consumer, on a thread of its own. `StreamStatistics` counts what arrives; a `RateMeter` measures rates.
"""

from __future__ import annotations

import logging
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from typing import Any, Protocol

from grabbergui.core.errors import FrameTimeoutError, GrabberError
from grabbergui.core.frame import Frame

log = logging.getLogger(__name__)


class FrameQueue:
    """One consumer's view of the stream: bounded, and when full it loses the oldest frame.

    A consumer that must have every frame (a recorder) asks for a deep queue and watches `dropped`.
    Any thread may put, get and close.
    """

    def __init__(self, depth: int = 2) -> None:
        if depth < 1:
            raise ValueError(f"a frame queue of depth {depth} holds nothing")
        self.dropped = 0
        "Frames this consumer was too slow for."
        self._frames: deque[Frame] = deque(maxlen=depth)
        self._changed = threading.Condition()
        self._closed = False

    @property
    def closed(self) -> bool:
        """Whether no more frames will come."""
        return self._closed

    def put(self, frame: Frame) -> None:
        """Add a frame; never waits."""
        with self._changed:
            if self._closed:
                return
            if len(self._frames) == self._frames.maxlen:
                self.dropped += 1
            self._frames.append(frame)
            self._changed.notify()

    def get(self, timeout: float) -> Frame:
        """The oldest frame held. Raises FrameTimeoutError after `timeout` seconds or once closed."""
        with self._changed:
            if not self._changed.wait_for(lambda: self._frames or self._closed, timeout):
                raise FrameTimeoutError(f"no frame arrived within {timeout:g} s")
            if not self._frames:
                raise FrameTimeoutError("the stream was closed")
            return self._frames.popleft()

    def clear(self) -> None:
        """Forget the frames held, as when the stream is restarted."""
        with self._changed:
            self._frames.clear()

    def close(self) -> None:
        """Wake all who wait; frames still held are released. May be called twice."""
        with self._changed:
            self._closed = True
            self._frames.clear()
            self._changed.notify_all()


class FrameFanout:
    """Hands each frame to every open queue. Thread-safe."""

    def __init__(self) -> None:
        self._queues: tuple[FrameQueue, ...] = ()
        self._lock = threading.Lock()

    def open_queue(self, depth: int = 2) -> FrameQueue:
        """A new consumer; it leaves by closing its queue."""
        queue = FrameQueue(depth)
        with self._lock:
            self._queues = (*(q for q in self._queues if not q.closed), queue)
        return queue

    @property
    def consumers(self) -> int:
        """How many queues are open."""
        return sum(not queue.closed for queue in self._queues)

    def put(self, frame: Frame) -> None:
        """Deliver a frame; never waits."""
        for queue in self._queues:
            queue.put(frame)

    def clear(self) -> None:
        """Forget frames nobody took, as when the stream is restarted."""
        for queue in self._queues:
            queue.clear()

    def close(self) -> None:
        """Close every queue."""
        with self._lock:
            queues, self._queues = self._queues, ()
        for queue in queues:
            queue.close()


class RateMeter:
    """Events and bytes per second over the last moments. Thread-safe for one writer."""

    def __init__(self, window: float = 2.0) -> None:
        self._window = window
        self._events: deque[tuple[float, int]] = deque(maxlen=4096)

    def add(self, amount: int = 1, now: float | None = None) -> None:
        """Note one event of `amount` (bytes, say) at monotonic time `now`."""
        self._events.append((time.monotonic() if now is None else now, amount))

    def rates(self, now: float | None = None) -> tuple[float, float]:
        """Events per second and amount per second; zeros once nothing came for a whole window."""
        now = time.monotonic() if now is None else now
        # A copy is made in one step; an iterator could meet an `add` by another thread.
        recent = [event for event in self._events.copy() if event[0] >= now - self._window]
        if len(recent) < 2:
            return 0.0, 0.0
        # From the first event to the last, so that a rate is right from the second event on; to now where
        # the stream has stalled for longer than its own period.
        span = recent[-1][0] - recent[0][0]
        period = span / (len(recent) - 1)
        if now - recent[-1][0] > 2 * period:
            span += now - recent[-1][0] - period
        if span <= 0:
            return 0.0, 0.0
        count = len(recent) - 1
        return count / span, sum(amount for _, amount in recent[1:]) / span

    def clear(self) -> None:
        """Forget all events."""
        self._events.clear()


@dataclass
class StreamStatistics:
    """Counters since the stream was started; all only grow. Rates are of the last two seconds."""

    frames: int = 0
    "Complete frames delivered."
    incomplete: int = 0
    "Frames with packets missing."
    lost: int = 0
    "Frames of which nothing arrived: gaps between frame ids."
    underruns: int = 0
    "Frames dropped because consumers held every buffer."
    bytes: int = 0
    "Payload bytes of complete frames."
    packets: int = 0
    packets_missing: int = 0
    "Packets that never came, after all requests."
    packets_resent: int = 0
    "Packets that came because they were asked for again."
    packets_duplicate: int = 0
    packets_ignored: int = 0
    "Foreign, malformed or stale datagrams."
    packets_clipped: int = 0
    "Last packets of a frame that carried padding beyond the end of its payload."
    overruns: int = 0
    "Times that packets came faster than this computer takes them, and all that waited were discarded."
    frame_rate: float = 0.0
    "Frames per second."
    bandwidth: float = 0.0
    "Payload bytes per second."

    def as_dict(self) -> dict[str, Any]:
        """All fields, for JSON."""
        return asdict(self)

    def snapshot(self, meter: RateMeter) -> StreamStatistics:
        """Return a copy of the counters with the current rates. Any thread."""
        frame_rate, bandwidth = meter.rates()
        return replace(self, frame_rate=frame_rate, bandwidth=bandwidth)


WAIT = 0.5
"Seconds that a sink waits for a frame before it checks whether it should end."


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

    # -- the sink's thread -----------------------------------------------------------------------
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
