"""Delivers a camera's events in a thread of its own."""

from __future__ import annotations

import logging
import threading
from collections import deque
from collections.abc import Callable

log = logging.getLogger(__name__)

MOST_WAITING = 256
"""Events kept while the node map is busy; then the oldest is dropped."""


class EventDelivery:
    """Passes events to a function in order, on its own thread, which the first event starts."""

    def __init__(self, deliver: Callable[[int, bytes], None], name: str) -> None:
        self.dropped = 0
        "Number of events dropped because the function was too slow."
        self._deliver = deliver
        self._waiting: deque[tuple[int, bytes]] = deque()
        self._changed = threading.Condition()
        self._closed = False
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)

    def put(self, event_id: int, message: bytes) -> None:
        """Queue an event. Any thread; never waits."""
        with self._changed:
            if self._closed:
                return
            if len(self._waiting) == MOST_WAITING:
                self._waiting.popleft()
                if not self.dropped:
                    log.warning("%s: more arrive than can be read; the oldest are dropped", self._thread.name)
                self.dropped += 1
            self._waiting.append((event_id, message))
            if self._thread.ident is None:
                self._thread.start()
            self._changed.notify()

    def close(self) -> None:
        """Discard queued events and end the thread. Nothing is delivered after return."""
        with self._changed:
            self._closed = True
            self._waiting.clear()
            self._changed.notify()
        if self._thread.ident is not None and self._thread is not threading.current_thread():
            self._thread.join()

    def _run(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._waiting or self._closed)
                if self._closed:
                    return
                event_id, message = self._waiting.popleft()
            try:
                self._deliver(event_id, message)
            except Exception:
                log.exception("a listener to events failed")
