"""Settings: features with the values of their selectors.

A selector (GenICam standard, `pSelected`) decides which of several values a feature shows: `Gain` is the gain
of the channel that `GainSelector` selects. A setting names one of these values regardless of the current
selection: `Gain[GainSelector=Red]`. `FrameGrabber.read_setting` and `write_setting` select, read or write,
and restore the selection in one step. `core.settle` writes several settings.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import NamedTuple

from grabbergui.core.errors import UsageError
from grabbergui.core.features import (
    SWITCH_WORDS,
    Category,
    Feature,
    FeatureDescription,
    FeatureKind,
    FeatureValue,
    Representation,
    parse_coded,
)
from grabbergui.core.sfnc import Role, features_by_role

_NAME = r"[^\s\[\]=,]+"  # GenICam allows letters, digits and _; parameters of ROS nodes have dots too
_KEY = re.compile(rf"({_NAME})(?:\[([^\]]*)\])?")
_ASSIGNMENT = re.compile(r"([^=\[]+(?:\[[^\]]*\]\s*)?)=(.*)", re.DOTALL)

Selected = tuple[tuple[str, str], ...]
"Pairs of selector and entry, outermost selector first."
MOST_CHANGED = 5
"Most settings changed by others that a message names. Loading a user set may change all of them."
_TOLERANCE = 1e-6
"Relative tolerance, as other programs print seven digits of a float and a camera rounds to its register."


@dataclass(frozen=True)
class SettingKey:
    """The name of a setting: a feature, and the entries of its selectors."""

    name: str
    selected: Selected = ()
    "Empty for a feature without selectors, or for the current selection."

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
        """Read `Gain=3` or `Gain[GainSelector=Red]=3`; return None without a value. Raises UsageError."""
        match = _ASSIGNMENT.fullmatch(text)
        return (cls.parse(match[1].strip()), match[2]) if match is not None else None

    def __str__(self) -> str:
        """`Width`, `BalanceRatio[BalanceRatioSelector=Red]`."""
        if not self.selected:
            return self.name
        return f"{self.name}[{','.join(f'{selector}={entry}' for selector, entry in self.selected)}]"


class ValueChange(NamedTuple):
    """A setting with its values before and after a write; None for a value that could not be read."""

    key: SettingKey
    before: FeatureValue | None
    after: FeatureValue | None


@dataclass(frozen=True)
class WriteResult:
    """Everything that a write changed."""

    feature: Feature
    "The written feature as the camera reports it afterwards."
    written: tuple[ValueChange, ...]
    "Written values in order: companions that had to be switched, then the setting itself."
    consequences: tuple[ValueChange, ...] = ()
    "Settings that the camera changed because of the write (Height after BinningVertical)."
    also_changed: tuple[Feature, ...] = ()
    """The features of companions and consequences as the camera reports them afterwards.

    A caller need not read these again, but must read any that is missing.
    """


def return_text(problems: Sequence[str], changed: Sequence[str] = ()) -> str:
    """Describe the state of a source that returned: set as before, or which settings differ and why.

    `changed` are settings that were never set here and have another value now.
    """
    text = f"but not as before: {'; '.join(problems)}" if problems else "set as before"
    if not changed:
        return text
    more = f"; and {len(changed) - MOST_CHANGED} more" if len(changed) > MOST_CHANGED else ""
    return f"{text}; changed meanwhile, not by us: {'; '.join(changed[:MOST_CHANGED])}{more}"


@dataclass(frozen=True)
class Selectors:
    """The selectors of each feature in a camera's feature tree. Makes no request to the camera."""

    tree: Category
    descriptions: Mapping[str, FeatureDescription] = field(init=False)
    "Every feature of the tree by name, in the tree's order."
    names: frozenset[str] = field(init=False)
    "Every feature that selects another."
    roles: Mapping[Role, str] = field(init=False)
    "The features that have a role."

    def __post_init__(self) -> None:
        descriptions = {d.name: d for d in self.tree.descriptions()}
        object.__setattr__(self, "descriptions", descriptions)
        names = frozenset(selector for d in descriptions.values() for selector in d.selectors)
        object.__setattr__(self, "names", names)
        object.__setattr__(self, "roles", features_by_role(descriptions.values()))

    def of(self, name: str) -> tuple[str, ...]:
        """Return the selectors of a feature and their own selectors, outermost first, each once."""
        found: list[str] = []
        description = self.descriptions.get(name)
        for selector in description.selectors if description is not None else ():
            # Selectors may select each other in a circle, which must not be followed forever.
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
    """Return the features that are a camera's settings: the streamable ones, if it has any."""
    known = selectors.descriptions
    streamable = [name for name, d in known.items() if d.streamable and d.kind is not FeatureKind.COMMAND]
    if streamable:
        return streamable
    return [n for n, d in known.items() if d.kind is not FeatureKind.COMMAND and n not in selectors.names]


def same_value(first: FeatureValue, second: FeatureValue) -> bool:
    """Return whether two values mean the same, even if one is text from a file.

    A switch may be `no`, `off` or 0 there, and an integer `0x1F`, an IPv4 or a MAC address.
    """
    if str(first) == str(second):
        return True
    one, other = _number(first, words=True), _number(second, words=True)
    if one is None or other is None:
        return False
    if isinstance(one, int) and isinstance(other, int):
        return one == other
    try:
        return math.isclose(one, other, rel_tol=_TOLERANCE)
    except OverflowError:  # an integer beyond any float
        return False


def is_number(value: FeatureValue) -> bool:
    """Return whether a value is a number, or the text of one."""
    return _number(value) is not None


def _number(value: FeatureValue, *, words: bool = False) -> int | float | None:
    """Return a value, or the number that a text stands for; with `words` also that of a switch."""
    if isinstance(value, int | float):
        return int(value) if isinstance(value, bool) else value
    text = value.strip().lower()
    if words and text in SWITCH_WORDS:
        return int(SWITCH_WORDS[text])
    for representation in (Representation.IPV4_ADDRESS, Representation.MAC_ADDRESS):
        with suppress(ValueError):
            return parse_coded(text, representation)
    try:
        return float(text)
    except ValueError:
        return None
