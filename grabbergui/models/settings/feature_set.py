"""Sets of settings, captured from a camera or kept in the camera itself.

A `FeatureSet` has a value for each setting, that is, for each instance of a feature that selectors select.
It is plain data from any frame grabber; `files` writes and reads it, `loading` writes it to a camera. A
`UserSet` stays in the camera (SFNC, UserSetControl).
"""

from __future__ import annotations

import itertools
import threading
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

from grabbergui.core.errors import FeatureError, FeatureNotFoundError
from grabbergui.core.features import AccessMode, FeatureKind, FeatureValue, format_value
from grabbergui.core.grabber import Access, FrameGrabber
from grabbergui.core.identity import describe
from grabbergui.core.settings import Selected, Selectors, SettingKey, ValueChange, same_value, setting_names
from grabbergui.core.settle import BATCH, instances
from grabbergui.models.change_journal import Step
from grabbergui.models.change_tracking import ChangeTrackingGrabber
from grabbergui.models.features.sensor_region import stream_paused

Progress = Callable[[int, int], None]
"Called with the number of steps done and the total."
SelectorsOf = Callable[[str], Sequence[str]]
"Returns the selectors of a feature, outermost first."


@dataclass(frozen=True)
class FeatureSet:
    """Settings in the order in which they are written."""

    settings: Mapping[SettingKey, FeatureValue]
    device: str = ""
    "Vendor, model and serial number of their camera, as display text."
    left_out: tuple[str, ...] = ()
    "Settings that could not be captured and why, a sentence each."
    lost_lines: tuple[str, ...] = ()
    "Invalid lines of the file it was read from, a sentence each."

    def __len__(self) -> int:
        return len(self.settings)

    def only(self, keys: Collection[SettingKey] | None) -> FeatureSet:
        """Return the set reduced to these settings; with None, all of it."""
        if keys is None:
            return self
        settings = {key: value for key, value in self.settings.items() if key in keys}
        return replace(self, settings=settings)

    def selectors_of(self, name: str) -> tuple[str, ...]:
        """Return the selectors of a feature, as far as this set contains them."""
        for key in self.settings:
            if key.name == name:
                return tuple(selector for selector, _ in key.selected)
        return ()


@dataclass(frozen=True)
class Difference:
    """A setting in which two sets differ."""

    key: SettingKey
    first: FeatureValue | None
    "None if the first set does not have it; likewise `second`."
    second: FeatureValue | None

    def __str__(self) -> str:
        return f"{self.key}: {_shown(self.first)} → {_shown(self.second)}"


def compare(first: FeatureSet, second: FeatureSet) -> list[Difference]:
    """Return the differences in the second set's order; settings that only the first has come last."""
    differences = [
        Difference(key, first.settings.get(key), value)
        for key, value in second.settings.items()
        if key not in first.settings or not same_value(first.settings[key], value)
    ]
    missing = [key for key in first.settings if key not in second.settings]
    return differences + [Difference(key, first.settings[key], None) for key in missing]


def capture(
    grabber: FrameGrabber,
    *,
    progress: Progress = lambda done, of: None,
    cancelled: threading.Event | None = None,
) -> FeatureSet:
    """Return every streamable setting of a camera, stepping through the selectors and restoring them.

    With read-only access selectors are not written, and only their present entries are captured. For a source
    without streamable features, returns everything that can be read and written. With `cancelled` set,
    returns the settings captured so far. Raises TransportError.
    """
    selectors = grabber.selectors
    wanted = setting_names(selectors)
    settings: dict[SettingKey, FeatureValue] = {}
    left_out: list[str] = []
    groups = [(path, names, *_instances(grabber, path)) for path, names in _grouped(wanted, selectors)]
    done, total = 0, sum(len(names) * len(selections) for _, names, selections, _ in groups)
    for path, names, selections, problem in groups:
        if problem:
            left_out.append(f"{', '.join(names)}: {problem}")
        keys = (SettingKey(name, selected) for selected in selections for name in names)
        while batch := list(itertools.islice(keys, BATCH)):
            with grabber.exclusive(path):
                for key in batch:
                    if cancelled is not None and cancelled.is_set():
                        return FeatureSet(settings, describe(grabber.info), tuple(left_out))
                    settings.update(_value_of(grabber, key, left_out))
                    done += 1
                    progress(done, total)
    return FeatureSet(_in_tree_order(settings, wanted), describe(grabber.info), tuple(left_out))


def _grouped(names: Sequence[str], selectors: Selectors) -> list[tuple[tuple[str, ...], list[str]]]:
    """Group features by their selectors, so that each selector is stepped through once."""
    groups: dict[tuple[str, ...], list[str]] = {}
    for name in names:
        groups.setdefault(selectors.of(name), []).append(name)
    return list(groups.items())


def _instances(grabber: FrameGrabber, path: Sequence[str]) -> tuple[list[Selected], str]:
    """Return the combinations of selectors' entries to read, and the reason if some are omitted."""
    found, problem = instances(grabber, path)
    if path and found and grabber.access is not Access.CONTROL:
        innermost = grabber.setting(path[-1])
        selected = (*innermost.selected, (innermost.name, format_value(grabber.feature(path[-1]).value)))
        return [selected], "only the present entry of its selector, which cannot be changed"
    return found, problem


def _value_of(
    grabber: FrameGrabber, key: SettingKey, left_out: list[str]
) -> Iterator[tuple[SettingKey, FeatureValue]]:
    """Yield a feature's value if it is a setting."""
    try:
        feature = grabber.offered(grabber.read_setting(key))  # writable even if the stream locks it
    except FeatureError as error:  # the entry cannot be selected
        left_out.append(f"{key}: {error}")
        return
    if feature.problem:
        left_out.append(f"{key}: {feature.problem}")
    monitored = grabber.access is not Access.CONTROL and feature.access is AccessMode.READ_ONLY
    value = feature.spelled(feature.value)
    if value is not None and (feature.access.writable or monitored):
        yield key, value


def _in_tree_order(
    settings: dict[SettingKey, FeatureValue], names: Sequence[str]
) -> dict[SettingKey, FeatureValue]:
    order = {name: index for index, name in enumerate(names)}
    return dict(sorted(settings.items(), key=lambda item: order[item[0].name]))


def _shown(value: FeatureValue | None) -> str:
    return "(not in it)" if value is None else format_value(value)


# -- the camera's user sets ----------------------------------------------------------------------
_SELECTOR = "UserSetSelector"
_LOAD = "UserSetLoad"
_SAVE = "UserSetSave"
_STARTS_WITH = ("UserSetDefault", "UserSetDefaultSelector", "DefaultStartupSet")
"Names of the feature for the set loaded at power-on: SFNC 2, SFNC 1, and older."
_FACTORY = ("Default", "Factory")
"Prefixes of the names of sets that cannot be overwritten."


@dataclass(frozen=True)
class UserSet:
    """One of the camera's user sets."""

    name: str
    "The selector's entry, e.g. `UserSet1`."
    title: str
    tooltip: str = ""
    savable: bool = False
    "Whether the present settings can be saved in it; false for factory sets."
    startable: bool = False
    "Whether the camera can start with it."
    starts: bool = False
    "Whether the camera starts with it."


def has_user_sets(grabber: FrameGrabber) -> bool:
    """Return whether the camera has user sets that can be loaded."""
    return grabber.has_feature(_SELECTOR) and grabber.has_feature(_LOAD)


def user_sets(grabber: FrameGrabber) -> list[UserSet]:
    """Return the camera's user sets in its order; the selector is moved and restored.

    A streaming camera may refuse to save; then all sets but the factory's are assumed to be savable. Raises
    FeatureError, TransportError.
    """
    _require_user_sets(grabber)
    starting = _power_on_choice(grabber)
    default = grabber.feature(starting) if starting is not None else None
    can_start = {entry.name for entry in default.entries if entry.available} if default is not None else set()
    settable = default is not None and default.access.writable
    found: list[UserSet] = []
    with grabber.exclusive([_SELECTOR]):
        for entry in grabber.feature(_SELECTOR).entries:
            if not entry.available:
                continue
            savable = selected = False
            with suppress(FeatureError):
                save = grabber.read_setting(
                    _of_set(_SAVE if grabber.has_feature(_SAVE) else _LOAD, entry.name)
                )
                selected, savable = True, save.name == _SAVE and save.access.writable
            if not savable and selected and grabber.streaming:
                savable = not entry.name.startswith(_FACTORY)
            found.append(
                UserSet(
                    entry.name,
                    entry.title,
                    entry.tooltip,
                    savable,
                    settable and entry.name in can_start,
                    default is not None and default.value == entry.name,
                )
            )
    return found


def load_user_set(
    grabber: ChangeTrackingGrabber,
    name: str,
    *,
    progress: Progress = lambda done, of: None,
    cancelled: threading.Event | None = None,
) -> int:
    """Load one of the camera's user sets, and record the changes so that they can be undone.

    Returns the number of settings that changed; with `cancelled` set in time, loads nothing. Raises
    FeatureError, TransportError.
    """
    _require_user_sets(grabber)
    camera = grabber.plain
    with stream_paused(camera):
        before = capture(camera, progress=lambda done, of: progress(done, 2 * of), cancelled=cancelled)
        if cancelled is not None and cancelled.is_set():
            return 0
        grabber.execute_setting(_of_set(_LOAD, name))
        after = capture(camera, progress=lambda done, of: progress(of + done, 2 * of))
    changed = [ValueChange(d.key, d.first, d.second) for d in compare(before, after)]
    if changed:
        with grabber.journal.within(Step(f"{_LOAD} {name}")):
            grabber.journal.wrote(changed)
    return len(changed)


def save_user_set(grabber: ChangeTrackingGrabber, name: str) -> None:
    """Save the present settings in one of the camera's user sets. Raises FeatureError, TransportError."""
    _require_user_sets(grabber)
    camera = grabber.plain
    # Some cameras refuse to save while they stream.
    with stream_paused(camera):
        grabber.execute_setting(_of_set(_SAVE, name))


def start_with_user_set(grabber: ChangeTrackingGrabber, name: str) -> None:
    """Let the camera load this set at power-on. Raises FeatureError, TransportError."""
    starting = _power_on_choice(grabber)
    if starting is None:
        raise FeatureNotFoundError(f"{grabber.info.title} always starts with the same set", _STARTS_WITH[0])
    grabber.write_feature(starting, name)


def _power_on_choice(grabber: FrameGrabber) -> str | None:
    names = [name for name in _STARTS_WITH if grabber.has_feature(name)]
    return next((n for n in names if grabber.feature(n).kind is FeatureKind.ENUMERATION), None)


def _of_set(command: str, name: str) -> SettingKey:
    return SettingKey(command, ((_SELECTOR, name),))


def _require_user_sets(grabber: FrameGrabber) -> None:
    if not has_user_sets(grabber):
        raise FeatureNotFoundError(f"{grabber.info.title} keeps no sets of settings", _SELECTOR)
