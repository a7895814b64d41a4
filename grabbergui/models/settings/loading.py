"""Loading a set of settings onto a camera, with a report on each of them."""

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
from grabbergui.core.settings import SettingKey, is_number, same_value
from grabbergui.core.settle import Settled, settle
from grabbergui.core.sfnc import as_editable, enabler_of, is_on
from grabbergui.models.error_text import error_text
from grabbergui.models.features.feature_text import access_text
from grabbergui.models.features.sensor_region import stream_paused
from grabbergui.models.language import translate
from grabbergui.models.settings.feature_set import FeatureSet, Progress, capture

_SUGGESTIONS = 20
"Most unknown features for which similar names are searched, which takes milliseconds each."
_PROGRESS_STEPS = 1000
"Progress steps of a whole load."


class SettingOutcome(Enum):
    """The outcome for one setting."""

    WRITTEN = "written"
    EQUAL = "equal"
    "The camera already had this value; nothing was written."
    WOULD_WRITE = "would write"
    "It differs and the camera would accept it; this was a dry run."
    DEPENDS = "depends"
    "The camera does not accept it now, but may once other settings of the set are written."
    REFUSED = "refused"
    DIFFERENT = "different"
    "It was written, but the camera has another value: it rounded, or another setting changed it."
    LEFT_ALONE = "left alone"
    "The set has its automatic mode on or its switch off; writing it would change that."
    UNKNOWN = "unknown"
    "The camera has no such feature."
    CANCELLED = "cancelled"
    NOT_WRITTEN = "not written"
    "The camera was lost before, or while it was written; the reason says which."


PENDING = (SettingOutcome.WOULD_WRITE, SettingOutcome.DEPENDS)
"Outcomes of the comparison whose settings are then written."


SETTLED = frozenset(
    {SettingOutcome.WRITTEN, SettingOutcome.EQUAL, SettingOutcome.WOULD_WRITE, SettingOutcome.LEFT_ALONE}
)
"Outcomes that need no attention."


@dataclass(frozen=True)
class SettingReport:
    """One setting and its outcome."""

    key: SettingKey
    wanted: FeatureValue
    outcome: SettingOutcome
    before: FeatureValue | None = None
    after: FeatureValue | None = None
    reason: str = ""
    "Why the camera does not have the wanted value, as display text."
    unit: str = ""
    "Unit of the values."

    def __str__(self) -> str:
        change = f"{format_value(self.before)} → {format_value(self.wanted)}"
        if self.outcome is SettingOutcome.EQUAL:
            change = format_value(self.wanted)
        reason = f" ({self.reason})" if self.reason else ""
        return f"{self.outcome.value:<11} {self.key}: {change}{reason}"


@dataclass(frozen=True)
class LoadReport:
    """The outcome for a whole set."""

    settings: tuple[SettingReport, ...]
    before: FeatureSet
    "The camera's settings before; loading them rolls back."
    problem: str = ""
    "Reason for an interruption, or for a stream that could not be restarted."
    interrupted: bool = False
    "Whether the camera was lost while loading. On its return only the settings written so far are restored."
    lost_lines: tuple[str, ...] = ()
    "Invalid lines of the file, a sentence each."

    def count(self, *outcomes: SettingOutcome) -> int:
        """Return the number of settings with one of these outcomes."""
        return sum(report.outcome in outcomes for report in self.settings)

    @property
    def written(self) -> int:
        """The number of settings that were written, including those that came out different."""
        return self.count(SettingOutcome.WRITTEN, SettingOutcome.DIFFERENT)

    @property
    def settled(self) -> bool:
        """Whether the camera has all values of the set."""
        whole = not self.problem and not self.lost_lines
        return whole and all(report.outcome in SETTLED for report in self.settings)

    def lines(self) -> list[str]:
        """Return a line for each setting that was not equal, and the summary.

        If the camera was lost before the first write, `problem` replaces the lines of all unwritten settings.
        """
        omitted = {SettingOutcome.EQUAL}
        if not self.written:
            omitted.add(SettingOutcome.NOT_WRITTEN)
        lines = [str(report) for report in self.settings if report.outcome not in omitted]
        return [*self.lost_lines, *lines, *([self.problem] if self.problem else []), self.summary()]

    def summary(self) -> str:
        """Return one line of display text: `3 written, 36 equal, 1 refused`."""
        counts = ((self.count(outcome), outcome.value) for outcome in SettingOutcome)
        return ", ".join(f"{count} {name}" for count, name in counts if count) or "nothing to do"


def load_onto(
    grabber: FrameGrabber,
    features: FeatureSet,
    *,
    dry_run: bool = False,
    progress: Progress = lambda done, of: None,
    cancelled: threading.Event | None = None,
) -> LoadReport:
    """Write a set to a camera, and report the outcome for each setting.

    Equal values are not written; selectors are restored. A running stream is stopped for the writes and
    started again with the set's trigger modes. With `dry_run` only selectors are moved. With `cancelled` set,
    the remaining settings are reported as cancelled; rolling back restores the others. If the camera is lost,
    the report lists the settings that were written before. Raises AccessDeniedError without control, and
    TransportError from a dry run.
    """
    cancelled = cancelled or threading.Event()
    work = _Loading(grabber, features, cancelled)
    before, problems, interrupted = FeatureSet({}), [], False

    def stays(error: GrabberError) -> None:
        if not isinstance(error, DeviceLostError):  # otherwise it starts when the camera is back
            text = translate("Settings", "the stream does not start again: {0}")
            problems.append(text.format(error_text(error)))

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
    """Restore the camera's settings from before a set was loaded."""
    return load_onto(grabber, report.before, progress=progress, cancelled=cancelled)


@dataclass
class _Loading:
    grabber: FrameGrabber
    features: FeatureSet
    cancelled: threading.Event
    pending: dict[SettingKey, FeatureValue] = field(default_factory=dict)
    _reports: dict[SettingKey, SettingReport] = field(default_factory=dict)
    _units: dict[str, str] = field(default_factory=dict)

    def compare(self, progress: Progress) -> None:
        """Sort every setting into equal, left alone, refused, or pending."""
        unknown = 0
        for done, (key, wanted) in enumerate(self.features.settings.items(), 1):
            if self.cancelled.is_set():
                reason = translate("Settings", "cancelled")
                self._reports[key] = SettingReport(key, wanted, SettingOutcome.CANCELLED, reason=reason)
                continue
            try:
                if unknown >= _SUGGESTIONS and not self.grabber.has_feature(key.name):
                    outcome, value, reason = SettingOutcome.UNKNOWN, None, ""
                else:
                    outcome, value, reason = self._compared(key, wanted)
            except FeatureNotFoundError as error:
                outcome, value, reason = SettingOutcome.UNKNOWN, None, error_text(error)
                unknown += 1
            if outcome in PENDING:
                self.pending[key] = wanted
            unit = self._units.get(key.name, "")
            self._reports[key] = SettingReport(key, wanted, outcome, value, value, reason, unit)
            progress(done, len(self.features))

    def write(self, progress: Progress) -> None:
        """Write pending settings until the camera has them."""
        done: set[SettingKey] = set()
        left_alone = self._with(SettingOutcome.LEFT_ALONE)

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
                reason = translate(
                    "Settings", "the camera was lost during this write: it may have either value"
                )
                self._note(key, SettingOutcome.NOT_WRITTEN, reason)
            elif error is not None:
                self._note(key, SettingOutcome.REFUSED, error_text(error, feature=feature))
            elif settled is Settled.DIFFERENT:
                reported = translate("Settings", "the camera reports {0}").format(format_value(value))
                self._note(key, SettingOutcome.DIFFERENT, reported, value)
            elif self._reports[key].outcome is not SettingOutcome.EQUAL:
                self._note(key, SettingOutcome.WRITTEN, "", value)
                done.add(key)
                progress(len(done), len(self.pending))

        # Including equal ones: a write may change them.
        wanted = {key: self._reports[key].wanted for key in self._with(*PENDING, SettingOutcome.EQUAL)}
        wanted |= {key: self._reports[key].wanted for key in left_alone}
        settle(self.grabber, wanted, report=note, reluctantly=left_alone, cancelled=self.cancelled.is_set)

    def give_up(self, reason: str) -> None:
        """Report all pending settings as not written, for this reason."""
        for key, wanted in self.features.settings.items():
            report = self._reports.get(key) or SettingReport(key, wanted, SettingOutcome.DEPENDS)
            if report.outcome in PENDING:
                self._reports[key] = _replaced(report, SettingOutcome.NOT_WRITTEN, report.after, reason)

    def reports(self, *, dry_run: bool = False) -> Iterator[SettingReport]:
        """Yield the report of each setting, in the set's order."""
        for report in self._reports.values():
            unfinished = report.outcome in PENDING and not dry_run
            reason = translate("Settings", "cancelled")
            yield _replaced(report, SettingOutcome.CANCELLED, report.after, reason) if unfinished else report

    def _with(self, *outcomes: SettingOutcome) -> list[SettingKey]:
        return [key for key, report in self._reports.items() if report.outcome in outcomes]

    def _compared(
        self, key: SettingKey, wanted: FeatureValue
    ) -> tuple[SettingOutcome, FeatureValue | None, str]:
        self._units[key.name] = self.grabber.feature(key.name).unit  # raises if the camera lacks it
        try:
            feature = self.grabber.read_setting(key)
        except FeatureError as error:
            # The selector's entry may become available with another setting.
            return SettingOutcome.DEPENDS, None, error_text(error)
        if feature.value is not None and same_value(feature.value, wanted):
            return SettingOutcome.EQUAL, feature.value, ""
        if feature.kind is FeatureKind.COMMAND:
            return (
                SettingOutcome.REFUSED,
                None,
                translate("Settings", "it is a command; loading settings runs none"),
            )
        if reason := self._inactive(key, feature):
            return SettingOutcome.LEFT_ALONE, feature.value, reason
        if not (feature.access.readable or feature.access.writable):
            return SettingOutcome.DEPENDS, None, access_text(feature)
        try:
            # Whether it is locked does not matter here: the stream or an earlier write may unlock it.
            replace(feature, access=AccessMode.READ_WRITE).validated(wanted)
        except FeatureError as error:
            return _refusal(feature, wanted), feature.value, error_text(error, feature=feature)
        if not (feature.access.writable or self._may_be_unlocked(feature)):
            return SettingOutcome.DEPENDS, feature.value, access_text(feature)
        return SettingOutcome.WOULD_WRITE, feature.value, ""

    def _may_be_unlocked(self, feature: Feature) -> bool:
        """Return whether a write of the feature ends its lock: by the stream or by its automatic mode."""
        mode = self.grabber.feature(feature.auto) if feature.auto else None
        pauses = self.grabber.streaming and self.grabber.pauses_for(feature.name)
        return pauses or as_editable(feature, mode).access.writable

    def _inactive(self, key: SettingKey, feature: Feature) -> str:
        """Return why this value has no effect in the set, by a mode or switch; empty if it has one."""
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
        """Return the set's value of another feature, with the same selectors or without."""
        if name is None:
            return None
        settings = self.features.settings
        return settings.get(SettingKey(name, beside.selected), settings.get(SettingKey(name)))

    def _note(
        self, key: SettingKey, outcome: SettingOutcome, reason: str, after: FeatureValue | None = None
    ) -> None:
        self._reports[key] = _replaced(self._reports[key], outcome, after, reason)


def _replaced(
    report: SettingReport, outcome: SettingOutcome, after: FeatureValue | None, reason: str
) -> SettingReport:
    return SettingReport(report.key, report.wanted, outcome, report.before, after, reason, report.unit)


def _refusal(feature: Feature, wanted: FeatureValue) -> SettingOutcome:
    """Return DEPENDS if an invalid value may become valid: ranges change, types and entries do not."""
    if feature.kind in (FeatureKind.INTEGER, FeatureKind.FLOAT):
        return SettingOutcome.DEPENDS if is_number(wanted) else SettingOutcome.REFUSED
    known = any(entry.name == str(wanted) for entry in feature.entries)
    return SettingOutcome.DEPENDS if known else SettingOutcome.REFUSED


def _part(progress: Progress, begin: float, end: float) -> Progress:
    """Return a callback that reports the progress of a part as progress of the whole."""
    scale = _PROGRESS_STEPS * (end - begin)
    first = _PROGRESS_STEPS * begin
    return lambda done, of: progress(round(first + scale * done / max(of, 1)), _PROGRESS_STEPS)
