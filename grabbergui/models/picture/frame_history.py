"""The last frames of a stream, to stop and look back at."""

from __future__ import annotations

import threading
from collections import deque

from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import FrameSink
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
        """Keep what there is, or go on with the frames that come from here on."""
        with self._lock:
            self._paused = paused

    def attach(self, grabber: FrameGrabber) -> None:
        """Keep this source's frames, and none from before."""
        self.detach()
        with self._lock:
            self._paused = False
        self._clear()
        self._sink = FrameSink(grabber, self.add, name="history", depth=4, wait=FRAME_WAIT)
        self._sink.start()

    def detach(self, timeout: float = 0.0) -> bool:
        """Stop; return whether the thread ended within `timeout` seconds. May be called again."""
        return self._sink is None or self._sink.stop(timeout)

    def add(self, frame: Frame) -> None:
        """Keep a copy of a frame, unless paused; the oldest make way."""
        size = frame.nbytes
        if self._paused or size > self._most_bytes:
            return
        copy = frame.detached()
        with self._lock:
            if self._paused:
                return
            while self._frames and (
                len(self._frames) == self._frames.maxlen or self._bytes + size > self._most_bytes
            ):
                self._bytes -= self._frames.popleft().nbytes
            self._frames.append(copy)
            self._bytes += size

    def _clear(self) -> None:
        with self._lock:
            self._frames.clear()
            self._bytes = 0
