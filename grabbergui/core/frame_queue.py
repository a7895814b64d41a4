"""Distributes frames to many consumers, none of which can slow down the camera or each other.

A `FrameFanout` puts each frame into one `FrameQueue` per consumer. A `FrameSink` calls a consumer with the
frames of its queue, on a thread of its own. `StreamStatistics` counts frames and packets; a `RateMeter`
measures rates.
"""

from __future__ import annotations

import logging
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from enum import Enum
from queue import Empty, SimpleQueue
from typing import Any, Protocol

from grabbergui.core.errors import FrameTimeoutError, GrabberError, StreamEndedError, UsageError
from grabbergui.core.frame import Frame
from grabbergui.core.scheduling import RealtimeThread

log = logging.getLogger(__name__)

WAIT = 0.5
"Longest time in seconds that a sink waits for a frame before it checks whether to end."


class _Mark(Enum):
    """An entry of a queue that is no frame."""

    CLOSED = "wakes each consumer in turn"
    END = "follows the last frame of a stream"


class FrameQueue:
    """A bounded queue for one consumer of the stream; when it is full, it drops the oldest frame.

    A consumer that needs every frame (a recorder) opens a deep queue and checks `dropped`. Any thread may
    put, get and close. Ctrl-C may interrupt `get` at any point: it holds no lock that the receiving thread
    needs, as it would with a Condition, whose methods are Python code.
    """

    def __init__(self, depth: int = 2) -> None:
        if depth < 1:
            raise UsageError(f"a frame queue of depth {depth} holds nothing; 1 is the least")
        self.dropped = 0
        "Frames that were dropped because the consumer was too slow."
        self.needs_all = False
        "Whether a source that can wait, such as a recording, waits for this consumer instead."
        self._depth = depth
        self._frames: SimpleQueue[Frame | _Mark] = SimpleQueue()
        self._putting = threading.Lock()
        self._closed = False

    @property
    def closed(self) -> bool:
        """Whether the queue was closed, so that no more frames arrive."""
        return self._closed

    @property
    def full(self) -> bool:
        """Whether another frame would drop the oldest."""
        return self._frames.qsize() >= self._depth

    @property
    def empty(self) -> bool:
        """Whether the consumer has taken all frames."""
        return self._frames.empty()

    def put(self, frame: Frame) -> None:
        """Add a frame; never waits."""
        with self._putting:
            if self._closed:
                return
            if self.full:
                self.dropped += self._discard()
            self._frames.put(frame)

    def end(self) -> None:
        """Report the end of the stream to the consumer, once, behind the frames that wait."""
        with self._putting:
            if not self._closed:
                self._frames.put(_Mark.END)

    def get(self, timeout: float) -> Frame:
        """Remove and return the oldest frame. Raises FrameTimeoutError after `timeout` s or if closed.

        Raises StreamEndedError, a FrameTimeoutError, once the stream has ended; it may start again.
        """
        wait = min(max(timeout, 0.0), threading.TIMEOUT_MAX)  # for more Python raises OverflowError
        if self._closed:
            raise FrameTimeoutError("the stream was closed")
        try:
            frame = self._frames.get(timeout=wait)
        except Empty:
            raise FrameTimeoutError(f"no frame arrived within {timeout:.3g} s") from None
        if frame is _Mark.END:
            raise StreamEndedError("the stream has ended")
        if frame is _Mark.CLOSED:
            self._frames.put(_Mark.CLOSED)  # for the next one who waits
            raise FrameTimeoutError("the stream was closed")
        return frame

    def clear(self) -> None:
        """Discard all frames, as when the stream is restarted."""
        with self._putting:
            self._discard_all()

    def close(self) -> None:
        """Discard all frames and wake all waiting threads. May be called twice."""
        with self._putting:
            self._closed = True
            self._discard_all()
            self._frames.put(_Mark.CLOSED)

    def _discard_all(self) -> None:
        for _ in range(self._frames.qsize()):
            self._discard()

    def _discard(self) -> bool:
        """Discard the oldest entry; return whether it was a frame, which the consumer may just have taken."""
        try:
            return isinstance(self._frames.get_nowait(), Frame)
        except Empty:
            return False


class FrameFanout:
    """Puts each frame into every open queue. Thread-safe."""

    def __init__(self) -> None:
        self._queues: tuple[FrameQueue, ...] = ()
        self._lock = threading.Lock()

    def open_queue(self, depth: int = 2) -> FrameQueue:
        """Return a queue for a new consumer, who closes it in the end."""
        queue = FrameQueue(depth)
        with self._lock:
            self._queues = (*(q for q in self._queues if not q.closed), queue)
        return queue

    @property
    def consumers(self) -> int:
        """Number of open queues."""
        return sum(not queue.closed for queue in self._queues)

    @property
    def awaited(self) -> bool:
        """Whether a consumer that needs all frames has no room, and no other consumer waits for a frame."""
        queues = [queue for queue in self._queues if not queue.closed]
        return any(q.needs_all and q.full for q in queues) and not any(q.empty for q in queues)

    def put(self, frame: Frame) -> None:
        """Put a frame into every queue; never waits."""
        for queue in self._queues:
            queue.put(frame)

    def end(self) -> None:
        """Report the end of the stream to every consumer."""
        for queue in self._queues:
            queue.end()

    def clear(self) -> None:
        """Discard the frames of all queues, as when the stream is restarted."""
        for queue in self._queues:
            queue.clear()

    def close(self) -> None:
        """Close every queue."""
        with self._lock:
            queues, self._queues = self._queues, ()
        for queue in queues:
            queue.close()


class RateMeter:
    """Measures events and bytes per second. Thread-safe for one writer.

    Over a short window, or, if events are rarer, over a few of their periods.
    """

    PERIODS = 3
    "Periods of rare events that are measured; after as many without an event the rate is 0."

    def __init__(self, window: float = 2.0) -> None:
        self._window = window
        self._events: deque[tuple[float, int]] = deque(maxlen=4096)

    def add(self, amount: int = 1, now: float | None = None) -> None:
        """Record an event of `amount` (bytes, for instance) at monotonic time `now`."""
        self._events.append((time.monotonic() if now is None else now, amount))

    def rates(self, now: float | None = None) -> tuple[float, float]:
        """Return events and amount per second; zeros if the window contains fewer than two events."""
        now = time.monotonic() if now is None else now
        # Copying is atomic; an iterator would fail if another thread called `add`.
        events = self._events.copy()
        window = self._window
        if len(events) > 1:
            window = max(window, self.PERIODS * (events[-1][0] - events[-2][0]))
        recent = [event for event in events if event[0] >= now - window]
        if len(recent) < 2:
            return 0.0, 0.0
        # From the first event to the last, so that the rate is right from the second event on; but to now if
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
        """Discard all events."""
        self._events.clear()


@dataclass
class StreamStatistics:
    """Counters since the start of the stream, none of which decreases, and rates over two seconds."""

    frames: int = 0
    "Complete frames delivered."
    incomplete: int = 0
    "Frames with packets missing."
    lost: int = 0
    "Frames of which no packet arrived, counted by gaps between frame ids."
    underruns: int = 0
    "Frames dropped because consumers held every buffer."
    bytes: int = 0
    "Payload bytes of complete frames."
    packets: int = 0
    packets_missing: int = 0
    "Packets that did not arrive, despite all resend requests."
    packets_resent: int = 0
    "Packets that arrived after a resend request."
    packets_duplicate: int = 0
    packets_ignored: int = 0
    "Foreign, malformed or stale datagrams."
    packets_foreign: int = 0
    "Those of them that did not come from the camera's address and stream port."
    packets_clipped: int = 0
    "Last packets of a frame with padding beyond the end of its payload."
    overruns: int = 0
    "Times that this computer fell behind and discarded all queued packets."
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


class FrameSource(Protocol):
    """An object that delivers frames, such as a FrameGrabber."""

    def open_queue(self, depth: int = 2) -> FrameQueue:
        """Return a new queue of the frames that arrive from now on."""
        ...


class FrameSink:
    """Calls a consumer with each frame, on a thread of its own, until `stop`.

    A consumer that is too slow loses the oldest frames. One that raises gets the next frame; the failure is
    reported once, and again after a frame that was consumed or if it changes. When the source is closed, the
    sink ends; with `reopens` it waits until the source delivers again.

    A consumer may return False for a frame that it skips, which is then not counted.
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
        realtime: bool = False,
        between: Callable[[], object] | None = None,
        failed: Callable[[Exception, Frame], object] | None = None,
    ) -> None:
        """Open a queue of `depth` frames; `start` begins to deliver.

        With `realtime` the thread has the priority of a `RealtimeThread`, for frames that others wait for.
        `between` is called on the sink's thread before each wait of at most `wait` seconds, and at the end.
        `failed` gets a failure and its frame, on that thread; by default it is logged.
        """
        self.name = name
        self.consumed = 0
        "Frames that the consumer processed without an error."
        self._source = source
        self._consume = consume
        self._depth = depth
        self._wait = wait
        self._reopens = reopens
        self._realtime = realtime
        self._between = between
        self._failed = failed
        self._problem = ""
        self._dropped = 0
        "Frames dropped by queues that are closed now."
        self._rate = RateMeter()
        self._stopping = threading.Event()
        self._queue = source.open_queue(depth)
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)

    @property
    def dropped(self) -> int:
        """Frames that were dropped because the consumer was too slow."""
        return self._dropped + self._queue.dropped

    @property
    def rate(self) -> float:
        """Frames consumed per second, over the last two seconds."""
        return self._rate.rates()[0]

    def start(self) -> None:
        """Begin to deliver. Once only."""
        self._thread.start()

    def stop(self, timeout: float | None = None) -> bool:
        """Stop delivering. Return whether the thread ended within `timeout` seconds. May be called again.

        Called by the consumer, it does not wait.
        """
        self._stopping.set()
        self._queue.close()
        if self._thread.ident is None or self._thread is threading.current_thread():
            return True
        self._thread.join(timeout)
        return not self._thread.is_alive()

    def _run(self) -> None:
        thread = RealtimeThread() if self._realtime else None
        while not self._stopping.is_set():
            if thread is not None:
                thread.review(time.monotonic())
            self._call_between()
            if self._queue.closed and not self._open_again():
                break
            try:
                frame = self._queue.get(self._wait)
            except FrameTimeoutError:
                continue
            self._deliver(frame)
        self._call_between()

    def _call_between(self) -> None:
        if self._between is not None:
            try:
                self._between()
            except Exception:
                log.exception("%s", self.name)

    def _open_again(self) -> bool:
        """Open a queue again after a pause; return whether there is one."""
        if not self._reopens or self._stopping.wait(self._wait):
            return False
        self._dropped += self._queue.dropped
        self._queue = self._source.open_queue(self._depth)
        if self._stopping.is_set():
            self._queue.close()
        return True

    def _deliver(self, frame: Frame) -> None:
        try:
            skipped = self._consume(frame) is False
        except Exception as error:  # of any type, as for a damaged payload; the next frame may be fine
            self._report(error, frame)
        else:
            if not skipped:
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
            try:
                self._failed(error, frame)
            except Exception:
                log.exception("%s", self.name)
