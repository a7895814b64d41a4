"""Holds the tests of this tier to its rule: in process, no sockets but pairs, no programs, no sleeping.

A test waits for a thread by joining it, by its event, or by `patience.until`.
"""

from __future__ import annotations

import inspect
import sys
import threading
import time
from collections.abc import Iterator
from typing import Any

import pytest

SLEEP = time.sleep
OUTSIDE = frozenset(
    {
        "socket.bind",
        "socket.connect",
        "socket.sendto",
        "subprocess.Popen",
        "os.fork",
        "os.forkpty",
        "os.posix_spawn",
        "os.system",
    }
)
"""Python's audit events that reach beyond the process."""
WAITING = "patience"
"""The module whose sleeping is waiting for something."""


class Watch:
    """Notes what the threads of one test do that its tier may not."""

    def __init__(self) -> None:
        self.on = False
        self.offences: list[str] = []
        self._others: set[int | None] = set()

    def start(self) -> None:
        """Watch the main thread and every thread that begins from now on."""
        self.offences = []
        main = threading.main_thread()
        self._others = {thread.ident for thread in threading.enumerate() if thread is not main}
        self.on = True
        time.sleep = self.sleep

    def stop(self) -> None:
        """Watch no longer. Raises AssertionError for what was noted."""
        self.on = False
        time.sleep = SLEEP
        assert not self.offences, f"in a unit test: {', '.join(self.offences)}; tests/system may do so"

    def audit(self, event: str, arguments: tuple[Any, ...]) -> None:
        """Refuse what reaches beyond the process, where it happens."""
        # A thread that a test of the other tier left behind may do so.
        if self.on and event in OUTSIDE and threading.get_ident() not in self._others:
            self._refuse(event)

    def sleep(self, seconds: float) -> None:
        """Sleep in place of `time.sleep`, where that may be. No time at all only lets others work."""
        frame = inspect.currentframe()
        caller = frame.f_back.f_globals.get("__name__") if frame and frame.f_back else ""
        if seconds and threading.current_thread() is threading.main_thread() and caller != WAITING:
            self._refuse("time.sleep")
        SLEEP(seconds)

    def _refuse(self, what: str) -> None:
        self.offences.append(what)
        raise AssertionError(f"{what} in a unit test")


watch = Watch()
sys.addaudithook(watch.audit)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_setup() -> Iterator[None]:
    watch.start()
    yield


@pytest.hookimpl(wrapper=True)
def pytest_runtest_teardown() -> Iterator[None]:
    yield
    watch.stop()
