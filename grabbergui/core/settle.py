"""Writes several settings, which may hide, lock or limit each other.

`settle` is for loading a file, for undo, and for a camera that returns after a power loss. A refused setting
(an offset that does not fit the old width) is tried again after the others, as long as a pass makes progress.
Then every value is read back, and those that a later write changed are written again. Automatic modes and
enablers are written last in each pass, because writing a feature that they control switches the mode off or
the enabler on.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from enum import Enum

from grabbergui.core.errors import FeatureError, TransportError
from grabbergui.core.feature_source import FeatureSource
from grabbergui.core.features import Feature, FeatureValue, format_value
from grabbergui.core.settings import SettingKey, same_value
from grabbergui.core.sfnc import AUTO_ONCE, Companions, is_on

MAX_PASSES = 6
"Most passes of writing, more than the longest chain of dependencies among SFNC's features."
BATCH = 16
"Settings that are read or written in one go while other callers wait."


class Settled(Enum):
    """The outcome of one setting."""

    WRITTEN = "written"
    "It has the wanted value, by this write or another."
    REFUSED = "refused"
    DIFFERENT = "different"
    "It was written but has another value, as the camera rounded it or another setting changed it."
    UNANSWERED = "unanswered"
    "The connection was lost while it was written."


Report = Callable[[SettingKey, Settled, FeatureValue | None, FeatureError | None, Feature | None], None]
"""Called with each result for a setting, of which the last counts: key, outcome, value, the error if it was
refused, and the feature at that time."""


def settle(
    grabber: FeatureSource,
    wanted: Mapping[SettingKey, FeatureValue],
    *,
    report: Report = lambda key, settled, value, error, feature: None,
    reluctantly: Collection[SettingKey] = (),
    cancelled: Callable[[], bool] = lambda: False,
) -> dict[SettingKey, str]:
    """Write settings until the camera has all of them; return the others with the reason for each.

    Equal values are not written, and selectors are restored. Values that a wanted automatic mode regulates,
    and those in `reluctantly`, are only written if another setting is refused without them. Raises
    TransportError. Once `cancelled` returns true, nothing more is written.
    """
    work = _Settling(grabber, wanted, report, cancelled)
    work.run(frozenset(reluctantly))
    return work.problems


@dataclass
class _Settling:
    grabber: FeatureSource
    wanted: Mapping[SettingKey, FeatureValue]
    report: Report
    cancelled: Callable[[], bool]
    problems: dict[SettingKey, str] = field(default_factory=dict)
    _seen: dict[SettingKey, FeatureValue] = field(default_factory=dict)
    "Values that differed from the wanted ones; writing again helps only if they have changed since."

    def run(self, reluctantly: frozenset[SettingKey]) -> None:
        """Write in passes until a pass changes nothing."""
        companions = {key.name: Companions.of(key.name, self.grabber.has_feature) for key in self.wanted}
        switches = {name for found in companions.values() for name in found.names}
        order = sorted(self.wanted, key=lambda key: key.name in switches)
        regulated = frozenset(key for key in self.wanted if self._mode_is_wanted(key, companions[key.name]))
        held = regulated | reluctantly
        pending = [key for key in order if key not in held]
        for _ in range(MAX_PASSES):
            refused = self._write(pending)
            if self.cancelled():
                return
            disturbed = self._disturbed(key for key in order if key not in held and key not in refused)
            again = {*refused, *disturbed}
            if not again or (len(refused) == len(pending) and not held):
                return
            if refused and held:
                # The values left out so far may be incompatible with the refused ones. Writing them switches
                # their companions, which are therefore checked again.
                self._write([key for key in order if key in held])
                for key in regulated:
                    self.problems.pop(key, None)  # their automatic modes determine them
                names = {name for key in held for name in companions[key.name].names}
                again.update(key for key in order if key.name in names)
                held = frozenset()
                order = [key for key in order if key not in regulated]
            pending = [key for key in order if key in again]

    def _mode_is_wanted(self, key: SettingKey, companions: Companions) -> bool:
        if companions.mode is None:
            return False
        mode = self.wanted.get(SettingKey(companions.mode, key.selected))
        return is_on(self.wanted.get(SettingKey(companions.mode)) if mode is None else mode)

    def _write(self, keys: list[SettingKey]) -> list[SettingKey]:
        """Write the settings that differ; return those that were refused."""
        refused = []
        for key in self._in_batches(keys):
            if self.cancelled():
                break
            feature = None
            try:
                feature = self.grabber.read_setting(key)
                if feature.value is None or not same_value(feature.value, self.wanted[key]):
                    feature = self.grabber.write_setting(key, self.wanted[key]).feature
            except TransportError:
                if feature is not None:  # it could be read, so the write failed
                    self.report(key, Settled.UNANSWERED, None, None, feature)
                raise
            except FeatureError as error:
                refused.append(key)
                self.problems[key] = str(error)
                self.report(key, Settled.REFUSED, None, error, feature)
            else:
                self.problems.pop(key, None)
                self.report(key, Settled.WRITTEN, feature.value, None, feature)
        return refused

    def _disturbed(self, keys: Iterable[SettingKey]) -> list[SettingKey]:
        """Return settings whose value differs from the wanted one and is not one seen before."""
        disturbed = []
        for key in self._in_batches(keys):
            try:
                value = self.grabber.read_setting(key).value
            except FeatureError as error:
                self.problems[key] = str(error)
                continue
            wanted = self.wanted[key]
            if value is None or wanted == AUTO_ONCE or same_value(value, wanted):
                if self._seen.pop(key, None) is not None:
                    self.report(key, Settled.WRITTEN, value, None, None)
                self.problems.pop(key, None)
                continue
            if self._seen.get(key) != value:
                disturbed.append(key)
            self._seen[key] = value
            self.problems[key] = f"{key} is {format_value(value)} instead of {format_value(wanted)}"
            self.report(key, Settled.DIFFERENT, value, None, None)
        return disturbed

    def _in_batches(self, keys: Iterable[SettingKey]) -> Iterator[SettingKey]:
        """Yield the keys; hold the grabber for a batch at a time, and restore selectors once per batch."""
        remaining = iter(keys)
        while batch := list(itertools.islice(remaining, BATCH)):
            selectors = {selector: None for key in batch for selector, _ in key.selected}
            names = [name for name in selectors if SettingKey(name) not in self.wanted]
            if not names:
                yield from batch
                continue
            with self.grabber.exclusive(names):
                yield from batch
