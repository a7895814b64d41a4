"""Calls a function at a steady rate, for triggers that software sends."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable

from grabbergui.core.errors import GrabberError

log = logging.getLogger(__name__)


class Repeater:
    """Calls a function on a thread of its own until `stop`; an error ends only the call that raised it."""

    def __init__(self, call: Callable[[], object], name: str) -> None:
        self._call = call
        self._name = name
        self._stopping = threading.Event()
        self._thread: threading.Thread | None = None

    @property
    def running(self) -> bool:
        """Whether it calls."""
        return self._thread is not None

    def start(self, period: float) -> None:
        """Call every `period` seconds, the first time at once; does nothing if it runs."""
        if self._thread is None:
            self._stopping.clear()
            self._thread = threading.Thread(target=self._run, args=(period,), name=self._name, daemon=True)
            self._thread.start()

    def stop(self) -> None:
        """Call no more, and wait for a call in progress. May be called twice."""
        self._stopping.set()
        thread, self._thread = self._thread, None
        if thread is not None and thread is not threading.current_thread():
            thread.join()

    def _run(self, period: float) -> None:
        due = time.monotonic()
        while not self._stopping.is_set():
            try:
                self._call()
            except GrabberError as error:
                log.info("%s: %s", self._name, error)
            # A trigger that is late is not made up for: two in a row would be too fast.
            due = max(due + period, time.monotonic())
            self._stopping.wait(due - time.monotonic())
