"""Frames from before an event: the last seconds are kept in memory, and recorded when something happens."""

from __future__ import annotations

import threading
from collections import deque

from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import FrameQueue, FrameSink, FrameSource

MOST_MEMORY = 1 << 30
"Bytes of the frames that are kept, by default."
QUEUE_DEPTH = 1 << 16
"Frames that may wait for the disk: those from before arrive all at once."


class PreTriggerBuffer:
    """Keeps the last frames of a source; a recorder takes them as its source. Any thread.

    Frames are copied, so that the stream's buffers stay free. Until `trigger` a recorder gets nothing; then
    what was kept, and all later frames for some time. A further trigger prolongs that.
    """

    def __init__(
        self, source: FrameSource, before: float, after: float, *, memory: int = MOST_MEMORY
    ) -> None:
        """Keep `before` seconds, or as many as fit into `memory` bytes; pass on `after` seconds."""
        self.triggers = 0
        self._before = before
        self._after = after
        self._memory = memory
        self._kept: deque[tuple[Frame, int]] = deque()
        self._bytes = 0
        self._until = float("-inf")
        "Time of capture until which frames are passed on."
        self.newest = 0.0
        "Time of capture of the newest frame that was taken."
        self._lock = threading.Lock()
        self._queue = FrameQueue(QUEUE_DEPTH)
        self._sink = FrameSink(source, self._take, name="pre-trigger", depth=8)
        self._sink.start()

    @property
    def dropped(self) -> int:
        """Frames that were dropped because this computer was too slow to copy them."""
        return self._sink.dropped + self._queue.dropped

    @property
    def kept(self) -> int:
        """Number of frames in memory."""
        return len(self._kept)

    def open_queue(self, depth: int = 2) -> FrameQueue:
        """Return the one queue of the frames to record."""
        return self._queue

    def trigger(self) -> None:
        """Record what is kept, and what follows."""
        with self._lock:
            self.triggers += 1
            self._until = self.newest + self._after
            while self._kept:
                self._queue.put(self._kept.popleft()[0])
            self._bytes = 0

    def close(self) -> None:
        """Take no more frames; those that are to be recorded stay in the queue."""
        self._sink.stop()

    def _take(self, frame: Frame) -> None:
        copy = frame.detached()
        size = sum(part.data.nbytes for part in copy.parts) or copy.nbytes
        with self._lock:
            self.newest = frame.captured
            if frame.captured <= self._until:
                self._queue.put(copy)
                return
            self._kept.append((copy, size))
            self._bytes += size
            while self._kept and (
                self._bytes > self._memory or self._kept[0][0].captured < frame.captured - self._before
            ):
                self._bytes -= self._kept.popleft()[1]
