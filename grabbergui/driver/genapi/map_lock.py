"""The lock of a node map, which defers Ctrl-C until GenApi has returned."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable
from types import FrameType, TracebackType


class HeldInterrupts:
    """Defers the KeyboardInterrupt of Python's default handler during a block on the main thread.

    GenApi is C++ that calls our ports. An unexpected exception there crashes it, or leaves its lock taken.
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
        self._installed = False
        try:
            # First the handler: what it notes after the flag was read would be lost.
            if signal.getsignal(signal.SIGINT) == self._note:
                signal.signal(signal.SIGINT, signal.default_int_handler)
        finally:
            interrupted, self._interrupted = self._interrupted, False
        if interrupted:
            raise KeyboardInterrupt

    def _note(self, number: int, frame: FrameType | None) -> None:
        self._interrupted = True


class MapLock:
    """A reentrant lock that collects the names of changed features and reports them after its release.

    The report is made outside the lock, on the thread that held it, also after an exception. Ctrl-C raises
    KeyboardInterrupt after the report, never inside GenApi.
    """

    def __init__(self, on_change: Callable[[frozenset[str]], None]) -> None:
        self.on_change = on_change
        self.changed: set[str] = set()
        "Features that changed since the lock was taken. Only for the thread that holds it."
        self._lock = threading.Lock()
        self._owner: int | None = None
        self._depth = 0
        self._interrupts = HeldInterrupts()

    def __enter__(self) -> None:
        thread = threading.get_ident()
        if self._owner != thread:
            self._interrupts.hold()
            self._lock.acquire()
            self._owner = thread
        self._depth += 1

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._depth -= 1
        if self._depth:
            return
        changed = frozenset(self.changed)
        self.changed.clear()
        self._owner = None
        self._lock.release()
        try:
            if changed:
                self.on_change(changed)
        finally:
            self._interrupts.release()
