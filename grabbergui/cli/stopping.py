"""How a program is ended: Ctrl-C or SIGTERM, at once, by closing what is open, or by setting an event."""

from __future__ import annotations

import _thread
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

SAME = 1.0
"""Seconds within which a second signal is the same wish: a terminal and a launcher both send one."""
PUT_OFF = 0.02
"""Seconds until a signal that came at a bad moment is tried again."""
_MUST_NOT_BE_LEFT = "grabbergui.driver.genapi"


class Terminated(KeyboardInterrupt):
    """SIGTERM, told as Ctrl-C is: what is open gets closed on the way out."""


@contextmanager
def dies_of_interrupt() -> Iterator[None]:
    """Ctrl-C ends the program at once and says nothing, for a phase that leaves nothing behind."""
    before = signal.getsignal(signal.SIGINT)
    ours = before is not signal.SIG_IGN and _in_main_thread()
    if ours:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    try:
        yield
    finally:
        if ours:
            signal.signal(signal.SIGINT, before)


@contextmanager
def raising_on_signals() -> Iterator[None]:
    """Ctrl-C raises KeyboardInterrupt and SIGTERM raises Terminated, but never through GenApi.

    GenApi is C++ that calls our ports: an exception that it does not expect crashes it, or leaves its lock
    taken. So a signal that comes meanwhile is put off until its call is over.
    """
    if not _in_main_thread():
        yield
        return
    # Whoever started us with a signal ignored means it.
    ours = {
        number: handler
        for number in (signal.SIGINT, signal.SIGTERM)
        if (handler := signal.getsignal(number)) in (signal.default_int_handler, signal.SIG_DFL)
    }

    def on_signal(number: int, frame: FrameType | None) -> None:
        if not _within(frame, _MUST_NOT_BE_LEFT):
            raise Terminated if number == signal.SIGTERM else KeyboardInterrupt
        if sys.platform == "win32":
            again = threading.Timer(PUT_OFF, _thread.interrupt_main, (number,))
        else:  # also ends a system call in which the main thread waits
            again = threading.Timer(PUT_OFF, signal.pthread_kill, (threading.get_ident(), number))
        again.daemon = True
        again.start()

    for number in ours:
        signal.signal(number, on_signal)
    try:
        yield
    finally:
        for number, handler in ours.items():
            signal.signal(number, handler)


@contextmanager
def stop_on_signals() -> Iterator[threading.Event]:
    """An event that Ctrl-C or SIGTERM sets; whoever insists a second later ends the program at once."""
    stop = threading.Event()
    first = 0.0
    signals = (signal.SIGINT, signal.SIGTERM)
    before = {number: signal.getsignal(number) for number in signals}

    def on_signal(number: int, frame: FrameType | None) -> None:
        nonlocal first
        if not stop.is_set():
            first = time.monotonic()
            stop.set()
        elif time.monotonic() - first > SAME:
            signal.signal(number, before[signal.Signals(number)])
            signal.raise_signal(number)

    for number in signals:
        signal.signal(number, on_signal)
    try:
        yield stop
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _in_main_thread() -> bool:
    """Where alone Python lets signals be arranged."""
    return threading.current_thread() is threading.main_thread()


def _within(frame: FrameType | None, package: str) -> bool:
    """Whether a frame was called, however far back, by code of a package."""
    while frame is not None:
        if str(frame.f_globals.get("__name__", "")).startswith(package):
            return True
        frame = frame.f_back
    return False
