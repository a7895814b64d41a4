"""Messages of the window, each about a source, with its cause and its end."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from enum import Enum

from psygnal import Signal

from grabbergui.core.visible_text import shortened
from grabbergui.models.open_source import OpenSource

log = logging.getLogger(__name__)

NOTICE_SECONDS = 6.0
"Seconds for which a notice stays."
ERROR_SECONDS = 30.0
"Seconds for which the failure of an action stays; it remains in the log."
MOST_MESSAGES = 20
"Most messages kept; the oldest are dropped."
MOST_TEXT = 2000
"Characters of a message; peers write errors."


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
    IMAGE = "image"
    "Frames do not arrive or cannot be seen although the camera streams."
    OPENING = "opening"
    "A source could not be opened; ends with the next attempt."


@dataclass(frozen=True)
class Offer:
    """A remedy that a message offers as a button."""

    label: str
    act: Callable[[], None] = field(compare=False)


@dataclass(frozen=True)
class UserMessage:
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

    @property
    def cause_first(self) -> str:
        """The sentence with its cause, which is behind a colon, at the beginning: for lines that are cut.

        With several colons, the last may be of a command in the remedy; such a sentence stays as it is.
        """
        action, _, cause = self.sentence.partition(": ")
        return f"{cause[0].upper()}{cause[1:]}: {action}" if cause and ": " not in cause else self.sentence

    def is_same(self, other: UserMessage) -> bool:
        """Return whether two messages are the same."""
        same_text = self.cause is not None or self.text == other.text
        return (self.source, self.cause) == (other.source, other.cause) and same_text


class MessageModel:
    """The messages of a window. Any thread; `changed` is emitted on the calling thread."""

    changed = Signal()

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self.clock = clock
        self._lock = threading.RLock()
        self._messages: tuple[UserMessage, ...] = ()
        "The newest first."
        self._dismissed: list[tuple[OpenSource | None, Cause]] = []
        "Sources and causes whose messages the user dismissed before the cause ended."

    def shown(self, source: OpenSource | None) -> tuple[UserMessage, ...]:
        """Return the messages to show while `source` is the current one, the newest first."""
        now = self.clock()
        return tuple(
            message
            for message in self._messages
            if message.source in (None, source) and (message.ends is None or message.ends > now)
        )

    def error(self, text: str, source: OpenSource | None = None) -> None:
        """Report that one action failed."""
        self.post(UserMessage(text, Severity.ERROR, source), seconds=ERROR_SECONDS)

    def notice(self, text: str, source: OpenSource | None = None) -> None:
        """Report for a moment that something was done or changed by itself."""
        self.post(UserMessage(text, Severity.NOTICE, source), seconds=NOTICE_SECONDS)

    def post(self, message: UserMessage, seconds: float | None = None, *, logged: bool = False) -> None:
        """Show a message in place of the same one, for `seconds` or until `end`.

        The message is logged unless it has been `logged` before. Without a cause, the same message again only
        counts up. A cause that was dismissed stays silent until it ends.
        """
        with self._lock:
            if message.cause is not None and (message.source, message.cause) in self._dismissed:
                return
            now = self.clock()
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

    def dismiss(self, message: UserMessage) -> None:
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
        now = self.clock()
        self._keep(lambda message: message.ends is None or message.ends > now)

    def _keep(self, wanted: Callable[[UserMessage], bool]) -> None:
        with self._lock:
            kept = tuple(message for message in self._messages if wanted(message))
            if kept == self._messages:
                return
            self._messages = kept
        self.changed.emit()
