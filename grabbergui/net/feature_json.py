"""Features, categories and device infos as JSON: the messages between two grabberguis on any network.

Only fields that differ from their default are written, and unknown ones are ignored, so that versions may
differ. Reading raises RemoteProtocolError for whatever is malformed.
"""

from __future__ import annotations

import json
from dataclasses import MISSING, fields, is_dataclass
from enum import Enum
from types import NoneType
from typing import Any, TypeVar

from grabbergui.core import errors
from grabbergui.core.errors import FeatureError, GrabberError, RemoteProtocolError, UsageError
from grabbergui.core.features import (
    AccessMode,
    Category,
    EnumEntry,
    Feature,
    FeatureDescription,
    FeatureKind,
    Representation,
    Visibility,
)
from grabbergui.core.grabber import DeviceInfo
from grabbergui.core.selection import SettingKey, ValueChange, WriteResult

_ENUMS: dict[str, type[Enum]] = {
    "kind": FeatureKind,
    "visibility": Visibility,
    "access": AccessMode,
    "representation": Representation,
}
_MAX_DEPTH = 32
"""Categories within categories."""

_Built = TypeVar("_Built", Category, EnumEntry, Feature, FeatureDescription)


def dumps(result: object) -> str:
    """Encode plain data, or any of the dataclasses named above, as JSON."""
    return json.dumps(result, default=_plain, separators=(",", ":"))


def loads(text: str) -> Any:
    """Decode JSON to plain data."""
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as error:
        raise RemoteProtocolError(f"malformed JSON: {error}") from None


def read_info(data: object) -> DeviceInfo:
    """Return a DeviceInfo out of a reply. Raises RemoteProtocolError."""
    table = table_of(data)
    known = {field.name for field in fields(DeviceInfo)}
    return DeviceInfo(**{key: str(value) for key, value in {"uri": "", **table}.items() if key in known})


def read_feature(data: object) -> Feature:
    """Return a Feature out of a reply. Raises RemoteProtocolError."""
    table = table_of(data)
    entries = tuple(_built(EnumEntry, entry) for entry in _array(table.get("entries", [])))
    feature = _built(Feature, {**table, "entries": entries})
    if not isinstance(feature.value, (int, float, str, NoneType)):
        raise RemoteProtocolError(f"{feature.name} has a value that is a {type(feature.value).__name__}")
    return feature


def read_write_result(data: object) -> WriteResult:
    """Return a WriteResult out of a reply. Raises RemoteProtocolError."""
    table = table_of(data)
    feature = read_feature(table.get("feature"))
    written, consequences = (
        tuple(map(_change, _array(table.get(name, [])))) for name in ("written", "consequences")
    )
    if not written:
        raise RemoteProtocolError(f"nothing says what was written to {feature.name}")
    also_changed = tuple(map(read_feature, _array(table.get("also_changed", []))))
    return WriteResult(feature, written, consequences, also_changed)


def read_category(data: object, depth: int = 0) -> Category:
    """Return a Category with all below out of a reply. Raises RemoteProtocolError."""
    table = table_of(data)
    if depth > _MAX_DEPTH:
        raise RemoteProtocolError(f"categories are nested deeper than {_MAX_DEPTH}")
    members: list[Category | FeatureDescription] = []
    for member in map(table_of, _array(table.get("members", []))):
        is_feature = "kind" in member
        members.append(_built(FeatureDescription, member) if is_feature else read_category(member, depth + 1))
    return _built(Category, {**table, "members": tuple(members)})


def _plain(value: object) -> Any:
    """Return the fields of one of our dataclasses for JSON, without those at their default."""
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, SettingKey):
        return str(value)
    if is_dataclass(value):
        return {
            field.name: getattr(value, field.name)
            for field in fields(value)
            if field.default is MISSING or getattr(value, field.name) != field.default
        }
    raise TypeError(f"a {type(value).__name__} has no JSON")


def _built(kind: type[_Built], data: object) -> _Built:
    """Return an object of the fields we know; a newer peer may send more."""
    table = table_of(data)
    names = {field.name for field in fields(kind)}
    values = {key: value for key, value in table.items() if key in names}
    try:
        if not isinstance(values["name"], str):
            raise ValueError("its name is no text")
        for key in values.keys() & _ENUMS.keys():
            values[key] = _ENUMS[key](values[key])
        if "selectors" in values:
            values["selectors"] = tuple(map(str, values["selectors"]))
        return kind(**values)
    except (KeyError, TypeError, ValueError) as error:
        raise RemoteProtocolError(f"a malformed {kind.__name__}: {error}") from None


def _change(data: object) -> ValueChange:
    """Return a setting's text, its value before and after."""
    items = _array(data)
    if len(items) != 3 or not all(isinstance(value, (int, float, str, NoneType)) for value in items[1:]):
        raise RemoteProtocolError("a change that is not a setting and two values")
    try:
        return ValueChange(SettingKey.parse(str(items[0])), items[1], items[2])
    except UsageError as error:
        raise RemoteProtocolError(f"a change of no setting: {error}") from None


def table_of(data: object) -> dict[str, Any]:
    """Return a JSON object."""
    if not isinstance(data, dict):
        raise RemoteProtocolError(f"a {type(data).__name__} where an object is expected")
    return data


def _array(data: object) -> list[Any]:
    if not isinstance(data, list):
        raise RemoteProtocolError(f"a {type(data).__name__} where an array is expected")
    return data


def error_of(kind: str, message: str, feature: str) -> GrabberError:
    """Return the error that the other end named, to be raised here."""
    found = getattr(errors, kind, GrabberError)
    if (
        not isinstance(found, type)
        or not issubclass(found, GrabberError)
        or found is errors.DeviceStatusError
    ):
        found = GrabberError
    return found(message, feature) if issubclass(found, FeatureError) else found(message)
