"""What a program does not close is closed with the last reference to it, or at the end of the program.

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
    """Closes what an object stands for, once: on request, with the object, or at the program's end."""

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
        # Behind it, so that what Ctrl-C keeps from beginning is closed later.
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
    """Wait until what is being closed is closed. Not from one of their callbacks."""
    for thread in tuple(_CLOSING):
        if thread is not threading.current_thread():
            thread.join()
            _CLOSING.discard(thread)
