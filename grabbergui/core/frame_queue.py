"""Frames to many consumers, none of which can slow the camera or each other."""

from __future__ import annotations

import threading
import time
from collections import deque

from grabbergui.core.errors import FrameTimeoutError
from grabbergui.core.frame import Frame


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
