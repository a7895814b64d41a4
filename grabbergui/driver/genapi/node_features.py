"""Converts GenApi nodes to features and back.

An error in one node must not affect the others: it becomes the feature's `problem`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

from genicam import genapi

from grabbergui.core.device_text import text_of
from grabbergui.core.errors import RemoteProtocolError
from grabbergui.core.features import (
    AccessMode,
    EnumEntry,
    Feature,
    FeatureDescription,
    FeatureKind,
    FeatureValue,
    Representation,
    Visibility,
)
from grabbergui.core.sfnc import role_of
from grabbergui.driver.genapi.register_length import LONGEST_TEXT, require_length

_KINDS = {
    genapi.EInterfaceType.intfIInteger: FeatureKind.INTEGER,
    genapi.EInterfaceType.intfIFloat: FeatureKind.FLOAT,
    genapi.EInterfaceType.intfIBoolean: FeatureKind.BOOLEAN,
    genapi.EInterfaceType.intfIEnumeration: FeatureKind.ENUMERATION,
    genapi.EInterfaceType.intfICommand: FeatureKind.COMMAND,
    genapi.EInterfaceType.intfIString: FeatureKind.STRING,
}

_ACCESS = {
    genapi.EAccessMode.NI: AccessMode.NOT_IMPLEMENTED,
    genapi.EAccessMode.NA: AccessMode.NOT_AVAILABLE,
    genapi.EAccessMode.WO: AccessMode.WRITE_ONLY,
    genapi.EAccessMode.RO: AccessMode.READ_ONLY,
    genapi.EAccessMode.RW: AccessMode.READ_WRITE,
}
_READABLE = (genapi.EAccessMode.RO, genapi.EAccessMode.RW)

READ_ERRORS = (genapi.GenericException, RuntimeError, ValueError, OverflowError, RemoteProtocolError)
"""Exceptions of C++, of our port, of Python for a huge number, and of `require_length`.

Each makes only its own node unusable.
"""

_REPRESENTATIONS = {
    genapi.ERepresentation.Linear: Representation.LINEAR,
    genapi.ERepresentation.Logarithmic: Representation.LOGARITHMIC,
    genapi.ERepresentation.Boolean: Representation.BOOLEAN,
    genapi.ERepresentation.PureNumber: Representation.PURE_NUMBER,
    genapi.ERepresentation.HexNumber: Representation.HEX_NUMBER,
    genapi.ERepresentation.IPV4Address: Representation.IPV4_ADDRESS,
    genapi.ERepresentation.MACAddress: Representation.MAC_ADDRESS,
}

_INT64_MAX = 2**63 - 1
_LARGEST_FLOAT = 3.4028234663852886e38
"""The largest 32-bit float. Limits beyond it mean none: without limits GenApi reports ±1.8e308."""

_WHERE_THROWN = re.compile(r"\s*: \w+Exception thrown\b.*", re.DOTALL)
_ALARM = re.compile(r"(?:(?:Fatal error|ERROR|WARNING) ?:|SWIG director method error\.)\s*")
"""Parts of GenApi's messages after and before the reason."""
_NO_LIMITS: dict[str, Any] = {}


def is_category(value: Any) -> bool:
    """Whether a node is a category of the feature tree."""
    return bool(value.node.principal_interface_type == genapi.EInterfaceType.intfICategory)


def describe(node: Any, category: str) -> FeatureDescription | None:
    """Return the constant properties of a node; None for raw registers and ports."""
    kind = _KINDS.get(node.principal_interface_type)
    if kind is None:
        return None
    return FeatureDescription(
        name=node.name,
        kind=kind,
        display_name=node.display_name,
        tooltip=node.tooltip,
        description=node.description,
        visibility=visibility_of(node),
        category=category,
        streamable=node.is_streamable(),
        selectors=tuple(selector.node.name for selector in node.selecting_features),
    )


def visibility_of(node: Any) -> Visibility:
    """Return a node's visibility."""
    return Visibility(min(max(int(node.visibility), 0), 3))


def access_of(value: Any) -> AccessMode:
    """Return a node's current access mode. May read registers."""
    return _ACCESS.get(value.get_access_mode(), AccessMode.NOT_AVAILABLE)


class NodeFeature:
    """A node as a feature. Constant properties are read once. One thread at a time."""

    def __init__(self, value: Any, description: FeatureDescription, auto: str | None) -> None:
        self._value = value
        self._kind = description.kind
        self._known = {**vars(description), "auto": auto, "access": AccessMode.NOT_AVAILABLE}
        self._read = READERS.get(description.kind)
        "None for a command."
        self._read_limits = _LIMIT_READERS[description.kind]
        self._fixed: dict[str, Any] | None = None
        self._entries: list[tuple[Any, EnumEntry]] | None = None
        self.last: Feature | None = None
        "The last snapshot, which may be out of date."

    def snapshot(self) -> Feature:
        """Return the node's current state; may read registers. Never raises GenApi's errors."""
        self.last = self._snapshot()
        return self.last

    def _snapshot(self) -> Feature:
        known = self._known.copy()
        try:
            known["access"] = access = access_of(self._value)
            if access in (AccessMode.NOT_IMPLEMENTED, AccessMode.NOT_AVAILABLE):
                return Feature(**known)
            if self._kind is FeatureKind.ENUMERATION:
                known["entries"] = tuple(self._available_entries())
            else:
                known.update(self._read_limits(self._value))
                known.update(self._fixed_parts())
            if access.readable and self._read is not None:
                known["value"] = self._current_value(self._read, access)
            return Feature(**known)
        except READ_ERRORS as error:
            return Feature(**{**known, "access": AccessMode.NOT_AVAILABLE, "problem": reason_of(error)})

    def value(self) -> FeatureValue | None:
        """Return the node's value; None if it cannot be read. Never raises GenApi's errors."""
        try:
            if self._read is None or self._value.get_access_mode() not in _READABLE:
                return None
            return self._read(self._value)
        except READ_ERRORS:
            return None

    def _current_value(self, read: Callable[[Any], FeatureValue], access: AccessMode) -> FeatureValue | None:
        """Return the value; None if it is invalid but can be overwritten.

        An invalid value is, for example, a Boolean that is neither on nor off.
        Errors of our port pass through: they are not a GenericException.
        """
        try:
            return read(self._value)
        except genapi.GenericException:
            if access.writable:
                return None
            raise

    def assign(self, new: FeatureValue) -> None:
        """Write a validated value. Raises GenApi's exceptions."""
        if self._kind is FeatureKind.STRING:
            _require_text_length(self._value)
        if self._kind is FeatureKind.ENUMERATION:
            self._value.from_string(str(new))
        else:
            self._value.set_value(new)

    def _fixed_parts(self) -> dict[str, Any]:
        if self._fixed is None:
            self._fixed = {}
            if self._kind in (FeatureKind.INTEGER, FeatureKind.FLOAT):
                representation = _REPRESENTATIONS.get(self._value.representation, Representation.LINEAR)
                of_quantity = self._kind is FeatureKind.FLOAT or role_of(self._known["name"]) is not None
                if of_quantity and representation is Representation.PURE_NUMBER:
                    # GenApi reports it also if the description has none; a quantity gets a slider.
                    representation = Representation.LINEAR
                self._fixed = {"unit": self._value.unit, "representation": representation}
        return self._fixed

    def _available_entries(self) -> Iterator[EnumEntry]:
        if self._entries is None:
            self._entries = [(entry, _entry(entry)) for entry in self._value.entries]
        for node, entry in self._entries:
            access = access_of(node)
            if access is AccessMode.NOT_AVAILABLE:
                yield replace(entry, available=False)
            elif access is not AccessMode.NOT_IMPLEMENTED:
                yield entry


def reason_of(error: BaseException) -> str:
    """Return GenApi's message without its position in GenApi's sources."""
    text = _WHERE_THROWN.sub("", _ALARM.sub("", str(error), count=1))
    return " ".join(text.replace(" : ", ": ").split()).rstrip(".")


def _require_text_length(value: Any) -> None:
    if (length := int(value.max_length)) != _INT64_MAX:  # else the text is in no register
        require_length(length, "its text", LONGEST_TEXT)


def _entry_name(value: Any) -> str:
    """Return the symbol of the current entry, or the camera's number if no entry has it."""
    try:
        return str(value.to_string())
    except genapi.InvalidArgumentException:
        return str(int(value.get_int_value()))


def _text(value: Any) -> str:
    _require_text_length(value)
    try:
        return str(value.value)
    except UnicodeDecodeError as error:
        return text_of(error.object)


READERS: dict[FeatureKind, Callable[[Any], FeatureValue]] = {
    FeatureKind.INTEGER: lambda value: int(value()),
    FeatureKind.FLOAT: lambda value: float(value()),
    FeatureKind.BOOLEAN: lambda value: bool(value()),
    FeatureKind.ENUMERATION: lambda value: _entry_name(value),
    FeatureKind.STRING: lambda value: _text(value),
}
"""Functions that read a node's value, by kind; a command has none. They raise GenApi's exceptions.

Calling a number's node is the fastest way to its `value`.
"""


def _limits(low: int | float, high: int | float) -> dict[str, Any]:
    """Return the limits that restrict the value: those that are finite numbers."""
    limits = {"minimum": low, "maximum": high}
    return {name: limit for name, limit in limits.items() if abs(limit) < _LARGEST_FLOAT}


def _increment(increment: int | float) -> int | float | None:
    return increment if increment > 0 else None


def _integer(value: Any) -> dict[str, Any]:
    return {**_limits(int(value.min), int(value.max)), "increment": _increment(int(value.inc))}


def _float(value: Any) -> dict[str, Any]:
    limits = _limits(float(value.min), float(value.max))
    return {**limits, "increment": _increment(float(value.inc))} if value.has_inc() else limits


def _string(value: Any) -> dict[str, Any]:
    length = int(value.max_length)
    return {"maximum_length": length if 0 < length < _INT64_MAX else None}


def _entry(value: Any) -> EnumEntry:
    node = value.node
    # Without a display name GenApi returns the node's name, such as EnumEntry_PixelFormat_Mono8.
    display = "" if node.display_name == node.name else node.display_name
    return EnumEntry(value.symbolic, display, node.tooltip)


_LIMIT_READERS: dict[FeatureKind, Callable[[Any], dict[str, Any]]] = {
    FeatureKind.INTEGER: _integer,
    FeatureKind.FLOAT: _float,
    FeatureKind.BOOLEAN: lambda value: _NO_LIMITS,
    FeatureKind.ENUMERATION: lambda value: _NO_LIMITS,
    FeatureKind.COMMAND: lambda value: _NO_LIMITS,
    FeatureKind.STRING: _string,
}
