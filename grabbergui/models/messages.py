"""Messages of the window, each about a source, with its cause and its end; the program's log.

`LinkMessages` posts those about the connection to a source: lost, back, read-only, or refusing a request.
"""

from __future__ import annotations

import logging
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from enum import Enum
from pathlib import Path

from psygnal import Signal

from grabbergui.core.errors import DeviceLostError, FeatureError, GrabberError, TransportError
from grabbergui.core.grabber import Access
from grabbergui.core.visible_text import shortened
from grabbergui.models.error_text import error_text, lost_text, returned_text
from grabbergui.models.language import localized, translate
from grabbergui.models.open_source import LinkState, OpenSource

log = logging.getLogger(__name__)

NOTICE_SECONDS = 6.0
"Seconds for which a notice stays."
ERROR_SECONDS = 30.0
"Seconds for which the failure of an action stays; it remains in the log."
MOST_MESSAGES = 20
"Most messages kept; the oldest are dropped."


class Severity(Enum):
    """Severity of a message."""

    ERROR = "error"
    WARNING = "warning"
    NOTICE = "info"


class Cause(Enum):
    """A lasting cause: its message is shown once and removed when the cause ends."""

    LINK = "link"
    "The source does not answer, or has just come back."
    ACCESS = "access"
    "Another program has control."
    TRIGGER = "trigger"
    "Frames come only when the camera is triggered."
    IMAGE = "image"
    "Frames do not arrive or cannot be seen although the camera streams."
    OPENING = "opening"
    "A source could not be opened; ends with the next attempt."


@dataclass(frozen=True)
class Offer:
    """A remedy that a message offers as a button."""

    label: str
    act: Callable[[], None] = field(compare=False)


MOST_TEXT = 2000
"Characters of a message; peers write errors."


@dataclass(frozen=True)
class Message:
    """One message. Equal source and cause make two messages the same; without a cause, equal source and text.

    A message about a source is shown while that source is the current one, others are always shown.
    """

    text: str
    severity: Severity = Severity.NOTICE
    source: OpenSource | None = None
    cause: Cause | None = None
    offers: tuple[Offer, ...] = ()
    count: int = 1
    "Number of occurrences."
    ends: float | None = None
    "Time of its end on the model's clock; None if it ends with its cause or when its source is closed."

    @property
    def sentence(self) -> str:
        """The text with a capital letter, unless it begins with a name, and with the count above 1."""
        text = shortened(self.text, MOST_TEXT)
        first, _, _ = text.partition(" ")
        if first.isalpha() and first.islower():
            text = text[0].upper() + text[1:]
        return text if self.count == 1 else f"{text}  (×{self.count})"

    def is_same(self, other: Message) -> bool:
        """Return whether two messages are the same."""
        same_text = self.cause is not None or self.text == other.text
        return (self.source, self.cause) == (other.source, other.cause) and same_text


class MessageModel:
    """The messages of a window. Any thread; `changed` is emitted on the calling thread."""

    changed = Signal()

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._lock = threading.RLock()
        self._messages: tuple[Message, ...] = ()
        "The newest first."
        self._dismissed: list[tuple[OpenSource | None, Cause]] = []
        "Sources and causes whose messages the user dismissed before the cause ended."

    def shown(self, source: OpenSource | None) -> tuple[Message, ...]:
        """Return the messages to show while `source` is the current one, the newest first."""
        now = self._clock()
        return tuple(
            message
            for message in self._messages
            if message.source in (None, source) and (message.ends is None or message.ends > now)
        )

    def error(self, text: str, source: OpenSource | None = None) -> None:
        """Report that one action failed."""
        self.post(Message(text, Severity.ERROR, source), seconds=ERROR_SECONDS)

    def notice(self, text: str, source: OpenSource | None = None) -> None:
        """Report for a moment that something was done or changed by itself."""
        self.post(Message(text, Severity.NOTICE, source), seconds=NOTICE_SECONDS)

    def post(self, message: Message, seconds: float | None = None, *, logged: bool = False) -> None:
        """Show a message in place of the same one, for `seconds` or until `end`.

        The message is logged unless it has been `logged` before. Without a cause, the same message again only
        counts up. A cause that was dismissed stays silent until it ends.
        """
        with self._lock:
            if message.cause is not None and (message.source, message.cause) in self._dismissed:
                return
            now = self._clock()
            known = [m for m in self._messages if m.ends is None or m.ends > now]
            before = next((m for m in known if m.is_same(message)), None)
            if before is not None and message.cause is None:
                message = replace(message, count=before.count + 1)
            message = replace(message, ends=None if seconds is None else now + seconds)
            if message == before:
                return
            if before is not None and before.severity is message.severity:
                known[known.index(before)] = message
            else:
                if not logged:
                    log.info("%s", message.text)
                known = [message, *(m for m in known if m is not before)]
            self._messages = tuple(known[:MOST_MESSAGES])
        self.changed.emit()

    def end(self, source: OpenSource | None, cause: Cause) -> None:
        """Remove the messages about a cause that has ended."""
        with self._lock:
            self._dismissed = [each for each in self._dismissed if each != (source, cause)]
            self._keep(lambda message: (message.source, message.cause) != (source, cause))

    def forget(self, source: OpenSource) -> None:
        """Remove the messages of a source that was closed."""
        with self._lock:
            self._dismissed = [each for each in self._dismissed if each[0] is not source]
            self._keep(lambda message: message.source is not source)

    def dismiss(self, message: Message) -> None:
        """Remove a message that the user has read. A lasting cause then stays silent until it ends."""
        with self._lock:
            if message.cause is not None and message.ends is None:
                self._dismissed.append((message.source, message.cause))
            self._keep(lambda other: not other.is_same(message))

    def dismiss_all(self) -> None:
        """Dismiss every message."""
        for message in self._messages:
            self.dismiss(message)

    def expire(self) -> None:
        """Remove expired messages. Call it periodically."""
        now = self._clock()
        self._keep(lambda message: message.ends is None or message.ends > now)

    def _keep(self, wanted: Callable[[Message], bool]) -> None:
        with self._lock:
            kept = tuple(message for message in self._messages if wanted(message))
            if kept == self._messages:
                return
            self._messages = kept
        self.changed.emit()


# -- messages about one source -------------------------------------------------------------------
class CurrentMessages:
    """Posts messages about the source that is the current one at that moment. Any thread."""

    def __init__(self, model: MessageModel, current: Callable[[], OpenSource | None]) -> None:
        self._model = model
        self._current = current

    def error(self, text: str) -> None:
        """Report that one action failed."""
        self._model.error(text, self._current())

    def notice(self, text: str) -> None:
        """Report for a moment that something was done."""
        self._model.notice(text, self._current())

    @contextmanager
    def saving(self, path: Path, done: str) -> Iterator[None]:
        """Report that the block wrote a file (`done`, with the path for `{0}`), or why it could not."""
        try:
            yield
        except OSError as error:
            text = translate("Messages", "{0} could not be written: {1}")
            self.error(text.format(path, error.strerror or error))
        except GrabberError as error:
            self.error(error_text(error))
        else:
            self.notice(done.format(path))


BACK_SECONDS = 10.0
"Seconds for which the message stays that a source is back or failed to answer once."


class LinkMessages:
    """Posts messages about the connections of open sources. Any thread.

    Not logged here: sources log their losses and returns themselves, with or without a window.
    """

    def __init__(self, messages: MessageModel) -> None:
        self.model = messages

    def lost(self, source: OpenSource, reason: str) -> str:
        """Post that a source no longer answers; return the text."""
        text = translate("Connection", "reconnecting since {0}: {1}")
        passed = time.monotonic() - source.lost_since if source.lost_since is not None else 0.0
        since = time.strftime("%H:%M:%S", time.localtime(time.time() - passed))
        text = text.format(since, lost_text(source.title, reason))
        self.model.end(source, Cause.LINK)  # show it even if the user dismissed the previous one
        lost = Message(text, Severity.ERROR, source, Cause.LINK, count=source.losses)
        self.model.post(lost, logged=True)
        return text

    def back(self, source: OpenSource, seconds: float, reason: str) -> None:
        """Post that a source answers again after `seconds`, and list the settings that differ."""
        text = translate("Connection", "back after {0} s").format(localized(f"{seconds:.{seconds < 1:d}f}"))
        unlike = source.grabber.unlike_before if source.grabber is not None else ()
        changed = source.grabber.changed_meanwhile if source.grabber is not None else ()
        if reason:
            text = f"{text}, {returned_text(unlike, changed)}"
        differs = bool(unlike or changed)
        severity = Severity.WARNING if differs else Severity.NOTICE
        message = Message(text, severity, source, Cause.LINK, count=source.losses)
        self.model.end(source, Cause.LINK)
        # Differences stay until the user dismisses them.
        self.model.post(message, seconds=None if differs else BACK_SECONDS, logged=True)

    def ready(self, source: OpenSource, take_control: Callable[[], None]) -> None:
        """Post that a source is open for reading only, if so, and offer to take control."""
        if not source.read_only:
            return
        reason, _, _ = source.read_only.partition(";")  # the button offers the remedy
        text = translate("Connection", "read only: {0}; values follow here but cannot be changed")
        if source.access is Access.TAKE_OVER and source.held:
            text = translate("Connection", "control was not given: {0}; still read only")
        offer = Offer(translate("Connection", "Take control"), take_control)
        self.model.post(Message(text.format(reason), source=source, cause=Cause.ACCESS, offers=(offer,)))

    def took_control(self, source: OpenSource) -> None:
        """Post that this window now controls a source that it could only read before."""
        text = translate("Connection", "this window has control now: values can be changed")
        self.model.notice(text, source)

    def feature_failed(self, source: OpenSource, error: GrabberError) -> None:
        """Post that a write, command or read failed, unless the source is lost, which is posted already."""
        if isinstance(error, DeviceLostError):
            return
        feature = None
        if isinstance(error, FeatureError) and source.features is not None:
            feature = source.features.feature(error.feature)
        text = error_text(error, feature=feature)
        if not isinstance(error, TransportError):
            self.model.error(text, source)
        elif source.state is not LinkState.LOST:
            self.model.post(Message(text, Severity.ERROR, source, Cause.LINK), seconds=BACK_SECONDS)

    def not_opened(self, text: str, *, lasting: bool) -> None:
        """Post that a source could not be opened; with `lasting`, until the next attempt."""
        seconds = None if lasting else ERROR_SECONDS
        self.model.post(Message(text, Severity.ERROR, cause=Cause.OPENING), seconds=seconds)


# -- the log -------------------------------------------------------------------------------------
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
