"""Passes what a camera reports (changes, events, loss and return) to callbacks that may use the camera."""

from __future__ import annotations

import logging
import queue
import threading
from collections.abc import Callable
from typing import Any, Literal, get_args

from grabbergui.core.errors import ClosedError, UsageError
from grabbergui.core.grabber import ConnectionState, DeviceEvent, FrameGrabber

log = logging.getLogger(__name__)

Occasion = Literal["change", "event", "lost", "back", "notice"]
Callback = Callable[[Any], object]
"Takes what belongs to its occasion, see `Camera.on`."
MOST_WAITING = 10_000
"Most occasions that wait for slow callbacks; further events and changes are dropped."


class Callbacks:
    """Passes a grabber's signals to callbacks, on a thread that starts with the first callback."""

    def __init__(self, grabber: FrameGrabber) -> None:
        self._grabber = grabber
        self._by_occasion: dict[str, list[Callback]] = {}
        self._waiting: queue.SimpleQueue[tuple[str, Any] | None] = queue.SimpleQueue()
        self._thread: threading.Thread | None = None
        self._closed = False
        self._lost = False
        self._dropped = False

    def add(self, occasion: Occasion, callback: Callback) -> Callable[[], None]:
        """Call `callback` on an occasion; the returned function ends that.

        Raises UsageError, ClosedError after `close`.
        """
        if occasion not in get_args(Occasion):
            raise UsageError(f"on({occasion!r}): there are {', '.join(get_args(Occasion))}")
        if not callable(callback):
            raise UsageError(f"on({occasion!r}, {callback!r}): the second argument is a function to call")
        if self._closed:
            raise ClosedError(f"on({occasion!r}): {self._grabber.info.title} is closed")
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name="camera callbacks", daemon=True)
            self._thread.start()
            self._grabber.features_changed.connect(self._on_features_changed)
            self._grabber.event_received.connect(self._on_event)
            self._grabber.connection_changed.connect(self._on_connection_changed)
            self._grabber.noticed.connect(self._on_noticed)
        callbacks = self._by_occasion.setdefault(occasion, [])
        callbacks.append(callback)
        return lambda: callbacks.remove(callback) if callback in callbacks else None

    def close(self) -> None:
        """End all callbacks; wait for one that runs, unless it is the caller."""
        self._closed = True
        thread, self._thread = self._thread, None
        if thread is None:
            return
        self._grabber.features_changed.disconnect(self._on_features_changed)
        self._grabber.event_received.disconnect(self._on_event)
        self._grabber.connection_changed.disconnect(self._on_connection_changed)
        self._grabber.noticed.disconnect(self._on_noticed)
        self._by_occasion.clear()
        self._waiting.put(None)
        if thread is not threading.current_thread():
            thread.join()

    def _on_features_changed(self, names: frozenset[str]) -> None:
        self._put_if_room("change", names)

    def _on_event(self, event: DeviceEvent) -> None:
        self._put_if_room("event", event)

    def _put_if_room(self, occasion: Occasion, what: object) -> None:
        if self._waiting.qsize() < MOST_WAITING:
            self._waiting.put((occasion, what))
        elif not self._dropped:
            self._dropped = True
            log.warning("%s: the callbacks are too slow, so events are dropped", self._grabber.info.title)

    def _on_noticed(self, text: str) -> None:
        self._waiting.put(("notice", text))

    def _on_connection_changed(self, state: ConnectionState, why: str) -> None:
        if state is ConnectionState.LOST and not self._lost:
            self._lost = True
            self._waiting.put(("lost", why))
        elif state is ConnectionState.OPEN and self._lost:
            self._lost = False
            self._waiting.put(("back", why))

    def _run(self) -> None:
        while (happened := self._waiting.get()) is not None:
            occasion, what = happened
            for callback in tuple(self._by_occasion.get(occasion, ())):
                try:
                    callback(what)
                except Exception:
                    log.exception("a callback for %r failed", occasion)
