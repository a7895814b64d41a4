"""A grabber that records its writes and commands; undo and redo; changes as commands or as a program."""

from __future__ import annotations

import logging
import shlex
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

from typing_extensions import override

from grabbergui.core.errors import FeatureError
from grabbergui.core.features import Feature, FeatureValue, format_value
from grabbergui.core.grabber import Access, FrameGrabber
from grabbergui.core.settings import SettingKey, WriteResult, instances, settle
from grabbergui.core.sfnc import is_on, regulated_by_mode, regulating
from grabbergui.core.shared import SharedGrabber
from grabbergui.models.change_journal import Change, ChangeJournal, Direction, Origin
from grabbergui.models.features.sensor_region import stream_paused

log = logging.getLogger(__name__)

CONSEQUENCES = 0.5
"Seconds after a write of ours in which what else moves is taken for its consequence."
MOST_KNOWN = 20_000
"Settings whose last value is remembered."


class ChangeTrackingGrabber(SharedGrabber):
    """A handle on an open grabber that records every write and command in a journal.

    Use from the thread that makes the grabber's calls. Side effects of a write (a mode that is switched off,
    a height that no longer fits) are recorded with it. Selectors that are moved to reach a setting are
    restored and not recorded.
    """

    def __init__(
        self, grabber: FrameGrabber, journal: ChangeJournal, clock: Callable[[], float] = time.monotonic
    ) -> None:
        super().__init__(grabber)
        self.journal = journal
        self._others_write = grabber.shared
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
        *companions, meant = result.written
        companions = [change for change in companions if change.before != change.after]
        if companions or result.consequences or meant.before != meant.after:
            self.journal.wrote([*companions, meant], result.consequences, displaced)
        return result

    @override
    def execute(self, name: str) -> None:
        self.execute_setting(SettingKey(name))

    @override
    def execute_setting(self, key: SettingKey) -> None:
        self._wrote = self._clock()
        self._grabber.execute_setting(key)
        self._wrote = self._clock()
        self.journal.ran(key.name)

    def watch(self, feature: Feature) -> None:
        """Compare a feature that was read and record changes by others. On the same thread.

        Read-only features, such as a temperature, are left out unless an automatic mode locks them.
        """
        if feature.value is None or not (feature.access.writable or feature.auto):
            return
        try:
            key = self.setting(feature.name)
            known = self._known.get(key)
            self._remember(key, feature.value)
            if known is not None and known != feature.value:
                self.journal.saw(key, known, feature.value, self._origin(feature))
        except FeatureError as error:
            log.debug("a change of %s is not noted: %s", feature.name, error)

    def learn(self) -> None:
        """Read the grabber's new tree."""
        self._regulates = regulated_by_mode(self.selectors.descriptions, self.has_feature)

    def _displaced(self, key: SettingKey, value: FeatureValue) -> dict[SettingKey, FeatureValue]:
        """Return the manual values that are lost when a write switches an automatic mode on."""
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
        others = self._others_write or self._grabber.access is not Access.CONTROL
        ours = self._clock() - self._wrote < CONSEQUENCES
        return Origin.NETWORK if others and not ours else Origin.CAMERA

    def _remember(self, key: SettingKey, value: FeatureValue | None) -> None:
        if value is None:
            return
        if len(self._known) >= MOST_KNOWN:
            self._known.clear()
        self._known[key] = value


def every_instance(grabber: FrameGrabber, name: str) -> dict[SettingKey, FeatureValue]:
    """Return a feature's value under each combination of its selectors, which are restored."""
    path = grabber.selectors.of(name)
    with grabber.exclusive(path):
        keys = [SettingKey(name, selected) for selected in instances(grabber, path)[0]]
        values = {key: grabber.read_setting(key).value for key in keys}
    return {key: value for key, value in values.items() if value is not None}


FEW = 4
"Number of settings above which the stream is stopped once instead of for each that changes the frames."


def revert(grabber: ChangeTrackingGrabber, direction: Direction) -> list[str]:
    """Undo or redo the next step; return a sentence for each value that could not be restored.

    Call it on the thread that makes the grabber's calls. A refused value is tried again with the next step:
    an automatic mode may have moved its limits, and that mode is undone later. Does nothing if there is no
    step. Raises TransportError if the camera is lost; the step can then be tried again.
    """
    journal = grabber.journal
    with journal.reverting(direction) as step:
        if step is None:
            return []
        values = dict(step.values(direction))
        wanted = {**journal.owed(direction), **values}
        problems = write_values(grabber, wanted)
        journal.owe(direction, {key: wanted[key] for key in problems})
    return [f"{direction.value} of {step}: {problem}" for key, problem in problems.items() if key in values]


def write_values(
    grabber: ChangeTrackingGrabber, values: Mapping[SettingKey, FeatureValue]
) -> dict[SettingKey, str]:
    """Write settings until all are there, as `settle` does; return what could not be set, a sentence each."""
    with stream_paused(grabber, len(values) > FEW):
        return settle(grabber, values)


Write = tuple[str, FeatureValue | None]
"A feature and its value; None runs a command."


def writes(changes: Iterable[Change]) -> list[Write]:
    """Return the values to write, in order, with selectors where they are needed."""
    found: list[Write] = []
    run: dict[SettingKey, Change] = {}
    standing: dict[str, str] = {}
    for change in changes:
        if change.origin is Origin.CAMERA:
            continue
        if not change.command:
            known = run.pop(change.key, change)  # at the end: it was set after the others
            run[change.key] = _joined(known, change)
            continue
        found += _settings(run.values(), standing)
        run.clear()
        found.append((change.key.name, None))
    return [*found, *_settings(run.values(), standing)]


def command_line(uri: str, changes: Iterable[Change]) -> str:
    """`grabbergui set URI NAME=VALUE …`, and `grabbergui run` for commands, a line each, for a shell."""
    lines: list[list[str]] = []
    for name, value in writes(changes):
        if value is None:
            lines.append(["run", uri, name])
        elif lines and lines[-1][0] == "set":
            lines[-1].append(f"{name}={format_value(value)}")
        else:
            lines.append(["set", uri, f"{name}={format_value(value)}"])
    return "".join(f"grabbergui {shlex.join(words)}\n" for words in lines)


def program(uri: str, changes: Sequence[Change]) -> str:
    """Return a program in Python that opens the source, makes the changes, and closes it."""
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


def _joined(first: Change, last: Change) -> Change:
    return Change(
        last.number, last.time, last.key, first.before, last.after, last.origin, last.cause, last.command
    )


def _settings(changes: Iterable[Change], standing: dict[str, str]) -> Iterator[Write]:
    for change in changes:
        if change.after is None or not change.effective:
            continue
        for selector, entry in change.key.selected:
            if standing.get(selector) != entry:
                standing[selector] = entry
                yield selector, entry
        yield change.key.name, change.after
        standing[change.key.name] = format_value(change.after)  # it may be a selector itself
