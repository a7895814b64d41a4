"""Features of other camera drivers: their node's parameters, with the ranges they declare."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

from grabbergui.core.errors import FeatureNotFoundError, FeatureValueError, RemoteProtocolError
from grabbergui.core.features import (
    AccessMode,
    Category,
    EnumEntry,
    Feature,
    FeatureDescription,
    FeatureKind,
    FeatureValue,
)
from grabbergui.net.ros2.array_text import ARRAYS, message_of_text, text_of
from grabbergui.net.ros2.parameter_values import BOOL, DOUBLE, INTEGER, STRING, message_of, value_of

_KINDS = {
    BOOL: FeatureKind.BOOLEAN,
    INTEGER: FeatureKind.INTEGER,
    DOUBLE: FeatureKind.FLOAT,
    STRING: FeatureKind.STRING,
    **dict.fromkeys(ARRAYS, FeatureKind.STRING),
}
"""Arrays are edited as text."""
_NOT_OF_THE_CAMERA = re.compile(r"qos_overrides\..*|use_sim_time|start_type_description_service")
"""Parameters that ROS adds to every node."""
_CHOICES = re.compile(
    r"(?:one of|(?:valid|allowed|possible|available|supported) (?:values|options|choices)(?: are)?|choices)"
    r"\s*:?\s*(?:[\[{(](?P<in_brackets>[^\])}]*)[\])}]|(?P<to_the_end>[^.;\n]*))",
    re.IGNORECASE,
)
"""Choices in a description, as ROS has no field for them: `one of [off, auto]`, `Valid values: 1, 2, 4`."""
_MENU_ENTRY = re.compile(
    r"(?<![\w.])(?P<number>[-+]?\d+)\s*[:=]\s*(?P<label>[^,;|()\[\]{}\n]*?)(?=[,;|()\[\]{}\n]|\.(?:\s|$)|$)"
)
"""An entry of an integer's menu as V4L2 and other drivers write it: `0: Disabled, 1: 50 Hz`."""
_BETWEEN_CHOICES = re.compile(r",\s*(?:or\s)?|\||\sor\s")
_AROUND = " \t\r\n\"'`"
"""Characters around a choice that do not belong to it."""
_MOST_CHOICES = 64
_LETTER = re.compile(r"[^\W\d_]")
_FROM_WORD: dict[int, Callable[[str], FeatureValue]] = {STRING: str, INTEGER: int, DOUBLE: float}
"""Spellings of values, by the parameter's type."""

Call = Callable[[str, Any], Any]
"""Calls a service of the node by its name with a request, and gives the response or raises."""


class NoFeatures:
    """The empty feature set of a node without parameters."""

    tree = Category("Root")

    def has(self, name: str) -> bool:
        """Return whether there is such a parameter: no."""
        return False

    def read(self, name: str) -> Feature:
        """There is nothing to read."""
        raise FeatureNotFoundError(f"there is no {name}: this node offers no parameters", name)

    def write(self, name: str, value: FeatureValue) -> Feature:
        """There is nothing to set."""
        return self.read(name)

    def execute(self, name: str) -> None:
        """There is nothing to run."""
        self.read(name)


class ParameterFeatures:
    """A remote node's parameters as features. One thread at a time; any may call `has` and `doubt`."""

    def __init__(self, call: Call) -> None:
        from rcl_interfaces import srv

        self._srv = srv
        self._call = call
        self._doubted: frozenset[str] = frozenset()
        names = list(call("list_parameters", srv.ListParameters.Request()).result.names)
        self._kinds: dict[str, FeatureKind] = {}
        self._choices: dict[str, dict[str, FeatureValue]] = {}
        "For each parameter with a list of values: names of entries to the values that are sent."
        self._descriptors = {
            descriptor.name: descriptor
            for descriptor in self._describe(names)
            if descriptor.type in _KINDS and not _NOT_OF_THE_CAMERA.fullmatch(descriptor.name)
        }
        values = dict(zip(self._descriptors, self._values(list(self._descriptors)), strict=False))
        for name, descriptor in self._descriptors.items():
            found = choices(descriptor)
            if values.get(name) in found.values():
                self._choices[name] = found
            self._kinds[name] = FeatureKind.ENUMERATION if name in self._choices else _KINDS[descriptor.type]
        self.tree = _tree([self._description(name) for name in self._descriptors])

    def has(self, name: str) -> bool:
        """Return whether there is such a parameter."""
        return name in self._descriptors

    def doubt(self, names: frozenset[str]) -> None:
        """Request the descriptors of these again at their next read: their ranges may have changed."""
        self._doubted |= names

    def read(self, name: str) -> Feature:
        """Return the parameter as it is now."""
        if name in self._doubted:
            self._doubted -= {name}
            self._describe_again(name)
        descriptor = self._descriptors[name]
        values = self._values([name])
        value = values[0] if values else None
        listed = self._choices.get(name, {})
        if listed and value is not None:
            value = next((entry for entry, sent in listed.items() if sent == value), str(value))
        access = AccessMode.READ_ONLY if descriptor.read_only else AccessMode.READ_WRITE
        low, high, step = _range(descriptor)
        return Feature(
            **vars(self._description(name)),
            access=AccessMode.NOT_AVAILABLE if value is None else access,
            constant=descriptor.read_only,
            value=value,
            minimum=low,
            maximum=high,
            increment=step or None,
            entries=tuple(map(EnumEntry, listed)),
        )

    def write(self, name: str, value: FeatureValue) -> Feature:
        """Set it; raises FeatureValueError with the node's reason where it refuses."""
        from rcl_interfaces.msg import Parameter

        message = self._message(name, self.read(name).validated(value))
        request = self._srv.SetParameters.Request(parameters=[Parameter(name=name, value=message)])
        results = self._call("set_parameters", request).results
        if not results:
            raise RemoteProtocolError(f"{name}={value}: the node did not answer whether it was set")
        if not results[0].successful:
            raise FeatureValueError(f"{name}={value}: the node answered: {results[0].reason}", name)
        return self.read(name)

    def execute(self, name: str) -> None:
        """Parameters cannot be executed."""
        raise FeatureValueError(f"{name} is a parameter and no command", name)

    def _message(self, name: str, value: FeatureValue) -> Any:
        given = self._descriptors[name].type
        if given in ARRAYS:
            return message_of_text(name, given, str(value))
        return message_of(_KINDS[given], self._choices.get(name, {}).get(str(value), value))

    def _describe(self, names: list[str]) -> list[Any]:
        if not names:
            return []
        answer = self._call("describe_parameters", self._srv.DescribeParameters.Request(names=names))
        return list(answer.descriptors)

    def _describe_again(self, name: str) -> None:
        """Replace the descriptor. A parameter may change its type if its node declared it so."""
        for descriptor in self._describe([name]):
            if descriptor.type not in _KINDS:
                continue  # it is not set at the moment
            if descriptor.type != self._descriptors[name].type:
                self._choices.pop(name, None)
                self._kinds[name] = _KINDS[descriptor.type]
            self._descriptors[name] = descriptor

    def _values(self, names: list[str]) -> list[FeatureValue | None]:
        answer = self._call("get_parameters", self._srv.GetParameters.Request(names=names))
        return [
            text_of(message) if message.type in ARRAYS else value_of(message) for message in answer.values
        ]

    def _description(self, name: str) -> FeatureDescription:
        return FeatureDescription(
            name=name,
            kind=self._kinds[name],
            tooltip=self._descriptors[name].description,
            category=name.rpartition(".")[0] or "Parameters",
        )


def choices(descriptor: Any) -> dict[str, FeatureValue]:
    """Return the values that a descriptor's words list as all there is to choose from, by their names.

    Empty where they list nothing, or something that the parameter's type cannot be.
    """
    for text in (descriptor.additional_constraints, descriptor.description):
        found = _menu(text[:4096]) if descriptor.type == INTEGER else {}
        found = found or _list(text[:4096], _FROM_WORD.get(descriptor.type))
        if 2 <= len(found) <= _MOST_CHOICES:
            return found
    return {}


def _menu(text: str) -> dict[str, FeatureValue]:
    """Parse `0: Disabled, 1: 50 Hz`; a label has a letter, unlike a ratio or a time of day."""
    entries = [(match["label"].strip(_AROUND), int(match["number"])) for match in _MENU_ENTRY.finditer(text)]
    labels, numbers = {label for label, _ in entries}, {number for _, number in entries}
    sound = len(labels) == len(numbers) == len(entries)
    return dict(entries) if sound and all(map(_LETTER.search, labels)) else {}


def _list(text: str, from_word: Callable[[str], FeatureValue] | None) -> dict[str, FeatureValue]:
    """Parse `one of [off, auto]`, `Valid values: 50, 60`."""
    match = _CHOICES.search(text)
    if not match or from_word is None:
        return {}
    listed = match["in_brackets"] if match["in_brackets"] is not None else match["to_the_end"]
    words = [part.strip(_AROUND) for part in _BETWEEN_CHOICES.split(listed.strip())]
    try:
        return {word: from_word(word) for word in words} if all(words) else {}
    except ValueError:
        return {}


def _tree(descriptions: list[FeatureDescription]) -> Category:
    """Return the parameters in categories given by the dots in their names."""
    branches: dict[str, list[FeatureDescription]] = {}
    for description in descriptions:
        branches.setdefault(description.category, []).append(description)
    return Category("Root", members=tuple(Category(name, members=tuple(m)) for name, m in branches.items()))


def _range(descriptor: Any) -> tuple[Any, Any, Any]:
    for found in (*descriptor.integer_range, *descriptor.floating_point_range):
        return found.from_value, found.to_value, found.step
    if descriptor.type == INTEGER:
        return -(2**63), 2**63 - 1, 1
    return None, None, None
