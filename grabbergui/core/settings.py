"""Settings: features together with where their selectors stand, and how to bring several to given values.

A selector (GenICam standard, `pSelected`) decides which of several values a feature shows: `Gain` is
the gain of the channel that `GainSelector` selects. A setting names such a value whatever is selected at the
moment: `Gain[GainSelector=Red]`. `FrameGrabber.read_setting` and `write_setting` select, read or write, and
select back as one step.

`settle` writes several settings though one may hide, lock or limit another: loading a file, undo, and a
camera's return after a power loss all work this way. A setting that is refused (an offset that does not fit
the old width) is tried again after the others, as long as a pass gets anything done. Then every value is read
back, and what a later write disturbed is written once more. Automatic modes and switches are written last in
each pass, because writing what they rule turns a mode off and a switch on.
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import TYPE_CHECKING, NamedTuple

from grabbergui.core.errors import FeatureError, TransportError, UsageError
from grabbergui.core.features import (
    Category,
    Feature,
    FeatureDescription,
    FeatureKind,
    FeatureValue,
    format_value,
)
from grabbergui.core.sfnc import AUTO_ONCE, Companions, is_on

if TYPE_CHECKING:
    from grabbergui.core.grabber import FrameGrabber

# -- a setting -----------------------------------------------------------------------------------
_NAME = r"[^\s\[\]=,]+"  # GenICam allows letters, digits and _; parameters of ROS nodes have dots too
_KEY = re.compile(rf"({_NAME})(?:\[([^\]]*)\])?")
_ASSIGNMENT = re.compile(r"([^=\[]+(?:\[[^\]]*\]\s*)?)=(.*)", re.DOTALL)

Selected = tuple[tuple[str, str], ...]
"Pairs of selector and entry, outermost selector first."


@dataclass(frozen=True)
class SettingKey:
    """The name of a setting: a feature, and where its selectors stand."""

    name: str
    selected: Selected = ()
    "Empty for a feature without selectors, or for whatever they select at the moment."

    @classmethod
    def parse(cls, text: str) -> SettingKey:
        """Read `Width` or `Gain[GainSelector=Red]`. Raises UsageError."""
        match = _KEY.fullmatch(text)
        if match is None:
            raise UsageError(f"'{text[:60]}' is no feature's name")
        selected = []
        for part in (match[2] or "").split(",") if match[2] else ():
            selector, equals, entry = part.partition("=")
            if not equals or not re.fullmatch(_NAME, selector.strip()):
                raise UsageError(f"'[{match[2][:60]}]' is not [Selector=Entry]")
            selected.append((selector.strip(), entry.strip()))
        return cls(match[1], tuple(selected))

    @classmethod
    def parse_assignment(cls, text: str) -> tuple[SettingKey, str] | None:
        """Read `Gain=3` or `Gain[GainSelector=Red]=3`; None where there is no value. Raises UsageError."""
        match = _ASSIGNMENT.fullmatch(text)
        return (cls.parse(match[1].strip()), match[2]) if match is not None else None

    def __str__(self) -> str:
        """`Width`, `BalanceRatio[BalanceRatioSelector=Red]`."""
        if not self.selected:
            return self.name
        return f"{self.name}[{','.join(f'{selector}={entry}' for selector, entry in self.selected)}]"


class ValueChange(NamedTuple):
    """A setting, its value before and after a write; None where it could not be read."""

    key: SettingKey
    before: FeatureValue | None
    after: FeatureValue | None


@dataclass(frozen=True)
class WriteResult:
    """Everything that one write changed."""

    feature: Feature
    "The feature that was written, as the camera reports it afterwards."
    written: tuple[ValueChange, ...]
    "Written values in order: companions that had to be switched, and at last the setting itself."
    consequences: tuple[ValueChange, ...] = ()
    "Settings that the camera changed because of it (Height after BinningVertical)."
    also_changed: tuple[Feature, ...] = ()
    """The features of companions and consequences, as the camera reports them afterwards.

    A caller that has them here need not read them again. One that is missing must be read.
    """


# -- selectors -----------------------------------------------------------------------------------
@dataclass(frozen=True)
class Selectors:
    """The selectors of each feature in a camera's feature tree. Asks no camera."""

    tree: Category
    descriptions: Mapping[str, FeatureDescription] = field(init=False)
    "Every feature of the tree by name, in the tree's order."
    names: frozenset[str] = field(init=False)
    "Every feature that selects another."

    def __post_init__(self) -> None:
        descriptions = {d.name: d for d in self.tree.descriptions()}
        object.__setattr__(self, "descriptions", descriptions)
        names = frozenset(selector for d in descriptions.values() for selector in d.selectors)
        object.__setattr__(self, "names", names)

    def of(self, name: str) -> tuple[str, ...]:
        """Return what selects a feature, and what selects that: outermost first, each once."""
        found: list[str] = []
        description = self.descriptions.get(name)
        for selector in description.selectors if description is not None else ():
            # A description that selects itself in a circle must not be followed for ever.
            if selector not in found and selector != name and selector in self.descriptions:
                found.append(selector)
                above: list[str] = []
                self._collect_above(selector, above, {name, *found})
                found[-1:-1] = above
        return tuple(found)

    def _collect_above(self, name: str, above: list[str], seen: set[str]) -> None:
        for selector in self.descriptions[name].selectors:
            if selector not in seen and selector in self.descriptions:
                seen.add(selector)
                self._collect_above(selector, above, seen)
                above.append(selector)


def setting_names(selectors: Selectors) -> list[str]:
    """Return the features that make up a camera's settings: the streamable ones, if it has any."""
    known = selectors.descriptions
    streamable = [name for name, d in known.items() if d.streamable and d.kind is not FeatureKind.COMMAND]
    if streamable:
        return streamable
    return [n for n, d in known.items() if d.kind is not FeatureKind.COMMAND and n not in selectors.names]


MAX_INSTANCES = 4096
"Of one feature under its selectors: a look-up table of 12 bits. More is left out and reported."


def instances(grabber: FrameGrabber, path: Sequence[str]) -> tuple[list[Selected], str]:
    """Return every combination of the selectors' entries, and the reason if some are omitted.

    Reads the selectors, writes nothing. If they cannot be changed, only their present entries are returned.
    """
    features = [grabber.feature(name) for name in path]
    standing = tuple((f.name, format_value(f.value)) for f in features if f.value is not None)
    if len(standing) < len(features):
        return [], ""  # the camera hides its selector at the moment, and the feature with it
    if not all(f.access.writable for f in features if len(selector_entries(f)) > 1):
        return [standing], "only the present entry of its selector, which cannot be changed"
    choices = [selector_entries(feature) for feature in features]
    if math.prod(len(entries) for entries in choices) > MAX_INSTANCES:
        return [standing], f"more than {MAX_INSTANCES} instances; only the selected one is kept"
    return [tuple(zip(path, entries, strict=True)) for entries in itertools.product(*choices)], ""


def selector_entries(selector: Feature) -> Sequence[str]:
    """Return the values that a selector can take, as text."""
    if selector.kind is FeatureKind.ENUMERATION:
        return [entry.name for entry in selector.entries if entry.available]
    if selector.kind is FeatureKind.BOOLEAN:
        return ["false", "true"]
    low, high = selector.minimum, selector.maximum
    if selector.kind is FeatureKind.INTEGER and isinstance(low, int) and isinstance(high, int):
        numbers = range(low, high + 1, int(selector.increment or 1))
        # Only the beginning is made, enough to see that there are too many.
        return [str(number) for number in itertools.islice(numbers, MAX_INSTANCES + 1)]
    return [format_value(selector.value)]


# -- values --------------------------------------------------------------------------------------
_TOLERANCE = 1e-6
"Relative: other programs print seven digits of a float, and a camera rounds to its register."


def same_value(first: FeatureValue, second: FeatureValue) -> bool:
    """Whether two values mean the same, also where one is text from a file."""
    if str(first) == str(second):
        return True
    one, other = _number(first), _number(second)
    if one is None or other is None:
        return False
    if isinstance(one, int) and isinstance(other, int):
        return one == other
    return math.isclose(one, other, rel_tol=_TOLERANCE)


def is_number(value: FeatureValue) -> bool:
    """Whether a value is a number, or text that means one."""
    return _number(value) is not None


def _number(value: FeatureValue) -> int | float | None:
    if isinstance(value, int | float):
        return int(value) if isinstance(value, bool) else value
    text = value.strip().lower()
    if text in ("true", "false"):
        return int(text == "true")
    try:
        return int(text, 0)
    except ValueError:
        pass
    try:
        return float(text)
    except ValueError:
        return None


# -- several settings ----------------------------------------------------------------------------
MAX_PASSES = 6
"Of writing: more than any chain of dependencies among SFNC's features is long."
BATCH = 16
"Settings that are read or written in one go; other callers wait that long."


class Settled(Enum):
    """The outcome of one setting."""

    WRITTEN = "written"
    "It has the wanted value, whether it was written or another write brought it there."
    REFUSED = "refused"
    DIFFERENT = "different"
    "It was written, but has another value: the camera rounded it, or another setting moved it."
    UNANSWERED = "unanswered"
    "The connection was lost while it was written."


Report = Callable[[SettingKey, Settled, FeatureValue | None, FeatureError | None, Feature | None], None]
"""Called whenever something becomes known of a setting, the last call counts: its key, what became of it, its
value, the refusal, the feature as it was when it was refused."""


def settle(
    grabber: FrameGrabber,
    wanted: Mapping[SettingKey, FeatureValue],
    *,
    report: Report = lambda key, settled, value, error, feature: None,
    reluctantly: Collection[SettingKey] = (),
    cancelled: Callable[[], bool] = lambda: False,
) -> dict[SettingKey, str]:
    """Write settings until the camera has all of them; return those it has not, with the reason for each.

    Equal values are not written, and selectors end where they stood. Values that a wanted automatic mode
    regulates, and those named by `reluctantly`, are written only where another setting is refused without
    them. Raises TransportError. Once `cancelled`, nothing more is written.
    """
    work = _Settling(grabber, wanted, report, cancelled)
    work.run(frozenset(reluctantly))
    return work.problems


@dataclass
class _Settling:
    grabber: FrameGrabber
    wanted: Mapping[SettingKey, FeatureValue]
    report: Report
    cancelled: Callable[[], bool]
    problems: dict[SettingKey, str] = field(default_factory=dict)
    _seen: dict[SettingKey, FeatureValue] = field(default_factory=dict)
    "Values that came out other than wanted; writing again helps only where they have changed since."

    def run(self, reluctantly: frozenset[SettingKey]) -> None:
        """Write pass after pass, until a pass changes nothing."""
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
                # An automatic mode may hold these at values that the refused ones do not fit. Writing them
                # switches their companions, which are therefore checked again.
                self._write([key for key in order if key in held])
                for key in regulated:
                    self.problems.pop(key, None)  # their modes decide
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
                if feature is not None:  # it was read, so that the loss came with the write
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
        """Return settings that have another value than wanted, and were not seen with that value before."""
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
        """Give the keys, a batch at a time with the grabber to ourselves; selectors move once a batch."""
        remaining = iter(keys)
        while batch := list(itertools.islice(remaining, BATCH)):
            selectors = {selector: None for key in batch for selector, _ in key.selected}
            names = [name for name in selectors if SettingKey(name) not in self.wanted]
            if not names:
                yield from batch
                continue
            with self.grabber.exclusive(names):
                yield from batch
