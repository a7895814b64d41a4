"""Spreads work over turns of the event loop."""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Callable, Hashable

from PyQt5.QtCore import QObject, QTimer

TURN = 0.008
"""Seconds of work in one turn; half a frame of a 60 Hz screen."""


class Pacer(QObject):
    """Does jobs in order, a few milliseconds a turn, so that painting and the hand come between.

    A newer job of the same key takes the place of the waiting one.
    """

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._jobs: OrderedDict[Hashable, Callable[[], None]] = OrderedDict()
        self._timer = QTimer(self)
        self._timer.setInterval(0)
        self._timer.timeout.connect(self._on_timer_timeout)

    def add(self, key: Hashable, job: Callable[[], None]) -> None:
        """Do `job` in one of the next turns."""
        self._jobs[key] = job
        if not self._timer.isActive():
            self._timer.start()

    def clear(self) -> None:
        """Forget what waits."""
        self._jobs.clear()
        self._timer.stop()

    @property
    def idle(self) -> bool:
        """Whether nothing waits."""
        return not self._jobs

    def _on_timer_timeout(self) -> None:
        deadline = time.perf_counter() + TURN
        while self._jobs and time.perf_counter() < deadline:
            _, job = self._jobs.popitem(last=False)
            job()
        if not self._jobs:
            self._timer.stop()
