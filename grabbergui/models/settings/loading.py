"""Settings back onto a camera: in several passes, because one setting may hide, lock or limit another.

What is refused in one pass (an offset that does not fit the old width) is tried again in the next, as long
as a pass gets anything done. Then every value is read back, and what a later write disturbed is written once
more.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import Enum

from grabbergui.core.errors import FeatureError, FeatureNotFoundError, GrabberError
from grabbergui.core.features import Feature, FeatureKind, FeatureValue, format_value
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.sfnc import AUTO_OFF, enabler_of
from grabbergui.models.error_text import error_text
from grabbergui.models.features.stream_pause import stream_paused
from grabbergui.models.language import translate
from grabbergui.models.settings.feature_set import (
    FeatureSet,
    Progress,
    Selectors,
    SettingKey,
    capture,
    same_value,
)

MAX_PASSES = 6
"More than any chain of dependencies among SFNC's features is long."


class Outcome(Enum):
    """What became of one setting."""

    WRITTEN = "written"
    EQUAL = "equal"
    "The camera stood there already; nothing was written."
    WOULD_WRITE = "would write"
    "It differs; only looking was asked for."
    REFUSED = "refused"
    DIFFERENT = "different"
    "It was written, but the camera stands elsewhere: it rounded, or another setting moved it."
    LEFT_ALONE = "left alone"
    "An automatic mode sets it, or its switch is off; writing it would undo that."
    UNKNOWN = "unknown"
    "The camera has no such feature."
    CANCELLED = "cancelled"


_THOUSAND = 1000
"What a whole load counts as, for its progress."

SETTLED = frozenset({Outcome.WRITTEN, Outcome.EQUAL, Outcome.WOULD_WRITE, Outcome.LEFT_ALONE})
"Outcomes that nobody needs to look at."


@dataclass(frozen=True)
class SettingReport:
    """One setting, and what became of it."""

    key: SettingKey
    wanted: FeatureValue
    outcome: Outcome
    before: FeatureValue | None = None
    after: FeatureValue | None = None
    reason: str = ""
    "Why it is not as it was wanted, for people."

    def __str__(self) -> str:
        change = f"{format_value(self.before)} → {format_value(self.wanted)}"
        if self.outcome is Outcome.EQUAL:
            change = format_value(self.wanted)
        reason = f" ({self.reason})" if self.reason else ""
        return f"{self.outcome.value:<11} {self.key}: {change}{reason}"


@dataclass(frozen=True)
class LoadReport:
    """What became of a whole set."""

    settings: tuple[SettingReport, ...]
    before: FeatureSet
    "The camera as it was; loading this rolls back."
    problem: str = ""
    "Why the stream could not be started again, where it was stopped for the settings."

    def count(self, *outcomes: Outcome) -> int:
        """How many settings ended so."""
        return sum(report.outcome in outcomes for report in self.settings)

    @property
    def settled(self) -> bool:
        """Whether the camera is as the set wants it."""
        return not self.problem and all(report.outcome in SETTLED for report in self.settings)

    def lines(self) -> list[str]:
        """All that was not equal, a line each, and the summary."""
        told = [str(report) for report in self.settings if report.outcome is not Outcome.EQUAL]
        return [*told, *([self.problem] if self.problem else []), self.summary()]

    def summary(self) -> str:
        """One line for people: `3 written, 36 equal, 1 refused`."""
        counts = ((self.count(outcome), outcome.value) for outcome in Outcome)
        return ", ".join(f"{count} {name}" for count, name in counts if count) or "nothing to do"


def load_onto(
    grabber: FrameGrabber,
    features: FeatureSet,
    *,
    dry_run: bool = False,
    progress: Progress = lambda done, of: None,
    cancelled: threading.Event | None = None,
) -> LoadReport:
    """Set a camera as the set says, and tell of each setting what happened.

    Nothing that is equal is written; selectors end where they stood. A running stream is stopped while
    anything is written and started again with the triggers as the set has them. With `dry_run` only
    selectors are moved. With `cancelled` set, what was not written by then is reported so; rolling back takes
    the rest back. Raises TransportError when the camera goes away, AccessDeniedError without control.
    """
    cancelled = cancelled or threading.Event()
    before = capture(grabber, progress=_part(progress, 0.0, 0.5), cancelled=cancelled)
    work = _Loading(grabber, Selectors(grabber), features, cancelled)
    with work.selectors.kept(work.choosing):
        work.compare(_part(progress, 0.5, 0.7))
        if dry_run:
            return LoadReport(tuple(work.reports(dry_run=True)), before)
        stays: list[GrabberError] = []
        with stream_paused(grabber, bool(work.pending) and not cancelled.is_set(), stays.append):
            work.write(_part(progress, 0.7, 1.0))
    text = translate("Settings", "the stream does not start again: {0}")
    problem = text.format(stays[0]) if stays else ""
    return LoadReport(tuple(work.reports()), before, problem)


def roll_back(
    grabber: FrameGrabber,
    report: LoadReport,
    *,
    progress: Progress = lambda done, of: None,
    cancelled: threading.Event | None = None,
) -> LoadReport:
    """Set the camera as it was before a set was loaded."""
    return load_onto(grabber, report.before, progress=progress, cancelled=cancelled)


@dataclass
class _Loading:
    grabber: FrameGrabber
    selectors: Selectors
    features: FeatureSet
    cancelled: threading.Event
    pending: list[SettingKey] = field(default_factory=list)
    _reports: dict[SettingKey, SettingReport] = field(default_factory=dict)

    @property
    def choosing(self) -> list[str]:
        """Every selector that will be moved."""
        names = {selector: None for key in self.features.settings for selector, _ in key.selected}
        return [name for name in names if self.grabber.has_feature(name)]

    def compare(self, progress: Progress) -> None:
        """Sort every setting into equal, left alone, or pending."""
        for done, (key, wanted) in enumerate(self.features.settings.items(), 1):
            if self.cancelled.is_set():
                reason = translate("Settings", "cancelled")
                self._reports[key] = SettingReport(key, wanted, Outcome.CANCELLED, reason=reason)
                continue
            try:
                outcome, value, reason = self._compared(key, wanted)
            except FeatureNotFoundError as error:
                outcome, value, reason = Outcome.UNKNOWN, None, error_text(error)
            if outcome is Outcome.WOULD_WRITE:
                self.pending.append(key)
            self._reports[key] = SettingReport(key, wanted, outcome, value, value, reason)
            progress(done, len(self.features))

    def write(self, progress: Progress) -> None:
        """Write what is pending, pass after pass, until a pass changes nothing."""
        total = len(self.pending)
        for _ in range(MAX_PASSES):
            refused = list(self._attempted(progress, total))
            disturbed = self._disturbed()
            stuck = len(refused) == len(self.pending)
            self.pending = refused + [key for key in disturbed if key not in refused]
            if not self.pending or stuck or self.cancelled.is_set():
                return

    def _attempted(self, progress: Progress, total: int) -> Iterator[SettingKey]:
        """Try what is pending; what was refused."""
        refused = 0
        for done, key in enumerate(self.pending, total - len(self.pending) + 1):
            if not self._attempt(key):
                refused += 1
                yield key
            progress(max(0, done - refused), total)

    def reports(self, *, dry_run: bool = False) -> Iterator[SettingReport]:
        """What became of each setting, in the set's order."""
        for report in self._reports.values():
            unfinished = report.outcome is Outcome.WOULD_WRITE and not dry_run
            reason = translate("Settings", "cancelled")
            yield _replaced(report, Outcome.CANCELLED, report.after, reason) if unfinished else report

    def _compared(self, key: SettingKey, wanted: FeatureValue) -> tuple[Outcome, FeatureValue | None, str]:
        self.grabber.feature(key.name)  # a camera without it says so
        if not self.selectors.select(key.selected):
            return Outcome.WOULD_WRITE, None, ""  # the entry may come with another setting
        feature = self.grabber.feature(key.name)
        if feature.value is not None and same_value(feature.value, wanted):
            return Outcome.EQUAL, feature.value, ""
        if reason := self._held(key, feature):
            return Outcome.LEFT_ALONE, feature.value, reason
        return Outcome.WOULD_WRITE, feature.value, ""

    def _held(self, key: SettingKey, feature: Feature) -> str:
        """Why the set itself wants this one not to act by hand; empty where it does."""
        mode = self._of_set(feature.auto, key)
        if mode is not None and str(mode) != AUTO_OFF:
            return translate("Settings", "{0} sets it").format(f"{feature.auto}={mode}")
        enabler = enabler_of(key.name, self.grabber.has_feature)
        enabled = self._of_set(enabler, key)
        if enabled is not None and same_value(enabled, False):
            text = translate("Settings", "{0} is off in the set; writing this would turn it on")
            return text.format(enabler)
        return ""

    def _of_set(self, name: str | None, beside: SettingKey) -> FeatureValue | None:
        """What the set wants of another feature, under the same selectors or under none."""
        if name is None:
            return None
        settings = self.features.settings
        return settings.get(SettingKey(name, beside.selected), settings.get(SettingKey(name)))

    def _attempt(self, key: SettingKey) -> bool:
        """Write one setting. Whether the camera took it, or there was nothing to do any more."""
        report = self._reports[key]
        if self.cancelled.is_set():
            return False
        if not self.selectors.select(key.selected):
            text = translate("Settings", "{0} cannot be selected on this camera")
            self._note(key, Outcome.REFUSED, text.format(_shown(key)))
            return False
        feature = None
        try:
            feature = self.grabber.feature(key.name)
            if feature.value is not None and same_value(feature.value, report.wanted):
                # Something written before has moved it there.
                self._note(key, Outcome.WRITTEN, "", feature.value)
                return True
            if feature.kind is FeatureKind.COMMAND:
                text = translate("Settings", "it is a command; loading settings runs none")
                self._note(key, Outcome.REFUSED, text)
                return False
            after = self.grabber.write_feature(key.name, report.wanted)
        except FeatureError as error:
            self._note(key, Outcome.REFUSED, error_text(error, feature=feature))
            return False
        self._note(key, Outcome.WRITTEN, "", after.value)
        return True

    def _disturbed(self) -> list[SettingKey]:
        """Settings that were right and are not any more: what was written behind them moved them."""
        wrong = []
        for key, report in self._reports.items():
            if report.outcome not in (Outcome.WRITTEN, Outcome.EQUAL, Outcome.DIFFERENT):
                continue
            if not self.selectors.select(key.selected):
                continue
            value = self.grabber.feature(key.name).value
            if value is None or same_value(value, report.wanted):
                if report.outcome is Outcome.DIFFERENT:
                    self._note(key, Outcome.WRITTEN, "", value)
                continue
            again = report.outcome is Outcome.DIFFERENT and report.after == value
            stands = translate("Settings", "the camera stands at {0}").format(format_value(value))
            self._note(key, Outcome.DIFFERENT, stands, value)
            if not again:
                wrong.append(key)
        return wrong

    def _note(
        self, key: SettingKey, outcome: Outcome, reason: str, after: FeatureValue | None = None
    ) -> None:
        self._reports[key] = _replaced(self._reports[key], outcome, after, reason)


def _replaced(
    report: SettingReport, outcome: Outcome, after: FeatureValue | None, reason: str
) -> SettingReport:
    return SettingReport(report.key, report.wanted, outcome, report.before, after, reason)


def _part(progress: Progress, begin: float, end: float) -> Progress:
    """The progress of a part of the work as progress of the whole."""
    span = end - begin
    return lambda done, of: progress(round(_THOUSAND * (begin + span * done / max(of, 1))), _THOUSAND)


def _shown(key: SettingKey) -> str:
    return ", ".join(f"{selector}={entry}" for selector, entry in key.selected)
