"""The threads of an open camera: one delivers its events, one polls values that change by themselves."""

from __future__ import annotations

import logging
import threading
from collections import deque
from collections.abc import Callable

from grabbergui.core.errors import GrabberError, TransportError

log = logging.getLogger(__name__)

MOST_WAITING = 256
"""Events kept while the node map is busy; then the oldest is dropped."""


class EventDelivery:
    """Gives events to a function, in order, on a thread of its own that the first event starts."""

    def __init__(self, deliver: Callable[[int, bytes], None], name: str) -> None:
        self.dropped = 0
        "The number of events that were dropped because they came too fast."
        self._deliver = deliver
        self._waiting: deque[tuple[int, bytes]] = deque()
        self._changed = threading.Condition()
        self._closed = False
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)

    def put(self, event_id: int, message: bytes) -> None:
        """Hand an event over. Any thread; never waits."""
        with self._changed:
            if self._closed:
                return
            if len(self._waiting) == MOST_WAITING:
                self._waiting.popleft()
                self.dropped += 1
            self._waiting.append((event_id, message))
            if self._thread.ident is None:
                self._thread.start()
            self._changed.notify()

    def close(self) -> None:
        """Forget what waits and end the thread; nothing is delivered any more on return."""
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


POLL_PERIOD = 0.1
"""Seconds between checks of GenApi's polling times and of values under an automatic mode."""


class Poller:
    """Calls a function every POLL_PERIOD on a thread of its own until stopped."""

    def __init__(self, function: Callable[[], None]) -> None:
        self._function = function
        self._stopped = threading.Event()
        self._thread = threading.Thread(target=self._run, name="feature-poll", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """End it; returns once it has ended."""
        self._stopped.set()
        if self._thread is not threading.current_thread():
            self._thread.join()

    def _run(self) -> None:
        while not self._stopped.wait(POLL_PERIOD):
            try:
                self._function()
            except TransportError as error:
                log.debug("polling features: %s", error)
            except GrabberError as error:
                log.info("polling features: %s", error)
