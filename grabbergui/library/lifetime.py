"""How long a camera streams, and when it is closed, if the program says neither.

`StreamUse` counts the users of a stream, because the end of one loop must not stop it for others. `Closing`
closes cameras that the program leaves open, with the last reference to them or when the program exits: a GigE
Vision camera that was not released refuses every program for some seconds, and a movie that was not finished
lacks its end.
"""

from __future__ import annotations

import atexit
import contextlib
import os
import threading
import weakref
from collections.abc import Callable, Iterator

from grabbergui.core.errors import GrabberError
from grabbergui.core.grabber import FrameGrabber


class StreamUse:
    """Switches a camera's stream on for loops, recordings and grabs, and off when it may be off again.

    A stream that a loop or a recording switched on is switched off with the last of them. It stays on if it
    was on before, if the program has switched it on since (`keep`), or while a `grab` waits. Any thread
    may call.
    """

    def __init__(self, grabber: FrameGrabber) -> None:
        self._grabber = grabber
        self._process = os.getpid()
        # Loops of a generator may also end where the collector runs, on a thread that holds this lock.
        self._lock = threading.RLock()
        self._loops = 0
        self._grabs = 0
        self._temporary = False
        "Whether the stream is on for loops and recordings only."

    def keep(self) -> None:
        """Leave the stream on after the loops and recordings in progress."""
        self._temporary = False

    @contextlib.contextmanager
    def loop(self, start: Callable[[], None]) -> Iterator[None]:
        """Switch the stream on by `start`, and off at the end if nobody else uses it. Raises as `start`."""
        with self._lock:
            self._loops += 1
        try:
            with self._lock:
                self._temporary |= not self._grabber.streaming
                start()
            yield
        finally:
            if os.getpid() == self._process:  # in a forked process the stream is its parent's
                self._end_of_loop()

    def _end_of_loop(self) -> None:
        with self._lock:
            self._loops -= 1
            if not self._loops:
                self._switch_off()

    def _switch_off(self) -> None:
        temporary, self._temporary = self._temporary, False
        if temporary and not self._grabs:
            with contextlib.suppress(GrabberError):  # it may be lost, or closed inside the loop
                self._grabber.stop()

    @contextlib.contextmanager
    def grab(self) -> Iterator[None]:
        """Keep the stream, which the caller starts, on during the block."""
        with self._lock:
            self._grabs += 1
        try:
            yield
        finally:
            with self._lock:
                self._grabs -= 1


# -- closing -------------------------------------------------------------------------------------
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
