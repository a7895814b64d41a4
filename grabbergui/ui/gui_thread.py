"""The GUI thread: calls from other threads, long work in short turns, and Python's garbage."""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from typing import Any

from psygnal import SignalInstance
from PyQt5 import sip
from PyQt5.QtCore import QObject, Qt, QTimer, pyqtSignal
from PyQt5.QtGui import QGuiApplication

TURN = 0.008
"""Seconds of work in one turn; half a frame of a 60 Hz screen."""


class Bridge(QObject):
    """Runs models' signals as calls on the GUI thread, in the order they were emitted.

    Make it on the GUI thread. `close` (or its deletion) undoes every binding; calls still queued then are
    dropped, so a view that is gone is never called.
    """

    _called = pyqtSignal(object)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._bindings: list[tuple[SignalInstance, Callable[..., None]]] = []
        self._open = True
        # The stubs forget the type of connection.
        self._called.connect(self._run, Qt.ConnectionType.QueuedConnection)  # type: ignore[call-arg]

    def bind(self, signal: SignalInstance, slot: Callable[..., None]) -> None:
        """Call `slot` on the GUI thread, later, whenever `signal` is emitted on whatever thread."""

        def forward(*args: Any) -> None:
            if self._open:
                self._called.emit(lambda: slot(*args))

        signal.connect(forward, check_nargs=False)
        self._bindings.append((signal, forward))

    def call(self, function: Callable[[], None]) -> None:
        """Run a function on the GUI thread, later. Any thread."""
        if self._open:
            self._called.emit(function)

    def close(self) -> None:
        """Undo every binding, and delete the bridge. May be called twice."""
        if not self._open:
            return
        self._open = False
        for signal, forward in self._bindings:
            signal.disconnect(forward, missing_ok=True)
        self._bindings.clear()
        if not sip.isdeleted(self):  # as with its parent
            self.deleteLater()

    def _run(self, function: Callable[[], None]) -> None:
        if self._open:
            function()


@contextmanager
def busy() -> Iterator[None]:
    """Show the waiting cursor while the block keeps the GUI thread."""
    QGuiApplication.setOverrideCursor(Qt.CursorShape.WaitCursor)
    try:
        yield
    finally:
        QGuiApplication.restoreOverrideCursor()


class Pacer(QObject):
    """Runs jobs in order, a few milliseconds per turn, so that the window stays responsive.

    A newer job replaces a waiting one of the same key.
    """

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._jobs: OrderedDict[Hashable, Callable[[], None]] = OrderedDict()
        self._timer = QTimer(self)
        self._timer.setInterval(0)
        self._timer.timeout.connect(self.run_turn)

    def add(self, key: Hashable, job: Callable[[], None]) -> None:
        """Run `job` in one of the next turns."""
        self._jobs[key] = job
        if not self._timer.isActive():
            self._timer.start()

    def clear(self) -> None:
        """Discard all waiting jobs."""
        self._jobs.clear()
        self._timer.stop()

    @property
    def idle(self) -> bool:
        """Whether no job waits."""
        return not self._jobs

    def run_turn(self) -> None:
        """Run waiting jobs for one turn."""
        deadline = time.perf_counter() + TURN
        while self._jobs and time.perf_counter() < deadline:
            _, job = self._jobs.popitem(last=False)
            job()
        if not self._jobs:
            self._timer.stop()
