"""The whole GenICam tree over a frame grabber's RPC port: a vocabulary of our own beside YARP's.

A request is a Bottle of strings, ``genicam VERB ARGUMENT…``; the reply is ``genicam ok JSON`` or
``genicam error KIND MESSAGE FEATURE``. Other servers answer the word they do not know with ``[nak]`` (3.x)
or ``[fail]`` (4.0), so asking costs nothing, and people can use it too: ``genicam write Gain 5`` typed into
``yarp rpc``.

=====================  ==============================================  =====================================
request                result                                          errors
=====================  ==============================================  =====================================
hello                  version, device info, access
tree                   categories with the features' descriptions
feature NAME…          the features as they are now, in order           FeatureNotFoundError
write NAME VALUE       the feature as it is after                       any FeatureError
execute NAME           null                                            any FeatureError
changes REVISION       revision, and the names changed since            (names null: anything may have)
=====================  ==============================================  =====================================
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import MISSING, fields, is_dataclass
from enum import Enum
from types import NoneType
from typing import Any, TypeVar

from grabbergui.core import errors
from grabbergui.core.errors import FeatureError, GrabberError, RemoteProtocolError
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
from grabbergui.net.yarp.bottle import Bottle
from grabbergui.net.yarp.values import Item, word

WORD = "genicam"
VERSION = 1

_ENUMS: dict[str, type[Enum]] = {
    "kind": FeatureKind,
    "visibility": Visibility,
    "access": AccessMode,
    "representation": Representation,
}
_MAX_DEPTH = 32
"""Categories within categories."""

_Built = TypeVar("_Built", Category, EnumEntry, Feature, FeatureDescription)


def request(verb: str, *arguments: str) -> Bottle:
    """The message that asks for `verb`."""
    return Bottle([WORD, verb, *arguments])


def is_request(message: Sequence[Item]) -> bool:
    """Whether a message is in this vocabulary."""
    return bool(message) and word(message[0]) == WORD


def success(result: object) -> Bottle:
    """The reply that carries a result: plain data, or any of the dataclasses named above."""
    return Bottle([WORD, "ok", json.dumps(result, default=_plain, separators=(",", ":"))])


def failure(error: GrabberError) -> Bottle:
    """The reply that carries an error; the other end raises it again."""
    return Bottle([WORD, "error", type(error).__name__, str(error), getattr(error, "feature", "")])


def read_reply(reply: Sequence[Item]) -> Any:
    """The plain data of a reply.

    Raises the error that the other end reported, RemoteProtocolError for what is no reply of this
    vocabulary.
    """
    texts = [item for item in reply if isinstance(item, str)]
    if len(texts) != len(reply) or texts[:1] != [WORD] or len(texts) < 3:
        raise RemoteProtocolError(f"'{WORD}' was answered with something else")
    if texts[1] == "ok":
        try:
            return json.loads(texts[2])
        except (ValueError, RecursionError) as error:
            raise RemoteProtocolError(f"'{WORD}' was answered with malformed JSON: {error}") from None
    raise _error(texts[2], texts[3] if len(texts) > 3 else "", texts[4] if len(texts) > 4 else "")


def understood(reply: Sequence[Item]) -> bool:
    """Whether the other end knows this vocabulary at all."""
    return len(reply) > 1 and reply[0] == WORD


def read_hello(reply: Sequence[Item]) -> DeviceInfo:
    """The camera behind a server that answered `hello`. Raises as `read_reply`."""
    return read_info(_table(read_reply(reply)).get("info"))


def read_info(data: object) -> DeviceInfo:
    """A DeviceInfo out of a reply. Raises RemoteProtocolError."""
    table = _table(data)
    known = {field.name for field in fields(DeviceInfo)}
    return DeviceInfo(**{key: str(value) for key, value in {"uri": "", **table}.items() if key in known})


def read_feature(data: object) -> Feature:
    """A Feature out of a reply. Raises RemoteProtocolError."""
    table = _table(data)
    entries = tuple(_built(EnumEntry, entry) for entry in _array(table.get("entries", [])))
    feature = _built(Feature, {**table, "entries": entries})
    if not isinstance(feature.value, (int, float, str, NoneType)):
        raise RemoteProtocolError(f"{feature.name} has a value that is a {type(feature.value).__name__}")
    return feature


def read_category(data: object, depth: int = 0) -> Category:
    """A Category with all below out of a reply. Raises RemoteProtocolError."""
    table = _table(data)
    if depth > _MAX_DEPTH:
        raise RemoteProtocolError(f"categories are nested deeper than {_MAX_DEPTH}")
    members: list[Category | FeatureDescription] = []
    for member in map(_table, _array(table.get("members", []))):
        is_feature = "kind" in member
        members.append(_built(FeatureDescription, member) if is_feature else read_category(member, depth + 1))
    return _built(Category, {**table, "members": tuple(members)})


def _plain(value: object) -> Any:
    """What JSON writes for one of our dataclasses: its fields, without those at their default."""
    if isinstance(value, Enum):
        return value.value
    if is_dataclass(value):
        return {
            field.name: getattr(value, field.name)
            for field in fields(value)
            if field.default is MISSING or getattr(value, field.name) != field.default
        }
    raise TypeError(f"a {type(value).__name__} has no JSON")


def _built(kind: type[_Built], data: object) -> _Built:
    """An object of the fields we know; a newer peer may send more."""
    table = _table(data)
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


def _table(data: object) -> dict[str, Any]:
    if not isinstance(data, dict):
        raise RemoteProtocolError(f"a {type(data).__name__} where an object is expected")
    return data


def _array(data: object) -> list[Any]:
    if not isinstance(data, list):
        raise RemoteProtocolError(f"a {type(data).__name__} where an array is expected")
    return data


def _error(kind: str, message: str, feature: str) -> GrabberError:
    found = getattr(errors, kind, GrabberError)
    if (
        not isinstance(found, type)
        or not issubclass(found, GrabberError)
        or found is errors.DeviceStatusError
    ):
        found = GrabberError
    return found(message, feature) if issubclass(found, FeatureError) else found(message)
