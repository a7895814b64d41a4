"""Which features changed since a remote window last asked."""

from __future__ import annotations

import threading
import time
from collections import deque

from grabbergui.core.grabber import FrameGrabber

IDLE = 10.0
"""Seconds without a question after which the grabber is no longer listened to: it may be polling its
camera for our sake only."""

MEMORY = 256
"""Changes remembered; who asks later than that is told that anything may have changed."""


class ChangeLog:
    """Numbers a grabber's changes. Thread-safe; has no thread of its own."""

    def __init__(self, grabber: FrameGrabber) -> None:
        self._grabber = grabber
        # Counting from the time of day, a client notices that the server was started anew.
        self._revision = time.time_ns() // 1_000_000
        self._changes: deque[tuple[int, frozenset[str]]] = deque(maxlen=MEMORY)
        self._asked = 0.0
        self._listening = False
        self._lock = threading.Lock()

    def since(self, revision: int) -> tuple[int, list[str] | None]:
        """The revision now, and the features changed after `revision`; None where that is not known."""
        self._listen()
        with self._lock:
            oldest = self._changes[0][0] if self._changes else self._revision + 1
            if not oldest - 1 <= revision <= self._revision:
                return self._revision, None
            names = {name for number, changed in self._changes if number > revision for name in changed}
            return self._revision, sorted(names)

    def close(self) -> None:
        """Stop listening. May be called twice."""
        with self._lock:
            listening, self._listening = self._listening, False
        if listening:
            self._grabber.features_changed.disconnect(self._note)

    def _listen(self) -> None:
        with self._lock:
            self._asked = time.monotonic()
            if self._listening:
                return
            self._listening = True
            self._revision += 1
            self._changes.clear()
        # Not under our lock: the signal holds its own while it calls `_note`.
        self._grabber.features_changed.connect(self._note)

    def _note(self, names: frozenset[str]) -> None:
        with self._lock:
            wanted = time.monotonic() - self._asked <= IDLE
            if wanted:
                self._revision += 1
                self._changes.append((self._revision, names))
        if not wanted:
            self.close()
