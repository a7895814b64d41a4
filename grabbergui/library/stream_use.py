"""Counts the users of a camera's stream, so that the end of one loop does not stop it for others."""

from __future__ import annotations

import contextlib
import os
import threading
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
