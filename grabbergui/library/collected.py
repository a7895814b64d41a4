"""Calls functions after objects were collected: loops that a program left, cameras that it forgot.

They are called on a thread of their own, never inside the object's finaliser. The collector runs on any
thread, perhaps on one that holds a lock that the function needs; and a Ctrl-C that comes while Python code
runs there is lost, since Python discards every exception raised in a finaliser.
"""

from __future__ import annotations

import logging
import queue
import threading
import weakref
from collections.abc import Callable

log = logging.getLogger(__name__)
_WATCHES: dict[int, Watch] = {}
"By id, for a weak reference that is gone calls nothing. A watch stays until its `end` has run."
_GONE: queue.SimpleQueue[weakref.ref[object] | threading.Event] = queue.SimpleQueue()
_STARTING = threading.Lock()
_thread: threading.Thread | None = None


class Watch(weakref.ref[object]):
    """Refers to an object whose `end` is called after it was collected, unless `cancel` came first."""

    __slots__ = ("_end",)
    _end: Callable[[], object] | None

    def cancel(self) -> None:
        """Call nothing when the object is collected. May be called twice."""
        self._end = None
        _WATCHES.pop(id(self), None)

    def _call(self) -> None:
        end, self._end = self._end, None
        try:
            if end is not None:
                end()
        except Exception:
            log.exception("closing what the program had left open")
        finally:
            _WATCHES.pop(id(self), None)


def when_collected(owner: object, end: Callable[[], object]) -> Watch:
    """Call `end`, which must not refer to `owner`, soon after `owner` was collected."""
    _start()
    watch = Watch(owner, _GONE.put)
    watch._end = end
    _WATCHES[id(watch)] = watch
    return watch


def await_ends() -> None:
    """Wait until the functions of all objects collected so far have returned."""
    if threading.current_thread() is _thread or all(
        watch() is not None for watch in tuple(_WATCHES.values())
    ):
        return
    done = threading.Event()
    _GONE.put(done)
    done.wait()


def _start() -> None:
    global _thread
    with _STARTING:
        if _thread is None or not _thread.is_alive():  # as after a fork
            _thread = threading.Thread(target=_run, name="collected cameras", daemon=True)
            _thread.start()


def _run() -> None:
    while True:
        gone = _GONE.get()
        if isinstance(gone, Watch):
            gone._call()
        elif isinstance(gone, threading.Event):
            gone.set()
