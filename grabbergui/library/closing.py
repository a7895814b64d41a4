"""Closes cameras that the program leaves open: with the last reference to them, or when the program exits.

A GigE Vision camera that was not released refuses every program for some seconds, and a movie that was not
finished lacks its end.
"""

from __future__ import annotations

import atexit
import contextlib
import os
import threading
import weakref
from collections.abc import Callable

_CLOSING: set[threading.Thread] = set()


class Closing:
    """Calls `close` once: on request, when the owner is collected, or when the program exits."""

    def __init__(self, owner: object, close: Callable[[], None]) -> None:
        """`close` must not refer to `owner`, which would never be collected."""
        self._close = close
        self._process = os.getpid()
        self._collected = weakref.finalize(owner, self._begin)
        self._collected.atexit = False  # at the program's end nothing may be left to a thread
        atexit.register(self.now)

    def now(self) -> None:
        """Close. May be called twice. A forked process has nothing to close: all is its parent's."""
        if os.getpid() == self._process:
            if threading.current_thread() is threading.main_thread():
                self._close_undisturbed()
            else:
                self._close()
        # Last, so that a close that Ctrl-C interrupted before it began still happens at exit.
        self._collected.detach()
        atexit.unregister(self.now)

    def _close_undisturbed(self) -> None:
        """Close on a thread: Ctrl-C ends the wait, but does not leave a camera half closed."""
        thread = threading.Thread(target=self._close, name="close camera")
        try:
            thread.start()
        except RuntimeError:  # the program ends
            self._close()
            return
        _CLOSING.add(thread)
        thread.join()
        _CLOSING.discard(thread)

    def _begin(self) -> None:
        # The collector runs on any thread, perhaps on one that `close` would wait for.
        if os.getpid() == self._process:
            thread = threading.Thread(target=self.now, name="close camera")
            with contextlib.suppress(RuntimeError):  # the program ends, and `now` will be called
                thread.start()
                _CLOSING.add(thread)


def await_collected() -> None:
    """Wait until collected cameras are closed. Do not call it from their callbacks."""
    for thread in tuple(_CLOSING):
        if thread is not threading.current_thread():
            thread.join()
            _CLOSING.discard(thread)
