"""Settings back onto a camera, with a report of what became of each."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from enum import Enum

from grabbergui.core.errors import (
    DeviceLostError,
    FeatureError,
    FeatureNotFoundError,
    GrabberError,
    TransportError,
)
from grabbergui.core.features import AccessMode, Feature, FeatureKind, FeatureValue, format_value
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.settings import SettingKey, Settled, is_number, same_value, settle
from grabbergui.core.sfnc import as_editable, enabler_of, is_on
from grabbergui.models.error_text import error_text
from grabbergui.models.features.sensor_region import stream_paused
from grabbergui.models.language import translate
from grabbergui.models.settings.feature_set import FeatureSet, Progress, capture


class Outcome(Enum):
    """The outcome for one setting."""

    WRITTEN = "written"
    EQUAL = "equal"
    "The camera already had this value; nothing was written."
    WOULD_WRITE = "would write"
    "It differs and the camera would accept it; this was a dry run."
    DEPENDS = "depends"
    "The camera does not accept it as it is set now; it may, once other settings of the set are written."
    REFUSED = "refused"
    DIFFERENT = "different"
    "It was written, but the camera has another value: it rounded, or another setting changed it."
    LEFT_ALONE = "left alone"
    "An automatic mode sets it, or its switch is off; writing it would undo that."
    UNKNOWN = "unknown"
    "The camera has no such feature."
    CANCELLED = "cancelled"
    NOT_WRITTEN = "not written"
    "The camera was lost first; or while it was written, as the reason says then."


PENDING = (Outcome.WOULD_WRITE, Outcome.DEPENDS)
"Outcomes of looking: these are written."

_THOUSAND = 1000
"The steps of a whole load, for its progress."

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
    "Reason for a difference from the request, as display text."

    def __str__(self) -> str:
        change = f"{format_value(self.before)} → {format_value(self.wanted)}"
        if self.outcome is Outcome.EQUAL:
            change = format_value(self.wanted)
        reason = f" ({self.reason})" if self.reason else ""
        return f"{self.outcome.value:<11} {self.key}: {change}{reason}"


@dataclass(frozen=True)
class LoadReport:
    """The outcome for a whole set."""

    settings: tuple[SettingReport, ...]
    before: FeatureSet
    "The camera as it was; loading this rolls back."
    problem: str = ""
    "Reason for an interruption, or for a stream that could not be restarted."
    interrupted: bool = False
    "Whether the camera was lost meanwhile. What was written is set again when it is back, the rest is not."
    lost_lines: tuple[str, ...] = ()
    "Lines of the file that make no sense, a sentence each."

    def count(self, *outcomes: Outcome) -> int:
        """Return the number of settings with one of these outcomes."""
        return sum(report.outcome in outcomes for report in self.settings)

    @property
    def written(self) -> int:
        """The number of settings that were written, also with another result than wanted."""
        return self.count(Outcome.WRITTEN, Outcome.DIFFERENT)

    @property
    def settled(self) -> bool:
        """Whether the camera has all values of the set."""
        whole = not self.problem and not self.lost_lines
        return whole and all(report.outcome in SETTLED for report in self.settings)

    def lines(self) -> list[str]:
        """Return a line for each setting that was not equal, and the summary.

        If the camera was lost before anything was written, one line says it for all.
        """
        omitted = {Outcome.EQUAL}
        if not self.written:
            omitted.add(Outcome.NOT_WRITTEN)
        lines = [str(report) for report in self.settings if report.outcome not in omitted]
        return [*self.lost_lines, *lines, *([self.problem] if self.problem else []), self.summary()]

    def summary(self) -> str:
        """Return one line of display text: `3 written, 36 equal, 1 refused`."""
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
    """Set a camera as the set requires, and report the outcome for each setting.

    Equal values are not written; selectors are restored. A running stream is stopped while anything is
    written and started again with the set's trigger modes. With `dry_run` only selectors are moved. With
    `cancelled` set, the remaining settings are reported as cancelled; rolling back restores the others. If
    the camera is lost meanwhile, the report contains what was written until then, and what was not. Raises
    AccessDeniedError without control, and TransportError from a dry run.
    """
    cancelled = cancelled or threading.Event()
    work = _Loading(grabber, features, cancelled)
    before, problems, interrupted = FeatureSet({}), [], False

    def stays(error: GrabberError) -> None:
        if not isinstance(error, DeviceLostError):  # otherwise it starts when the camera is back
            problems.append(translate("Settings", "the stream does not start again: {0}").format(error))

    try:
        before = capture(grabber, progress=_part(progress, 0.0, 0.5), cancelled=cancelled)
        work.compare(_part(progress, 0.5, 0.7))
        if dry_run:
            return LoadReport(tuple(work.reports(dry_run=True)), before, lost_lines=features.lost_lines)
        with stream_paused(grabber, bool(work.pending) and not cancelled.is_set(), stays):
            work.write(_part(progress, 0.7, 1.0))
    except TransportError as error:
        if dry_run:
            raise
        interrupted = True
        problems.insert(0, translate("Settings", "interrupted: {0}").format(error_text(error)))
        work.give_up(error_text(error))
    return LoadReport(tuple(work.reports()), before, "; ".join(problems), interrupted, features.lost_lines)


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
    features: FeatureSet
    cancelled: threading.Event
    pending: dict[SettingKey, FeatureValue] = field(default_factory=dict)
    _reports: dict[SettingKey, SettingReport] = field(default_factory=dict)

    def compare(self, progress: Progress) -> None:
        """Sort every setting into equal, left alone, refused, or pending."""
        for done, (key, wanted) in enumerate(self.features.settings.items(), 1):
            if self.cancelled.is_set():
                reason = translate("Settings", "cancelled")
                self._reports[key] = SettingReport(key, wanted, Outcome.CANCELLED, reason=reason)
                continue
            try:
                outcome, value, reason = self._compared(key, wanted)
            except FeatureNotFoundError as error:
                outcome, value, reason = Outcome.UNKNOWN, None, error_text(error)
            if outcome in PENDING:
                self.pending[key] = wanted
            self._reports[key] = SettingReport(key, wanted, outcome, value, value, reason)
            progress(done, len(self.features))

    def write(self, progress: Progress) -> None:
        """Write pending settings until the camera has them."""
        done: set[SettingKey] = set()
        left_alone = self._with(Outcome.LEFT_ALONE)

        def note(
            key: SettingKey,
            settled: Settled,
            value: FeatureValue | None,
            error: FeatureError | None,
            feature: Feature | None,
        ) -> None:
            if key in left_alone:
                return
            if settled is Settled.UNANSWERED:
                reason = translate("Settings", "the camera was lost during this write: it has either value")
                self._note(key, Outcome.NOT_WRITTEN, reason)
            elif error is not None:
                self._note(key, Outcome.REFUSED, error_text(error, feature=feature))
            elif settled is Settled.DIFFERENT:
                reported = translate("Settings", "the camera reports {0}").format(format_value(value))
                self._note(key, Outcome.DIFFERENT, reported, value)
            elif self._reports[key].outcome is not Outcome.EQUAL:
                self._note(key, Outcome.WRITTEN, "", value)
                done.add(key)
                progress(len(done), len(self.pending))

        # Equal ones are looked at again: the next write may move them.
        wanted = {key: self._reports[key].wanted for key in self._with(*PENDING, Outcome.EQUAL)}
        wanted |= {key: self._reports[key].wanted for key in left_alone}
        settle(self.grabber, wanted, report=note, reluctantly=left_alone, cancelled=self.cancelled.is_set)

    def give_up(self, reason: str) -> None:
        """Report all settings that are not decided as not written, for this reason."""
        for key, wanted in self.features.settings.items():
            report = self._reports.get(key) or SettingReport(key, wanted, Outcome.DEPENDS)
            if report.outcome in PENDING:
                self._reports[key] = _replaced(report, Outcome.NOT_WRITTEN, report.after, reason)

    def reports(self, *, dry_run: bool = False) -> Iterator[SettingReport]:
        """Give what became of each setting, in the set's order."""
        for report in self._reports.values():
            unfinished = report.outcome in PENDING and not dry_run
            reason = translate("Settings", "cancelled")
            yield _replaced(report, Outcome.CANCELLED, report.after, reason) if unfinished else report

    def _with(self, *outcomes: Outcome) -> list[SettingKey]:
        return [key for key, report in self._reports.items() if report.outcome in outcomes]

    def _compared(self, key: SettingKey, wanted: FeatureValue) -> tuple[Outcome, FeatureValue | None, str]:
        self.grabber.feature(key.name)  # raises if the camera lacks it
        try:
            feature = self.grabber.read_setting(key)
        except FeatureError as error:
            # The entry may come with another setting.
            return Outcome.DEPENDS, None, error_text(error)
        if feature.value is not None and same_value(feature.value, wanted):
            return Outcome.EQUAL, feature.value, ""
        if feature.kind is FeatureKind.COMMAND:
            return Outcome.REFUSED, None, translate("Settings", "it is a command; loading settings runs none")
        if reason := self._held(key, feature):
            return Outcome.LEFT_ALONE, feature.value, reason
        if not (feature.access.readable or feature.access.writable):
            return Outcome.DEPENDS, None, feature.access_problem()
        try:
            # Locks end with the stream, or with earlier writes; ranges may change with them.
            replace(feature, access=AccessMode.READ_WRITE).validated(wanted)
        except FeatureError as error:
            return _doubted(feature, wanted), feature.value, error_text(error, feature=feature)
        if not (feature.access.writable or self._may_be_unlocked(feature)):
            return Outcome.DEPENDS, feature.value, feature.access_problem()
        return Outcome.WOULD_WRITE, feature.value, ""

    def _may_be_unlocked(self, feature: Feature) -> bool:
        """Return whether writing the feature stops what locks it: the stream, or its automatic mode."""
        mode = self.grabber.feature(feature.auto) if feature.auto else None
        stops = self.grabber.streaming and self.grabber.pauses_for(feature.name)
        return stops or as_editable(feature, mode).access.writable

    def _held(self, key: SettingKey, feature: Feature) -> str:
        """Return the mode or switch in the set that makes this value inactive; empty if it is active."""
        mode = self._of_set(feature.auto, key)
        if mode is not None and is_on(mode) and not same_value(mode, False):
            return translate("Settings", "{0} sets it").format(f"{feature.auto}={mode}")
        enabler = enabler_of(key.name, self.grabber.has_feature)
        enabled = self._of_set(enabler, key)
        if enabled is not None and same_value(enabled, False):
            text = translate("Settings", "{0} is off in the set; writing this would turn it on")
            return text.format(enabler)
        return ""

    def _of_set(self, name: str | None, beside: SettingKey) -> FeatureValue | None:
        """Return the set's value of another feature, under the same selectors or under none."""
        if name is None:
            return None
        settings = self.features.settings
        return settings.get(SettingKey(name, beside.selected), settings.get(SettingKey(name)))

    def _note(
        self, key: SettingKey, outcome: Outcome, reason: str, after: FeatureValue | None = None
    ) -> None:
        self._reports[key] = _replaced(self._reports[key], outcome, after, reason)


def _replaced(
    report: SettingReport, outcome: Outcome, after: FeatureValue | None, reason: str
) -> SettingReport:
    return SettingReport(report.key, report.wanted, outcome, report.before, after, reason)


def _doubted(feature: Feature, wanted: FeatureValue) -> Outcome:
    """Return whether a refused value may be accepted later: ranges change, types and entries do not."""
    if feature.kind in (FeatureKind.INTEGER, FeatureKind.FLOAT):
        return Outcome.DEPENDS if is_number(wanted) else Outcome.REFUSED
    known = any(entry.name == str(wanted) for entry in feature.entries)
    return Outcome.DEPENDS if known else Outcome.REFUSED


def _part(progress: Progress, begin: float, end: float) -> Progress:
    """Return the progress of a part of the work as progress of the whole."""
    span = end - begin
    return lambda done, of: progress(round(_THOUSAND * (begin + span * done / max(of, 1))), _THOUSAND)
