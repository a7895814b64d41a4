"""The history of a stream's last frames."""

from __future__ import annotations

import threading
from collections import deque

from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import FrameSink
from grabbergui.core.grabber import FrameGrabber

HISTORY_FRAMES = 100
HISTORY_BYTES = 256 * 1024 * 1024
"Most bytes of all frames together: 51 frames of five megapixels, or 100 of two and a half."
FRAME_WAIT = 0.2
"Seconds that the history's thread waits for a frame before it checks whether it should end."


class FrameHistory:
    """Keeps copies of the last frames; the buffers themselves must return to the stream. Any thread."""

    def __init__(self, most_frames: int = HISTORY_FRAMES, most_bytes: int = HISTORY_BYTES) -> None:
        self._most_frames, self._most_bytes = most_frames, most_bytes
        self._frames: deque[Frame] = deque()
        self._bytes = 0
        self._paused = False
        self._sink: FrameSink | None = None
        self._lock = threading.Lock()

    @property
    def frames(self) -> tuple[Frame, ...]:
        """The stored frames, the oldest first."""
        with self._lock:
            return tuple(self._frames)

    @property
    def paused(self) -> bool:
        """Whether the history is frozen."""
        return self._paused

    def pause(self, paused: bool) -> None:
        """Freeze the history, or continue it with the frames that arrive from now on."""
        with self._lock:
            self._paused = paused

    def attach(self, grabber: FrameGrabber) -> None:
        """Keep this source's frames, and forget those of the previous one."""
        self.detach()
        frames: deque[Frame] = deque()
        with self._lock:
            self._frames, self._bytes, self._paused = frames, 0, False

        def consume(frame: Frame) -> None:
            self._add(frame, frames)

        self._sink = FrameSink(grabber, consume, name="history", depth=4, wait=FRAME_WAIT)
        self._sink.start()

    def detach(self, timeout: float = 0.0) -> bool:
        """Stop; return whether the thread ended within `timeout` seconds. May be called again."""
        return self._sink is None or self._sink.stop(timeout)

    def add(self, frame: Frame) -> None:
        """Keep a copy of a frame, unless paused, and drop the oldest frames beyond the limits."""
        self._add(frame, self._frames)

    def _add(self, frame: Frame, frames: deque[Frame]) -> None:
        size = frame.nbytes
        if self._paused or size > self._most_bytes:
            return
        copy = frame.detached()
        with self._lock:
            if self._paused or frames is not self._frames:  # another source was attached while copying
                return
            while frames and (len(frames) >= self._most_frames or self._bytes + size > self._most_bytes):
                self._bytes -= frames.popleft().nbytes
            frames.append(copy)
            self._bytes += size
