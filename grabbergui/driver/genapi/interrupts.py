"""Defers Ctrl-C until GenApi has returned.

GenApi is C++ that calls our ports. An unexpected exception there crashes it, or leaves its lock taken.
"""

from __future__ import annotations

import signal
import threading
from types import FrameType


class HeldInterrupts:
    """Defers the KeyboardInterrupt of Python's default handler during a block on the main thread.

    Another handler is left in place: the program that installed it decides when to raise. Blocks may be
    nested. On other threads, where Python handles no signals, nothing happens.
    """

    def __init__(self) -> None:
        self._depth = 0
        self._installed = False
        self._interrupted = False

    def hold(self) -> None:
        """Begin a block, which `release` must end."""
        if threading.current_thread() is not threading.main_thread():
            return
        if not self._depth and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
            signal.signal(signal.SIGINT, self._note)
            self._installed = True
        self._depth += 1

    def release(self) -> None:
        """End a block. The outermost raises KeyboardInterrupt if Ctrl-C was pressed in it."""
        if threading.current_thread() is not threading.main_thread():
            return
        self._depth -= 1
        if self._depth or not self._installed:
            return
        interrupted, self._interrupted, self._installed = self._interrupted, False, False
        if signal.getsignal(signal.SIGINT) == self._note:
            signal.signal(signal.SIGINT, signal.default_int_handler)
        if interrupted:
            raise KeyboardInterrupt

    def _note(self, number: int, frame: FrameType | None) -> None:
        self._interrupted = True
