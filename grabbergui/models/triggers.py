"""The triggers of the open sources that have one on: what is waited for, counts, and causes of problems.

Each is watched on its source's thread. Repeated triggers are sent on a thread of their own.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from grabbergui.core.errors import GrabberError
from grabbergui.core.grabber import Access
from grabbergui.core.settings import SettingKey
from grabbergui.models.language import driver_text, translate
from grabbergui.models.messages import MessageModel, Severity, UserMessage
from grabbergui.models.open_source import LinkState, OpenSource
from grabbergui.models.open_sources import OpenSources
from grabbergui.models.status import Condition, StatusModel
from grabbergui.rig.trigger_setup import TriggerSetup

if TYPE_CHECKING:  # imported when the first trigger is switched on
    from grabbergui.rig.live_trigger import LiveTrigger, TriggerReport

REPORT_PERIOD = 1.0
"Seconds between two reports, each of which reads a few settings."


@dataclass(frozen=True)
class TriggerState:
    """A trigger that is on, as the window shows it."""

    source: str = ""
    "`Line1`, `Software`; empty if the camera does not say."
    waiting: bool = False
    sendable: bool = False
    repeating: bool = False
    switchable: bool = False
    "Whether it can be switched off."
    sent: int | None = None
    "None if it is not known, like `missed`."
    accepted: int | None = None
    missed: int | None = None
    problem: str = ""
    "The problem, as display text; empty if all is well."

    @property
    def text(self) -> str:
        """The awaited signal, or the source of the trigger, as display text."""
        if not self.source:
            return (
                translate("Trigger", "Waiting for trigger")
                if self.waiting
                else translate("Trigger", "Trigger on")
            )
        on_line = self.source.startswith("Line")
        if self.waiting and on_line:
            return translate("Trigger", "Waiting for trigger on {0}").format(self.source)
        if self.waiting:
            return translate("Trigger", "Waiting for trigger from {0}").format(self.source)
        return translate("Trigger", "Trigger: {0}").format(self.source)

    @property
    def counts(self) -> str:
        """Triggers sent, accepted and missed as display text; without what is not known."""
        texts = (
            (self.sent, translate("Trigger", "{0} sent")),
            (self.accepted, translate("Trigger", "{0} accepted")),
            (self.missed, translate("Trigger", "{0} missed")),
        )
        return " · ".join(text.format(count) for count, text in texts if count is not None)


class Triggers:
    """Watches the trigger of each open source while it is on. One thread; no call waits."""

    def __init__(
        self,
        open_sources: OpenSources,
        status: StatusModel,
        messages: MessageModel,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._open_sources = open_sources
        self._status = status
        self._messages = messages
        self._clock = clock
        self._watched: dict[OpenSource, _Watched] = {}
        open_sources.ending.connect(self._on_source_ending)

    def refresh(self) -> None:
        """Look at every open source; call it after the status was refreshed."""
        sources = self._open_sources.all
        for source in [source for source in self._watched if source not in sources]:
            self._watched.pop(source).close()
        for source in sources:
            if source.state is LinkState.LOST:
                continue  # its counts are kept until it is back
            triggers = self._status.of(source).facts.triggers if source.state.connected else ()
            watched = self._watched.get(source)
            if watched is not None and watched.triggers != triggers:
                self._watched.pop(source).close()
                watched = None
            if triggers and watched is None:
                watched = self._watched[source] = _Watched(source, triggers)
            if watched is not None:
                watched.refresh(self._clock())

    def of(self, source: OpenSource | None) -> TriggerState | None:
        """Return the state of a source's trigger; None if it is off."""
        watched = None if source is None else self._watched.get(source)
        if source is None or watched is None:
            return None
        waiting = self._status.of(source).condition is Condition.WAITING
        return replace(watched.state, waiting=waiting)

    def send(self, source: OpenSource) -> None:
        """Send one trigger."""
        if (trigger := self._trigger_of(source)) is not None:
            source.worker.submit(trigger.send, failed=lambda error: self._complain(source, error))

    def repeat(self, source: OpenSource, period: float) -> None:
        """Send a trigger every `period` seconds; with 0, no more."""
        if (trigger := self._trigger_of(source)) is not None:
            source.worker.submit(lambda: trigger.repeat(period))

    def switch_off(self, source: OpenSource) -> None:
        """Switch off all triggers of a source, so that it runs freely."""
        watched, features = self._watched.get(source), source.features
        grabber = source.tracked_grabber
        if watched is None or features is None or grabber is None:
            return

        def write() -> None:
            for each in watched.triggers:
                grabber.write_setting(SettingKey("TriggerMode", each.selected), "Off")

        features.run(
            write,
            done=lambda _: features.request(["TriggerMode"]),
            failed=lambda error: self._complain(source, error),
        )

    def _trigger_of(self, source: OpenSource) -> LiveTrigger | None:
        watched = self._watched.get(source)
        return None if watched is None else watched.trigger

    def _complain(self, source: OpenSource, error: GrabberError) -> None:
        text = translate("Trigger", "The trigger failed: {0}").format(driver_text(error))
        self._messages.post(UserMessage(text, Severity.ERROR, source))

    def _on_source_ending(self, source: OpenSource) -> None:
        if (watched := self._watched.pop(source, None)) is not None:
            watched.close()


class _Watched:
    """The trigger of one source."""

    def __init__(self, source: OpenSource, triggers: tuple[TriggerSetup, ...]) -> None:
        self.triggers = triggers
        self.trigger: LiveTrigger | None = None
        "None until it is made, on the source's thread."
        self._source = source
        self._closed = threading.Event()
        self._switchable = False
        self._report: TriggerReport | None = None
        self._requested = float("-inf")
        source.worker.submit(self._make, done=self._on_made)

    @property
    def state(self) -> TriggerState:
        trigger, report = self.trigger, self._report
        state = TriggerState(self.triggers[0].source)
        if trigger is not None:
            state = replace(state, sendable=trigger.sendable, repeating=trigger.repeating)
            state = replace(state, switchable=self._switchable)
        if report is None:
            return state
        counts = report.counts
        return replace(
            state,
            sent=counts.sent,
            accepted=counts.accepted,
            missed=counts.missed,
            problem="\n".join(_problem(name, sentence) for name, sentence in report.findings.items()),
        )

    def refresh(self, now: float) -> None:
        if self.trigger is not None and now - self._requested >= REPORT_PERIOD:
            self._requested = now
            self._source.worker.submit(self.trigger.report, key="trigger", done=self._on_report)

    def close(self) -> None:
        self._closed.set()
        self._source.worker.submit(self._close)

    def _make(self) -> LiveTrigger | None:
        from grabbergui.rig.live_trigger import live_trigger

        grabber = self._source.grabber
        if grabber is None or self._closed.is_set():
            return None
        self._switchable = grabber.has_feature("TriggerMode") and grabber.access is not Access.MONITOR
        return live_trigger(grabber, self.triggers)

    def _on_made(self, trigger: LiveTrigger | None) -> None:
        self.trigger = trigger

    def _on_report(self, report: TriggerReport) -> None:
        self._report = report

    def _close(self) -> None:
        if self.trigger is not None:
            self.trigger.close()


def _problem(camera: str, sentence: str) -> str:
    text = driver_text(sentence)
    return f"{camera}: {text}" if camera else f"{text[:1].upper()}{text[1:]}."
