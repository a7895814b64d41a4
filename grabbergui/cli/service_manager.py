"""Reports to systemd that `serve` is ready, alive and stopping (sd_notify(3)); without systemd to nobody."""

from __future__ import annotations

import logging
import os
import socket
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

log = logging.getLogger(__name__)


def notify(state: str) -> bool:
    """Send `READY=1`, `WATCHDOG=1`, `STOPPING=1` …; return whether a service manager was there to take it."""
    path = os.environ.get("NOTIFY_SOCKET", "")
    if sys.platform == "win32" or not path:
        return False
    address = "\0" + path[1:] if path.startswith("@") else path
    try:
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as sock:
            sock.connect(address)
            sock.send(state.encode())
    except OSError as error:
        log.debug("systemd was not notified of %s: %s", state, error)
        return False
    return True


def watchdog_period() -> float:
    """Seconds between two signs of life: half of what the unit's WatchdogSec asks for; 0 without one."""
    if os.environ.get("WATCHDOG_PID", str(os.getpid())) != str(os.getpid()):
        return 0.0
    text = os.environ.get("WATCHDOG_USEC", "")
    return int(text) / 2e6 if text.isdecimal() else 0.0


@contextmanager
def supervised(alive: Callable[[], object]) -> Iterator[None]:
    """Report readiness on entry and the end on exit; in between call `alive` before each sign of life.

    `alive` takes the locks that the server's own threads take: if they are stuck, so is it, the signs of life
    cease, and systemd restarts the service.
    """
    closing = threading.Event()
    period = watchdog_period()

    def beat() -> None:
        while not closing.wait(period):
            alive()
            notify("WATCHDOG=1")

    thread = threading.Thread(target=beat, name="watchdog", daemon=True)
    notify("READY=1")
    if period:
        thread.start()
    try:
        yield
    finally:
        notify("STOPPING=1")
        closing.set()
        if period:
            thread.join(5)
