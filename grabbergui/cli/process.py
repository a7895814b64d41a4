"""A command as a process: the characters its output can encode, its log, its end by signals, and systemd.

A signal ends the program, raises an exception or sets an event; see `raising_on_signals` and
`stop_on_signals`.
"""

from __future__ import annotations

import _thread
import codecs
import io
import logging
import os
import signal
import socket
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import datetime, timezone
from types import FrameType
from typing import TextIO

from grabbergui.core.json_text import to_json
from grabbergui.core.visible_text import print_note, visible

log = logging.getLogger(__name__)

_SPELLED = str.maketrans({"×": "x", "…": "...", "→": "->", "–": "-", "±": "+-", "µ": "u", "°": " deg"})
_NAME = "grabbergui.spelled"
NOTES_PER_SECOND = 5.0
"Most notes about the progress of something."
LOG_FORMATS = ("text", "json")
SAME = 1.0
"""Seconds within which a second signal counts as the same request: terminal and launcher both send one."""
PUT_OFF = 0.02
"""Seconds until a postponed signal is tried again."""
_MUST_NOT_BE_LEFT = "grabbergui.driver.genapi"


def spell_out(stream: TextIO | None) -> None:
    """Let a stream replace characters that its encoding lacks instead of failing."""
    if isinstance(stream, io.TextIOWrapper):
        stream.reconfigure(errors=_NAME)


def _spelled(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    text = error.object[error.start : error.end].translate(_SPELLED)
    return text.encode("ascii", "replace").decode("ascii"), error.end


codecs.register_error(_NAME, _spelled)


@contextmanager
def passing_note(text: str) -> Iterator[Callable[[str], None]]:
    """Show `text` on stderr during the block if that is a terminal, and erase it afterwards.

    Yields a function that replaces the text.
    """
    watched = sys.stderr is not None and sys.stderr.isatty()

    def show(text: str) -> None:
        if watched:
            print_note(text)

    show(text)
    try:
        yield show
    finally:
        show("")


@contextmanager
def progress_note(
    clock: Callable[[], float] = time.monotonic,
) -> Iterator[Callable[[Callable[[], str]], None]]:
    """Show progress on stderr during the block if that is a terminal, and erase it afterwards.

    Yields a function that calls its argument for the text, some times a second: it may be called for every
    frame. Something that ends within the first moment shows nothing.
    """
    with passing_note("") as show:
        shown = time.monotonic()

        def progress(text: Callable[[], str]) -> None:
            nonlocal shown
            now = time.monotonic()
            if now - shown >= 1 / NOTES_PER_SECOND:
                shown = now
                show(text())

        yield progress


class JsonFormatter(logging.Formatter):
    """Formats `time` (ISO 8601, UTC), `level`, `logger`, `thread`, `message` and any `exception`."""

    def format(self, record: logging.LogRecord) -> str:
        """Return one line, also for a message of several."""
        entry = {
            "time": datetime.fromtimestamp(record.created, timezone.utc).isoformat(timespec="milliseconds"),
            "level": record.levelname.lower(),
            "logger": record.name,
            "thread": record.threadName,
            "message": record.getMessage(),
        }
        if record.exc_info:
            entry["exception"] = self.formatException(record.exc_info)
        return to_json(entry)


class TextFormatter(logging.Formatter):
    """Formats time, level, logger and message; only the first line of a record begins at the margin.

    Messages repeat what peers on the network sent, which could otherwise forge records or control a terminal.
    """

    def __init__(self) -> None:
        super().__init__("%(asctime)s %(levelname)s %(name)s: %(message)s")

    def format(self, record: logging.LogRecord) -> str:
        """Return the text with what is not printable spelled out."""
        return "\n    ".join(map(visible, super().format(record).split("\n")))


def set_up_log(level: str, kind: str) -> None:
    """Log from this level up to stderr, in one of LOG_FORMATS. Does nothing if logging is set up."""
    handler = logging.StreamHandler()
    handler.setFormatter(JsonFormatter() if kind == "json" else TextFormatter())
    logging.basicConfig(level=level.upper(), handlers=[handler])


def _requests_to_end() -> list[signal.Signals]:
    """Return the signals that ask this program to end; under `nohup`, without SIGHUP."""
    requests = [signal.SIGINT, signal.SIGTERM]
    if sys.platform != "win32" and signal.getsignal(signal.SIGHUP) is not signal.SIG_IGN:
        requests.append(signal.SIGHUP)
    return requests


class Terminated(KeyboardInterrupt):
    """SIGTERM or SIGHUP as an exception like that of Ctrl-C, so that everything open is closed."""

    def __init__(self, number: int) -> None:
        super().__init__()
        self.number = number
        "The signal's."


def _interrupt(number: int) -> KeyboardInterrupt:
    return KeyboardInterrupt() if number == signal.SIGINT else Terminated(number)


class EndRequest(threading.Event):
    """Set by a signal that asks the program to end."""

    number = int(signal.SIGINT)
    "The signal's."

    def check(self) -> None:
        """Raise as `raising_on_signals` does, if it is set."""
        if self.is_set():
            raise _interrupt(self.number)


@contextmanager
def dies_of_signals() -> Iterator[None]:
    """Let Ctrl-C, SIGTERM and SIGHUP end the program at once and silently: there is nothing to release."""
    before = {}
    if _in_main_thread():
        for number in _requests_to_end():
            if (handler := signal.getsignal(number)) is not signal.SIG_IGN:
                before[number] = handler
                signal.signal(number, signal.SIG_DFL)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def raising_on_signals() -> Iterator[None]:
    """Raise KeyboardInterrupt on Ctrl-C and Terminated on SIGTERM and SIGHUP, but never within GenApi.

    GenApi is C++ that calls our ports: an exception that it does not expect crashes it, or leaves its lock
    taken. So a signal during such a call is postponed until it returns.
    """
    if not _in_main_thread():
        yield
        return
    # A signal that was ignored when we were started stays ignored.
    ours = {
        number: handler
        for number in _requests_to_end()
        if (handler := signal.getsignal(number)) in (signal.default_int_handler, signal.SIG_DFL)
    }

    def on_signal(number: int, frame: FrameType | None) -> None:
        if not _within(frame, _MUST_NOT_BE_LEFT):
            raise _interrupt(number)
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
def stop_on_signals() -> Iterator[EndRequest]:
    """Yield an event that a request to end sets (Ctrl-C, SIGTERM, SIGHUP).

    Another one, a second later, ends the program.
    """
    stop = EndRequest()
    first = 0.0
    before = {number: signal.getsignal(number) for number in _requests_to_end()}

    def on_signal(number: int, frame: FrameType | None) -> None:
        nonlocal first
        if not stop.is_set():
            first, stop.number = time.monotonic(), number
            stop.set()
        elif time.monotonic() - first > SAME:
            signal.signal(number, before[signal.Signals(number)])
            signal.raise_signal(number)

    for number in before:
        signal.signal(number, on_signal)
    try:
        yield stop
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _in_main_thread() -> bool:
    """Return whether this is the main thread, the only one that can set signal handlers."""
    return threading.current_thread() is threading.main_thread()


def _within(frame: FrameType | None, package: str) -> bool:
    """Return whether a frame was called, directly or not, by code of a package."""
    while frame is not None:
        if str(frame.f_globals.get("__name__", "")).startswith(package):
            return True
        frame = frame.f_back
    return False


def notify(state: str) -> bool:
    """Send `READY=1`, `WATCHDOG=1`, `STOPPING=1` …; return whether a service manager received it."""
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
    """Return seconds between two signs of life: half of the unit's WatchdogSec; 0 without one."""
    if os.environ.get("WATCHDOG_PID", str(os.getpid())) != str(os.getpid()):
        return 0.0
    text = os.environ.get("WATCHDOG_USEC", "")
    return int(text) / 2e6 if text.isdecimal() else 0.0


@contextmanager
def supervised(alive: Callable[[], object]) -> Iterator[None]:
    """Report readiness on entry and the end on exit; in between call `alive` before each sign of life.

    `alive` takes the locks that the server's own threads take. If those are stuck, so is it: the signs of
    life cease, and systemd restarts the service.
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
