"""Messages about the connection to a source: lost, back, read-only, or refusing something."""

from __future__ import annotations

import time
from collections.abc import Callable

from grabbergui.core.errors import DeviceLostError, FeatureError, GrabberError, TransportError
from grabbergui.core.grabber import Access
from grabbergui.models.error_text import error_text, lost_text, returned_text
from grabbergui.models.language import localized, translate
from grabbergui.models.messages import ERROR_SECONDS, Cause, Message, MessageModel, Offer, Severity
from grabbergui.models.open_source import LinkState, OpenSource

BACK_SECONDS = 10.0
"Seconds for which the message stays that a source is back, or that it did not answer once."


class LinkMessages:
    """Words what happens to open sources, and posts it. Any thread."""

    def __init__(self, messages: MessageModel) -> None:
        self.model = messages

    def lost(self, source: OpenSource, reason: str) -> str:
        """Post that a source does not answer any more; return the text."""
        text = translate("Connection", "reconnecting since {0}: {1}")
        text = text.format(time.strftime("%H:%M:%S"), lost_text(source.title, reason))
        self.model.end(source, Cause.LINK)  # shown again to users who dismissed the one before
        self.model.post(Message(text, Severity.ERROR, source, Cause.LINK, count=source.losses))
        return text

    def back(self, source: OpenSource, seconds: float, reason: str) -> None:
        """Post that a source answers again after so many seconds, and list the settings that differ."""
        text = translate("Connection", "back after {0} s").format(localized(f"{seconds:.{seconds < 1:d}f}"))
        unlike = source.grabber.unlike_before if source.grabber is not None else ()
        if reason:
            text = f"{text}, {returned_text(unlike)}"
        severity = Severity.WARNING if unlike else Severity.NOTICE
        message = Message(text, severity, source, Cause.LINK, count=source.losses)
        self.model.end(source, Cause.LINK)
        # A difference stays until the user has judged and dismissed it.
        self.model.post(message, seconds=None if unlike else BACK_SECONDS)

    def ready(self, source: OpenSource, take_control: Callable[[], None]) -> None:
        """Post the restriction with which a source became current: it may be open for reading only."""
        if not source.read_only:
            return
        reason, _, _ = source.read_only.partition(";")  # the remedy is on the button
        text = translate("Connection", "read only: {0}; values follow here but cannot be changed")
        if source.access is Access.TAKE_OVER:
            text = translate("Connection", "control was not given: {0}; still read only")
        offer = Offer(translate("Connection", "Take control"), take_control)
        self.model.post(Message(text.format(reason), source=source, cause=Cause.ACCESS, offers=(offer,)))

    def took_control(self, source: OpenSource) -> None:
        """Post that this window controls a source that it could only read."""
        text = translate("Connection", "this window has control now: values can be changed")
        self.model.notice(text, source)

    def feature_failed(self, source: OpenSource, error: GrabberError) -> None:
        """Post that a write, command or read failed. While a source is lost, only the loss is posted."""
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

    def not_opened(self, text: str) -> None:
        """Post that no source could be opened; the next attempt ends it."""
        self.model.post(Message(text, Severity.ERROR, cause=Cause.OPENING), seconds=ERROR_SECONDS)
