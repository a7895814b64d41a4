"""The messages about one source, which follow its state."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from psygnal import Signal

from grabbergui.core.errors import DeviceLostError, FeatureError, GrabberError, TransportError
from grabbergui.core.grabber import Access
from grabbergui.models.error_text import error_text, lost_text, returned_text
from grabbergui.models.language import localized, translate
from grabbergui.models.messages import ERROR_SECONDS, Cause, MessageModel, Offer, Severity, UserMessage
from grabbergui.models.open_source import LinkState, OpenSource

BACK_SECONDS = 10.0
"Seconds for which the message stays that a source is back or failed to answer once."


class CurrentMessages:
    """Posts messages about the source that is the current one at that moment. Any thread."""

    def __init__(self, model: MessageModel, current: Callable[[], OpenSource | None]) -> None:
        self._model = model
        self._current = current

    def error(self, text: str, source: OpenSource | None = None) -> None:
        """Report that one action failed, with the current source or another `source`."""
        self._model.error(text, source or self._current())

    def notice(self, text: str) -> None:
        """Report for a moment that something was done."""
        self._model.notice(text, self._current())

    @contextmanager
    def saving(self, path: Path, done: str) -> Iterator[None]:
        """Report that the block wrote a file (`done`, with the path for `{0}`), or why it could not."""
        try:
            yield
        except GrabberError as error:  # may be an OSError, too
            self.error(error_text(error))
        except OSError as error:
            text = translate("Messages", "{0} could not be written: {1}")
            self.error(text.format(path, error.strerror or error))
        else:
            self.notice(done.format(path))


class LinkMessages:
    """Posts messages about the connections of open sources. Any thread.

    Not logged here: sources log their losses and returns themselves, with or without a window.
    """

    failed = Signal(str)
    """A source could not be opened or started, or was lost; a sentence as display text."""

    def __init__(self, messages: MessageModel) -> None:
        self.model = messages

    def lost(self, source: OpenSource, reason: str) -> None:
        """Post that a source no longer answers."""
        text = translate("Connection", "reconnecting since {0}: {1}")
        passed = time.monotonic() - source.lost_since if source.lost_since is not None else 0.0
        since = time.strftime("%H:%M:%S", time.localtime(time.time() - passed))
        text = text.format(since, lost_text(source.title, reason))
        self.model.end(source, Cause.LINK)  # show it even if the user dismissed the previous one
        lost = UserMessage(text, Severity.ERROR, source, Cause.LINK, count=source.losses)
        self.model.post(lost, logged=True)
        self.failed.emit(text)

    def back(self, source: OpenSource, seconds: float, reason: str) -> None:
        """Post that a source answers again after `seconds`, and list the settings that differ."""
        text = translate("Connection", "back after {0} s").format(localized(f"{seconds:.{seconds < 1:d}f}"))
        unlike = source.grabber.unlike_before if source.grabber is not None else ()
        changed = source.grabber.changed_meanwhile if source.grabber is not None else ()
        if reason:
            text = f"{text}, {returned_text(unlike, changed)}"
        differs = bool(unlike or changed)
        severity = Severity.WARNING if differs else Severity.NOTICE
        message = UserMessage(text, severity, source, Cause.LINK, count=source.losses)
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
        self.model.post(UserMessage(text.format(reason), source=source, cause=Cause.ACCESS, offers=(offer,)))

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
            self.model.post(UserMessage(text, Severity.ERROR, source, Cause.LINK), seconds=BACK_SECONDS)

    def stream_failed(self, source: OpenSource, text: str) -> None:
        """Post that a stream could not be started or stopped."""
        self.model.error(text, source)
        self.failed.emit(text)

    def not_opened(self, text: str, *, lasting: bool) -> None:
        """Post that a source could not be opened; with `lasting`, until the next attempt."""
        seconds = None if lasting else ERROR_SECONDS
        self.model.post(UserMessage(text, Severity.ERROR, cause=Cause.OPENING), seconds=seconds)
        self.failed.emit(text)
