"""The last frames of a stream, to stop and look back at."""

from __future__ import annotations

import threading
from collections import deque
from dataclasses import replace

from grabbergui.core.errors import FrameTimeoutError
from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import FrameQueue
from grabbergui.core.grabber import FrameGrabber

MOST_FRAMES = 100
MOST_BYTES = 256 * 1024 * 1024
"Of all frames kept: 51 of five megapixels, a hundred of two and a half."
FRAME_WAIT = 0.2


class FrameHistory:
    """Keeps copies of the last frames while it runs: the stream's own buffers must go back to it.

    All methods may be called from any thread.
    """

    def __init__(self, most_frames: int = MOST_FRAMES, most_bytes: int = MOST_BYTES) -> None:
        self._most_bytes = most_bytes
        self._frames: deque[Frame] = deque(maxlen=most_frames)
        self._bytes = 0
        self._paused = False
        self._queue: FrameQueue | None = None
        self._thread: threading.Thread | None = None
        self._lock = threading.Lock()

    @property
    def frames(self) -> tuple[Frame, ...]:
        """What is kept, the oldest first."""
        with self._lock:
            return tuple(self._frames)

    @property
    def paused(self) -> bool:
        """Whether what is kept stays as it is."""
        return self._paused

    def pause(self, paused: bool) -> None:
        """Keep what there is, or go on with the frames that come from here on."""
        with self._lock:
            self._paused = paused

    def attach(self, grabber: FrameGrabber) -> None:
        """Keep this source's frames, and none from before."""
        self.detach()
        with self._lock:
            self._paused = False
        self._clear()
        queue = grabber.open_queue(depth=4)
        self._queue = queue
        self._thread = threading.Thread(target=self._keep_on, args=(queue,), name="history", daemon=True)
        self._thread.start()

    def detach(self, timeout: float = 0.0) -> bool:
        """Take no more frames. Whether the thread ended within `timeout` seconds; may be asked again."""
        queue, self._queue = self._queue, None
        if queue is not None:
            queue.close()
        if (thread := self._thread) is not None:
            thread.join(timeout)
            return not thread.is_alive()
        return True

    def add(self, frame: Frame) -> None:
        """Keep a copy of a frame, unless paused; the oldest make way."""
        size = frame.payload.nbytes
        if self._paused or size > self._most_bytes:
            return
        copy = replace(frame, payload=frame.payload.copy(), _converted={}, _lock=threading.Lock())
        with self._lock:
            if self._paused:
                return
            while self._frames and (
                len(self._frames) == self._frames.maxlen or self._bytes + size > self._most_bytes
            ):
                self._bytes -= self._frames.popleft().payload.nbytes
            self._frames.append(copy)
            self._bytes += size

    def _keep_on(self, queue: FrameQueue) -> None:
        while not queue.closed:
            try:
                self.add(queue.get(FRAME_WAIT))
            except FrameTimeoutError:
                continue

    def _clear(self) -> None:
        with self._lock:
            self._frames.clear()
            self._bytes = 0
