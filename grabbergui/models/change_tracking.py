"""A grabber that records its writes and commands; undo and redo; changes as a script or a program."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

from typing_extensions import override

from grabbergui.core.errors import FeatureError
from grabbergui.core.feature_instances import instances_of
from grabbergui.core.feature_source import FeatureSource
from grabbergui.core.features import Feature, FeatureValue, format_value
from grabbergui.core.grabber import Access, FrameGrabber
from grabbergui.core.settings import SettingKey, ValueChange, WriteResult
from grabbergui.core.settle import settle
from grabbergui.core.sfnc import PLAYBACK_POSITION, is_on, regulated_by_mode, regulating
from grabbergui.core.shared import SharedGrabber
from grabbergui.core.shell_words import shell_line
from grabbergui.models.change import Change, Origin
from grabbergui.models.change_journal import ChangeJournal
from grabbergui.models.features.sensor_region import stream_paused
from grabbergui.models.language import translate
from grabbergui.models.undo_steps import Direction

log = logging.getLogger(__name__)

CONSEQUENCES = 0.5
"Seconds after a write in which other changes count as its consequences."
MOST_KNOWN = 20_000
"Most settings whose last value is remembered."
MOST_WITHOUT_PAUSE = 4
"Above this number of settings the stream is stopped once, instead of for each setting that needs it."
Write = tuple[str, FeatureValue | None]
"A feature and its value; None runs a command."


class ChangeTrackingGrabber(SharedGrabber):
    """A handle on an open grabber that records every write and command in a journal.

    Use from the thread that makes the grabber's calls. The side effects of a write (an automatic mode
    switched off, a height that no longer fits) are recorded with it. Selectors that are moved to reach a
    setting are restored and not recorded.
    """

    def __init__(
        self, grabber: FrameGrabber, journal: ChangeJournal, clock: Callable[[], float] = time.monotonic
    ) -> None:
        super().__init__(grabber)
        self.journal = journal
        self.others_write = grabber.shared
        "Whether others may write, too, so that a change not made here may be theirs."
        self._clock = clock
        self._wrote = float("-inf")
        self._known: dict[SettingKey, FeatureValue] = {}
        self.learn()

    @property
    def plain(self) -> FrameGrabber:
        """The grabber itself, whose use is not recorded."""
        return self._grabber

    def selectors_of(self, name: str) -> tuple[str, ...]:
        """Return what selects an instance of a feature, outermost first. Any thread; asks no camera."""
        return self.selectors.of(name)

    @override
    def write_feature(self, name: str, value: FeatureValue) -> Feature:
        return self.write_setting(SettingKey(name), value).feature

    @override
    def write_setting(self, key: SettingKey, value: FeatureValue) -> WriteResult:
        displaced = self._displaced(key, value)
        self._wrote = self._clock()
        result = self._grabber.write_setting(key, value)
        self._wrote = self._clock()
        for changed, _, now in (*result.consequences, *result.written):
            self._remember(changed, now)
        *companions, own = result.written
        companions = [change for change in companions if change.before != change.after]
        if companions or result.consequences or own.before != own.after:
            self.journal.wrote([*companions, own], result.consequences, displaced)
        return result

    @override
    def execute(self, name: str) -> None:
        self.execute_setting(SettingKey(name))

    @override
    def execute_setting(self, key: SettingKey) -> None:
        if not key.selected:
            key = self._grabber.setting(key.name)
        self._wrote = self._clock()
        self._grabber.execute_setting(key)
        self._wrote = self._clock()
        self.journal.ran(key)

    def watch(self, feature: Feature) -> None:
        """Compare a feature just read with its last known value, and record a change by others.

        Read-only features, such as a temperature, are ignored unless an automatic mode locks them, and so is
        the position of a recording that plays.
        """
        if (
            feature.name == PLAYBACK_POSITION
            or feature.value is None
            or not (feature.access.writable or feature.auto)
        ):
            return
        try:
            key = self.setting(feature.name)
            known = self._known.get(key)
            self._remember(key, feature.value)
            if known is not None and known != feature.value:
                self.journal.saw(key, known, feature.value, self._origin(feature))
        except FeatureError as error:
            log.debug("a change of %s is not recorded: %s", feature.name, error)

    def note_peer(self, changes: Iterable[ValueChange], author: str = "") -> None:
        """Record what another user wrote through another handle on this camera. Any thread."""
        for key, before, after in changes:
            self._remember(key, after)
            if before is not None and after is not None and before != after:
                self.journal.saw(key, before, after, Origin.NETWORK, author)

    def learn(self) -> None:
        """Learn the automatic modes of the grabber's present tree."""
        self._regulates = regulated_by_mode(self.selectors.descriptions, self.has_feature)

    def _displaced(self, key: SettingKey, value: FeatureValue) -> dict[SettingKey, FeatureValue]:
        """Return the manual values that are lost if this write switches an automatic mode on."""
        regulated = self._regulates.get(key.name, ())
        if not regulated or not is_on(value) or regulating(self._grabber.read_setting(key)):
            return {}
        found: dict[SettingKey, FeatureValue] = {}
        for name in regulated:
            found.update(every_instance(self._grabber, name))
        return found

    def _origin(self, feature: Feature) -> Origin:
        if feature.auto and regulating(self._grabber.feature(feature.auto)):
            return Origin.CAMERA
        others = self.others_write or self._grabber.access is not Access.CONTROL
        consequence = self._clock() - self._wrote < CONSEQUENCES
        return Origin.NETWORK if others and not consequence else Origin.CAMERA

    def _remember(self, key: SettingKey, value: FeatureValue | None) -> None:
        if value is None:
            return
        if len(self._known) >= MOST_KNOWN:
            self._known.clear()
        self._known[key] = value


def every_instance(grabber: FeatureSource, name: str) -> dict[SettingKey, FeatureValue]:
    """Return a feature's value under each combination of its selectors, which are restored."""
    with grabber.exclusive(grabber.selectors.of(name)):
        values = {key: grabber.read_setting(key).value for key in instances_of(grabber, name)}
    return {key: value for key, value in values.items() if value is not None}


def revert(grabber: ChangeTrackingGrabber, direction: Direction) -> list[str]:
    """Undo or redo the next step, if any; return a sentence for each value that could not be restored.

    Call it on the thread that makes the grabber's calls. A refused value is tried again with the next step:
    an automatic mode that an earlier step switched on may have moved its limits. Raises TransportError if
    the camera is lost; the step can then be tried again.
    """
    journal = grabber.journal
    with journal.reverting(direction) as step:
        if step is None:
            return []
        values = dict(step.values(direction))
        wanted = {**journal.owed(direction), **values}
        problems = write_values(grabber, wanted)
        journal.owe(direction, {key: wanted[key] for key in problems})
    text = translate("Changes", "{0} of {1}: {2}")
    return [text.format(direction.title, step, problem) for key, problem in problems.items() if key in values]


def write_values(
    grabber: ChangeTrackingGrabber, values: Mapping[SettingKey, FeatureValue]
) -> dict[SettingKey, str]:
    """Write settings as `settle` does; return a sentence for each that could not be set."""
    with stream_paused(grabber, len(values) > MOST_WITHOUT_PAUSE):
        return settle(grabber, values)


def writes(changes: Iterable[Change]) -> list[Write]:
    """Return the writes and commands that repeat the changes, in order, with the selectors they need."""
    found: list[Write] = []
    pending: dict[SettingKey, Change] = {}
    selected: dict[str, str] = {}
    for change in changes:
        if change.origin is Origin.CAMERA:
            continue
        if not change.command:
            first = pending.pop(change.key, change)  # moved to the end: it was written after the others
            pending[change.key] = replace(change, before=first.before)
            continue
        found += _settings(pending.values(), selected)
        pending.clear()
        found += _selections(change.key, selected)
        found.append((change.key.name, None))
        selected.clear()  # a command such as UserSetLoad may move selectors
    return [*found, *_settings(pending.values(), selected)]


def command_line(uri: str, changes: Iterable[Change]) -> str:
    """Return the changes for a shell: lines of `grabbergui set URI NAME=VALUE …` and `grabbergui run`."""
    lines: list[list[str]] = []
    for name, value in writes(changes):
        if value is None:
            lines.append(["run", uri, name])
        elif lines and lines[-1][0] == "set":
            lines[-1].append(f"{name}={format_value(value)}")
        else:
            lines.append(["set", uri, f"{name}={format_value(value)}"])
    return "".join(f"grabbergui {shell_line(words)}\n" for words in lines)


def program(uri: str, changes: Sequence[Change]) -> str:
    """Return a Python program that opens the source, makes the changes, and closes it."""
    when = time.strftime("%Y-%m-%d %H:%M", time.localtime(changes[-1].time)) if changes else "no changes"
    calls = [
        f"    camera.execute({name!r})" if value is None else f"    camera[{name!r}] = {value!r}"
        for name, value in writes(changes)
    ]
    return "\n".join(
        [
            f'"""Sets a camera as it was set with grabbergui ({when})."""',
            "",
            "import grabbergui",
            "",
            f"with grabbergui.open({uri!r}) as camera:",
            *(calls or ["    pass"]),
            "",
        ]
    )


def _settings(changes: Iterable[Change], selected: dict[str, str]) -> Iterator[Write]:
    for change in changes:
        if change.after is None or not change.effective:
            continue
        yield from _selections(change.key, selected)
        yield change.key.name, change.after
        selected[change.key.name] = format_value(change.after)  # it may be a selector itself


def _selections(key: SettingKey, selected: dict[str, str]) -> Iterator[Write]:
    """Yield the writes of the selectors that differ from `selected`, and note them there."""
    for selector, entry in key.selected:
        if selected.get(selector) != entry:
            selected[selector] = entry
            yield selector, entry
