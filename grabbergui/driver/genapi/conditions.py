"""Why a feature is hidden or locked: the features whose values do it, and the values that would not.

GenApi reports only that a feature is not available (`pIsAvailable`) or read-only (`pIsLocked`). The nodes
that it asks are formulas over registers of other features, which are followed here. To find better values,
the formulas are computed with values that those features could have; nothing is written.
"""

from __future__ import annotations

import itertools
import logging
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from genicam import genapi

from grabbergui.core.features import AccessCondition, AccessMode, FeatureDescription
from grabbergui.driver.genapi.formulas import value_of

log = logging.getLogger(__name__)

DEEPEST = 12
"Nodes between a feature and the one that hides it."
MOST_CONTROLS = 4
"More features than these in one formula are not explained."
MOST_TRIALS = 400
"Combinations of two features' values that are tried."
MOST_VALUES = 4
"Most values named for one feature."
_RULES = {AccessMode.NOT_AVAILABLE: "pIsAvailable", AccessMode.READ_ONLY: "pIsLocked"}


@dataclass(frozen=True, eq=False)
class _Control:
    """A feature on which a rule depends."""

    name: str
    register: str
    "The node that holds its number."
    choices: Mapping[int, str]
    "Values that it may be given, by number."


@dataclass(frozen=True)
class _Rule:
    """The node that hides or locks a feature, and the features on which that depends."""

    node: str
    controls: tuple[_Control, ...]


class Conditions:
    """Explains the features of one node map. The caller holds the map's lock."""

    def __init__(self, node_map: Any, descriptions: Mapping[str, FeatureDescription]) -> None:
        self._map = node_map
        self._descriptions = descriptions
        self._rules: dict[tuple[str, str], _Rule | None] = {}
        self._properties: dict[tuple[str, str], tuple[str, str] | None] = {}
        "Values and attributes of nodes' properties, each of which takes GenApi 2 ms."

    def of(self, name: str, access: AccessMode) -> tuple[AccessCondition, ...]:
        """Return what hides or locks the feature; empty if the description does not say. May read registers.

        A condition has the values to set if one or two features have to change; if there are no such values,
        all features are named on which it depends. The first call for a feature takes some milliseconds.
        """
        link = _RULES.get(access)
        try:
            return () if link is None else self._of(name, link)
        except (genapi.GenericException, RuntimeError) as error:
            log.info("what hides or locks %s: %s", name, error)
            return ()

    def _of(self, name: str, link: str) -> tuple[AccessCondition, ...]:
        key = name, link
        if key not in self._rules:
            self._rules[key] = self._find_rule(name, link)
        rule = self._rules[key]
        if rule is None or not rule.controls:
            return ()
        wanted = link == "pIsAvailable"
        try:
            if self._holds(rule, {}) is wanted:
                return ()  # something else is the reason
            return self._remedy(rule, wanted) or tuple(self._condition(each) for each in rule.controls)
        except ValueError:  # a formula that is not computed here
            return tuple(self._condition(control) for control in rule.controls)

    def _find_rule(self, name: str, link: str) -> _Rule | None:
        """Return the rule of a feature, or of the node that holds its value."""
        for _ in range(DEEPEST):
            if not self._map.has_node(name):
                return None
            node = self._map.get_node(name).node
            if targets := self._linked(node, link):
                controls = {each.name: each for each in self._controls(targets[0], DEEPEST)}
                few = len(controls) <= MOST_CONTROLS
                return _Rule(targets[0], tuple(controls.values()) if few else ())
            if not (targets := self._linked(node, "pValue")):
                return None
            name = targets[0]
        return None

    def _controls(self, name: str, depth: int) -> Iterator[_Control]:
        """Yield the features whose numbers a node is computed from."""
        if depth == 0 or not self._map.has_node(name):
            return
        value = self._map.get_node(name)
        if name in self._descriptions and self._property(value.node, "Formula") is None:
            yield self._control(name, value)
            return
        inner = self._linked(value.node, "pVariable") or self._linked(value.node, "pValue")
        for each in inner:
            yield from self._controls(each, depth - 1)
        if not inner:
            for parent in value.node.parents:
                parent_name = parent.node.name
                if parent_name in self._descriptions and self._linked(parent.node, "pValue") == [name]:
                    yield self._control(parent_name, parent)
                    return

    def _control(self, name: str, value: Any) -> _Control:
        held = self._linked(value.node, "pValue")
        return _Control(name, held[0] if len(held) == 1 else name, _choices(value))

    def _remedy(self, rule: _Rule, wanted: bool) -> tuple[AccessCondition, ...]:
        """Return the fewest features to change, with values."""
        now = {control: self._number(control.name, {}) for control in rule.controls}
        for control in rule.controls:
            good = [
                text
                for number, text in control.choices.items()
                if number != now[control] and self._holds(rule, _given((control, number))) is wanted
            ]
            if good:
                return (self._condition(control, good[:MOST_VALUES]),)
        for first, second in itertools.combinations(rule.controls, 2):
            pairs = itertools.product(first.choices.items(), second.choices.items())
            for (one, one_text), (other, other_text) in itertools.islice(pairs, MOST_TRIALS):
                if self._holds(rule, _given((first, one), (second, other))) is wanted:
                    return self._condition(first, [one_text]), self._condition(second, [other_text])
        return ()

    def _condition(self, control: _Control, wanted: list[str] | None = None) -> AccessCondition:
        number = self._number(control.name, {})
        return AccessCondition(control.name, control.choices.get(number, str(number)), tuple(wanted or ()))

    def _holds(self, rule: _Rule, given: Mapping[str, int]) -> bool:
        return self._number(rule.node, given) != 0

    def _number(self, name: str, given: Mapping[str, int], depth: int = DEEPEST) -> int:
        """Return the number of a node if the nodes in `given` had these numbers. Raises ValueError."""
        if name in given:
            return given[name]
        if depth == 0:
            raise ValueError("too deep")
        value = self._map.get_node(name)
        node = value.node
        if given and (formula := self._property(node, "Formula")) is not None:
            names, symbols = self._property(node, "pVariable") or ("", "")
            numbers = [self._number(each, given, depth - 1) for each in names.split("\t") if each]
            return value_of(formula[0], dict(zip(symbols.split("\t"), numbers, strict=False)))
        if given and (held := self._linked(node, "pValue")):
            return self._number(held[0], given, depth - 1)
        if isinstance(value, genapi.IEnumeration):
            return int(value.get_int_value())
        if isinstance(value, (genapi.IInteger, genapi.IBoolean)):
            return int(value.value)
        raise ValueError(f"{name} has no number")

    def _linked(self, node: Any, name: str) -> list[str]:
        """Return the names of the nodes to which a property of a node refers."""
        found = self._property(node, name)
        return [] if found is None else found[0].split("\t")

    def _property(self, node: Any, name: str) -> tuple[str, str] | None:
        """Return the values of a property and their attributes, each joined by tabs; None if it has none."""
        key = node.name, name
        if key not in self._properties:
            has = name in node.property_names
            values, attributes = node.get_property(name) if has else ("", "")
            self._properties[key] = (str(values), str(attributes)) if has else None
        return self._properties[key]


def _given(*chosen: tuple[_Control, int]) -> dict[str, int]:
    return {name: number for control, number in chosen for name in (control.name, control.register)}


def _choices(value: Any) -> dict[int, str]:
    """Return the values that a feature can have, by number; empty for one with many or none."""
    if isinstance(value, genapi.IEnumeration):
        return {
            int(entry.value): str(entry.symbolic)
            for entry in value.entries
            if entry.get_access_mode() in (genapi.EAccessMode.RO, genapi.EAccessMode.RW)
        }
    if isinstance(value, genapi.IBoolean):
        return {0: "false", 1: "true"}
    if isinstance(value, genapi.IInteger) and int(value.min) >= 0 and int(value.max) <= 1:
        return {0: "0", 1: "1"}
    return {}
