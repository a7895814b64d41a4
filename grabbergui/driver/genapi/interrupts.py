"""Ctrl-C while GenApi works: it waits until GenApi is left.

GenApi is C++ that calls our ports. An exception that it does not expect crashes it, or leaves its lock taken.
"""

from __future__ import annotations

import signal
import threading
from types import FrameType


class HeldInterrupts:
    """Holds back the KeyboardInterrupt of Python's own handler for a block of the main thread.

    Other handlers are left alone: a program that installs one decides itself when it raises. Blocks may be
    nested; on other threads, on which Python handles no signals, nothing happens.
    """

    def __init__(self) -> None:
        self._depth = 0
        self._ours = False
        self._came = False

    def hold(self) -> None:
        """Begin a block. Each must be ended by `release`."""
        if threading.current_thread() is not threading.main_thread():
            return
        if not self._depth and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
            signal.signal(signal.SIGINT, self._note)
            self._ours = True
        self._depth += 1

    def release(self) -> None:
        """End a block. The outermost raises KeyboardInterrupt if Ctrl-C came meanwhile."""
        if threading.current_thread() is not threading.main_thread():
            return
        self._depth -= 1
        if self._depth or not self._ours:
            return
        came, self._came, self._ours = self._came, False, False
        if signal.getsignal(signal.SIGINT) == self._note:
            signal.signal(signal.SIGINT, signal.default_int_handler)
        if came:
            raise KeyboardInterrupt

    def _note(self, number: int, frame: FrameType | None) -> None:
        self._came = True
