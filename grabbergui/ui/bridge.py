"""The only door from other threads to the GUI thread."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from psygnal import SignalInstance
from PyQt5.QtCore import QObject, Qt, pyqtSignal


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
        """Undo every binding. May be called twice."""
        self._open = False
        for signal, forward in self._bindings:
            signal.disconnect(forward, missing_ok=True)
        self._bindings.clear()

    def _run(self, function: Callable[[], None]) -> None:
        if self._open:
            function()
