"""Sets of settings, captured from a camera.

A `FeatureSet` has a value for each setting, that is, for each instance of a feature that selectors select.
It is plain data from any frame grabber; `files` writes and reads it, `loading` writes it to a camera.
"""

from __future__ import annotations

import itertools
import threading
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from grabbergui.core.errors import FeatureError
from grabbergui.core.feature_instances import instances
from grabbergui.core.features import AccessMode, FeatureValue, format_value
from grabbergui.core.grabber import Access, FrameGrabber
from grabbergui.core.identity import describe
from grabbergui.core.settings import Selected, Selectors, SettingKey, same_value, setting_names
from grabbergui.core.settle import BATCH

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
