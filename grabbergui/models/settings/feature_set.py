"""A set of settings: a camera's values, for each instance that its selectors select.

Plain data, taken from any frame grabber and compared with another set. Its file formats are in
`files`, how it comes back onto a camera by `loading`.
"""

from __future__ import annotations

import itertools
import threading
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from grabbergui.core.errors import FeatureError
from grabbergui.core.features import AccessMode, FeatureKind, FeatureValue, format_value
from grabbergui.core.grabber import Access, FrameGrabber
from grabbergui.core.identity import describe
from grabbergui.core.selection import Selected, Selectors, SettingKey, instances, same_value

BATCH = 16
"Settings that are read in one go; other callers wait that long."

Progress = Callable[[int, int], None]
"Called with how much is done and of how much."
SelectorsOf = Callable[[str], Sequence[str]]
"The names of the features that select which instance of a feature is seen, outermost first."


@dataclass(frozen=True)
class FeatureSet:
    """Settings in the order in which they are set."""

    settings: Mapping[SettingKey, FeatureValue]
    device: str = ""
    "Vendor, model and serial number of their camera, as display text."
    left_out: tuple[str, ...] = ()
    "Settings that could not be saved and why, a sentence each."
    lost_lines: tuple[str, ...] = ()
    "Lines of the file it was read from that make no sense, a sentence each."

    def __len__(self) -> int:
        return len(self.settings)

    def only(self, keys: Collection[SettingKey] | None) -> FeatureSet:
        """Return the set reduced to these settings; None keeps all."""
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
    """One setting that two sets do not agree on."""

    key: SettingKey
    first: FeatureValue | None
    "None where the first set does not have it."
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
    """Return every streamable setting; selectors are stepped through and then restored.

    Selectors are written if the grabber is open for control; with read-only access, only the present entries
    are read. A source without streamable features returns all that can be read and written. Raises
    TransportError; with `cancelled` set, returns the settings read until then.
    """
    selectors = grabber.selectors
    wanted = _wanted(selectors)
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


def every_instance(grabber: FrameGrabber, name: str) -> dict[SettingKey, FeatureValue]:
    """Return a feature's value under each combination of its selectors, which are restored."""
    path = grabber.selectors.of(name)
    with grabber.exclusive(path):
        keys = [SettingKey(name, selected) for selected in instances(grabber, path)[0]]
        values = {key: grabber.read_setting(key).value for key in keys}
    return {key: value for key, value in values.items() if value is not None}


def _wanted(selectors: Selectors) -> list[str]:
    known = selectors.descriptions
    streamable = [name for name, d in known.items() if d.streamable and d.kind is not FeatureKind.COMMAND]
    if streamable:
        return streamable
    return [n for n, d in known.items() if d.kind is not FeatureKind.COMMAND and n not in selectors.names]


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
        standing = grabber.setting(path[-1])
        selected = (*standing.selected, (path[-1], format_value(grabber.feature(path[-1]).value)))
        return [selected], "only the present entry of its selector, which cannot be changed"
    return found, problem


def _value_of(
    grabber: FrameGrabber, key: SettingKey, left_out: list[str]
) -> Iterator[tuple[SettingKey, FeatureValue]]:
    """Yield a feature's value if it is a setting."""
    try:
        feature = grabber.read_setting(key)
    except FeatureError as error:  # an entry that cannot be selected
        left_out.append(f"{key}: {error}")
        return
    if feature.problem:
        left_out.append(f"{key}: {feature.problem}")
    reading = grabber.access is not Access.CONTROL and feature.access is AccessMode.READ_ONLY
    if feature.value is not None and (feature.access.writable or reading):
        yield key, feature.value


def _in_tree_order(
    settings: dict[SettingKey, FeatureValue], names: Sequence[str]
) -> dict[SettingKey, FeatureValue]:
    place = {name: index for index, name in enumerate(names)}
    return dict(sorted(settings.items(), key=lambda item: place[item[0].name]))


def _shown(value: FeatureValue | None) -> str:
    return "(not in it)" if value is None else format_value(value)
