"""The program's log, as the window shows it."""

from __future__ import annotations

import logging
import threading
from collections import deque
from dataclasses import dataclass

from psygnal import Signal

MOST_LOG_LINES = 2000
"Most entries kept; the oldest are dropped."


@dataclass(frozen=True)
class LogLine:
    """One entry of the log."""

    time: float
    "Seconds since the epoch."
    level: int
    "The level's number in `logging`."
    origin: str
    "The logger's name."
    text: str


class LogBook(logging.Handler):
    """Keeps the last log entries of all threads between `open` and `close`."""

    added = Signal(LogLine)
    """A new entry; emitted on the thread that logged."""

    def __init__(self, most: int = MOST_LOG_LINES) -> None:
        super().__init__(logging.INFO)
        self._lines: deque[LogLine] = deque(maxlen=most)
        self._emitting = threading.local()
        self._logger: logging.Logger | None = None
        self._levels_before: list[tuple[logging.Logger | logging.Handler, int]] = []

    @property
    def lines(self) -> tuple[LogLine, ...]:
        """The stored entries, the oldest first."""
        self.acquire()
        try:
            return tuple(self._lines)
        finally:
            self.release()

    def open(self, logger: logging.Logger | None = None) -> None:
        """Begin to listen to a logger, by default the root, at this handler's level."""
        self._logger = logger = logger or logging.getLogger()
        self._levels_before = [(logger, logger.level), *((h, h.level) for h in logger.handlers)]
        for handler in logger.handlers:
            # Other handlers print no more than before, although the logger now passes more.
            handler.setLevel(max(handler.level, logger.level))
        logger.setLevel(min(logger.level or logging.WARNING, self.level))
        logger.addHandler(self)

    def close(self) -> None:
        """Stop listening. May be called twice."""
        if self._logger is not None:
            self._logger.removeHandler(self)
            self._logger = None
        for changed, level in self._levels_before:
            changed.setLevel(level)
        self._levels_before = []
        super().close()

    def clear(self) -> None:
        """Remove all entries."""
        self.acquire()
        try:
            self._lines.clear()
        finally:
            self.release()

    def emit(self, record: logging.LogRecord) -> None:
        """Keep an entry. If a listener of `added` logs, that entry is kept without a signal."""
        try:
            line = LogLine(record.created, record.levelno, record.name, self.format(record))
        except Exception:
            self.handleError(record)
            return
        self._lines.append(line)
        if not getattr(self._emitting, "on", False):
            self._emitting.on = True
            try:
                self.added.emit(line)
            except Exception:
                # A failing listener must not disturb the code that logs.
                self.handleError(record)
            finally:
                self._emitting.on = False
