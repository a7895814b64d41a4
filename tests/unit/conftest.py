"""Holds the tests of this tier to its rule: in process, no sockets but pairs, no programs, no sleeping.

A test waits for a thread by joining it, by its event, or by `patience.until`.
"""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator
from types import FrameType
from typing import Any

import pytest

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
SLEEP = "time.sleep"
"""An audit event since Python 3.11."""
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

    def stop(self) -> None:
        """Watch no longer. Raises AssertionError for what was noted."""
        self.on = False
        assert not self.offences, f"in a unit test: {', '.join(self.offences)}; tests/system may do so"

    def audit(self, event: str, arguments: tuple[Any, ...]) -> None:
        """Refuse what may not be, where it happens."""
        if not self.on or (event not in OUTSIDE and event != SLEEP):
            return
        thread = threading.get_ident()
        if event == SLEEP:
            caller: FrameType = sys._getframe(1)
            if thread != threading.main_thread().ident or caller.f_globals.get("__name__") == WAITING:
                return
        elif thread in self._others:  # a test of the other tier left it behind
            return
        self.offences.append(event)
        raise AssertionError(f"{event} in a unit test")


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
