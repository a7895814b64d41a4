"""The feature tree over a network: the client's requests, the server's answers, and its log of changes.

Features, categories and device infos travel as JSON, between two grabberguis on any network. Only fields that
differ from their default are written, and unknown ones are ignored, so that versions may differ. Reading
raises RemoteProtocolError for whatever is malformed.
"""

from __future__ import annotations

import json
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import MISSING, fields, is_dataclass, replace
from enum import Enum
from types import NoneType
from typing import Any, TypeVar, get_args, get_type_hints

from grabbergui.core import errors
from grabbergui.core.errors import FeatureError, GrabberError, RemoteProtocolError, UsageError
from grabbergui.core.features import (
    AccessMode,
    Category,
    EnumEntry,
    Feature,
    FeatureDescription,
    FeatureKind,
    FeatureValue,
    Representation,
    Visibility,
    format_value,
)
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.json_text import to_json
from grabbergui.core.settings import SettingKey, ValueChange, WriteResult

SELECTING_VERSION = 2
"From this version on a server takes selectors together with a name."
TIMEOUT = 7.0
"""Seconds for one request; a command may take five in the camera."""
IDLE = 10.0
"""Seconds without a request after which the log stops listening: the grabber may poll its camera for this
listener only."""
MEMORY = 256
"""Number of changes kept. A client that asks for older ones must assume that every feature changed."""
VERSION = 2
"From version 2 on, names may contain selectors, and `set` exists."
_ANY = -1
_REVISION_DIGITS = 20
"""More than any revision has; Python refuses to parse thousands of digits."""
Terminal = Callable[[str], str]
"""Runs a line of a remote terminal and returns the text to print. Raises GrabberError. Any thread."""
_ENUMS: dict[str, type[Enum]] = {
    "kind": FeatureKind,
    "visibility": Visibility,
    "access": AccessMode,
    "representation": Representation,
}
_MAX_DEPTH = 32
"""Categories within categories."""
_Built = TypeVar("_Built", Category, EnumEntry, Feature, FeatureDescription)


class TreeFeatures:
    """Features of a server that knows our verbs. One thread at a time.

    `ask` sends a verb with its arguments, and returns the result as plain data or raises the error that the
    server reported.
    """

    def __init__(self, ask: Callable[..., Any]) -> None:
        self._ask = ask
        self.tree: Category = read_category(self._ask("tree"))
        "The feature tree; requested from the server once."
        self._names = frozenset(description.name for description in self.tree.descriptions())
        self.lost = ""
        "Why the camera behind the server was lost at the last `look` or `changes`; empty if it was not."
        self.unlike_before: tuple[str, ...] = ()
        "After its return: the settings that differ from before, and why; as of the last `look`."
        self.changed_meanwhile: tuple[str, ...] = ()
        "After its return: other settings that changed meanwhile; as of the last `look`."
        self.missed = False
        "Whether the last `changes` is incomplete: the server restarted, or no longer knows what changed."
        self._revision = 0
        self._version: int | None = None
        "Version of the server's verbs; requested at its first use."

    def has(self, name: str) -> bool:
        """Return whether there is such a feature."""
        return name in self._names

    def read(self, name: str) -> Feature:
        """Return the feature as the server has it now."""
        return self.read_several([name])[0]

    def read_several(self, names: Sequence[str]) -> list[Feature]:
        """Return features as the server has them now, by one request. Each name may be given once."""
        found = self._ask("feature", *names)
        if not isinstance(found, list) or len(found) != len(names):
            raise RemoteProtocolError(f"the server did not describe {', '.join(names)}")
        return [read_feature(one) for one in found]

    def write(self, name: str, value: FeatureValue) -> Feature:
        """Write a feature; return it as the server reports it afterwards."""
        return read_feature(self._ask("write", name, format_value(value)))

    def execute(self, name: str) -> None:
        """Run a command."""
        self._ask("execute", name)

    @property
    def selects(self) -> bool:
        """Whether the server selects, reads or writes, and restores the selectors in one step."""
        if self._version is None:
            version = self.look().get("version")
            self._version = version if isinstance(version, int) else 1
        return self._version >= SELECTING_VERSION

    def look(self) -> dict[str, Any]:
        """Ask the server for its state and its camera's; store it here and return the answer."""
        answer = table_of(self._ask("hello"))
        self.lost = str(answer.get("lost", ""))
        self.unlike_before, self.changed_meanwhile = (
            tuple(map(str, _array(answer.get(name, [])))) for name in ("unlike_before", "changed_meanwhile")
        )
        return answer

    def write_setting(self, key: SettingKey, value: FeatureValue) -> WriteResult:
        """Write a setting under its selectors; return everything that changed. Requires `selects`."""
        return read_write_result(self._ask("set", str(key), format_value(value)))

    def changes(self) -> frozenset[str]:
        """Return the names of features that others changed since the last call."""
        answer = self._ask("changes", str(self._revision))
        if not isinstance(answer, dict):
            raise RemoteProtocolError("the server's list of changes is malformed")
        revision, names = answer.get("revision"), answer.get("names")
        if not isinstance(revision, int) or not isinstance(names, (list, type(None))):
            raise RemoteProtocolError("the server's list of changes is malformed")
        first, self._revision = not self._revision, revision
        self.lost = str(answer.get("lost", ""))
        self.missed = names is None and not first
        if names is None:
            return frozenset() if first else self._names
        return self._names.intersection(map(str, names))


class ChangeLog:
    """Numbers a grabber's changes. Thread-safe; has no thread of its own."""

    def __init__(self, grabber: FrameGrabber) -> None:
        self._grabber = grabber
        # Starting at the time of day shows clients that the server restarted.
        self._revision = time.time_ns() // 1_000_000
        self._changes: deque[tuple[int, frozenset[str]]] = deque(maxlen=MEMORY)
        self._asked = 0.0
        self._listening = False
        self._lock = threading.Lock()

    def since(self, revision: int) -> tuple[int, list[str] | None]:
        """Return the current revision and the features changed after `revision`, or None if unknown."""
        self._listen()
        with self._lock:
            oldest = self._changes[0][0] if self._changes else self._revision + 1
            if not oldest - 1 <= revision <= self._revision:
                return self._revision, None
            names = {name for number, changed in self._changes if number > revision for name in changed}
            return self._revision, sorted(names)

    def close(self) -> None:
        """Stop listening. May be called twice."""
        with self._lock:
            listening, self._listening = self._listening, False
        if listening:
            self._grabber.features_changed.disconnect(self._note)

    def _listen(self) -> None:
        with self._lock:
            self._asked = time.monotonic()
            if self._listening:
                return
            self._listening = True
            self._revision += 1
            self._changes.clear()
        # Not under our lock: the signal holds its own while it calls `_note`.
        self._grabber.features_changed.connect(self._note)

    def _note(self, names: frozenset[str]) -> None:
        with self._lock:
            if time.monotonic() - self._asked <= IDLE:
                self._revision += 1
                self._changes.append((self._revision, names))
                return
            # Under the same lock as the decision: a request from now on begins to listen again.
            listening, self._listening = self._listening, False
        if listening:
            self._grabber.features_changed.disconnect(self._note)


def no_terminal(line: str) -> str:
    """Stand in for a terminal that a server does not have. Raises UsageError."""
    raise UsageError(f"'{line}' was not run: no terminal is offered here")


class TreeService:
    """Answers verbs about one grabber. Any thread; each call may take as long as the camera."""

    def __init__(self, grabber: FrameGrabber, terminal: Terminal = no_terminal) -> None:
        self._grabber = grabber
        self._changes = ChangeLog(grabber)
        self._verbs: dict[str, tuple[int, Callable[..., object]]] = {
            "hello": (0, self._hello),
            "tree": (0, grabber.feature_tree),
            "feature": (_ANY, self._features),
            "write": (2, lambda name, value: self._write(name, value).feature),
            "set": (2, self._write),
            "execute": (1, lambda name: grabber.execute_setting(SettingKey.parse(name))),
            "changes": (1, self._changes_since),
            "terminal": (1, terminal),
        }
        # Verb: how many arguments, and what it does.

    def perform(self, verb: str, *arguments: str) -> object:
        """Execute a verb; the result is for `dumps`. Raises GrabberError."""
        if verb not in self._verbs:
            known = ", ".join(self._verbs)
            raise UsageError(f"'{verb}' is not a verb; use one of {known}")
        count, action = self._verbs[verb]
        if count not in (_ANY, len(arguments)):
            raise UsageError(f"wrong number of arguments of {verb}: {len(arguments)}, not {count}")
        return action(*arguments)

    def close(self) -> None:
        """Release the grabber. May be called twice."""
        self._changes.close()

    def _hello(self) -> dict[str, object]:
        grabber = self._grabber
        answer = {"version": VERSION, "info": grabber.info, "access": grabber.access}
        after_loss = {
            "unlike_before": grabber.unlike_before,
            "changed_meanwhile": grabber.changed_meanwhile,
        }
        return {**answer, **self._loss(), **after_loss}

    def _loss(self) -> dict[str, str]:
        """Return why the camera is lost, if it is. Clients would only see that no images arrive."""
        return {"lost": reason} if (reason := self._grabber.lost) else {}

    def _features(self, *names: str) -> list[Feature]:
        # Once each at most: a request of 64 KiB could name one feature ten thousand times.
        if len(names) != len(set(names)):
            raise UsageError("feature: a name is given twice, name each feature once")
        grabber = self._grabber
        return [grabber.offered(grabber.read_setting(SettingKey.parse(name))) for name in names]

    def _write(self, name: str, value: str) -> WriteResult:
        """Write a setting. Features locked only by the stream are reported as writable: a write pauses it."""
        result, offered = self._grabber.write_setting(SettingKey.parse(name), value), self._grabber.offered
        also_changed = tuple(map(offered, result.also_changed))
        return replace(result, feature=offered(result.feature), also_changed=also_changed)

    def _changes_since(self, revision: str) -> dict[str, object]:
        if not revision.isdecimal() or len(revision) > _REVISION_DIGITS:
            raise UsageError(f"revision '{revision[:40]}' is no whole number from 0 on")
        number, names = self._changes.since(int(revision))
        return {"revision": number, "names": names, **self._loss()}


def _plain_types(kind: type) -> dict[str, tuple[type, ...]]:
    """Return the types of those fields that JSON carries as they are."""
    types = {name: get_args(hint) or (hint,) for name, hint in get_type_hints(kind).items()}
    return {
        name: allowed for name, allowed in types.items() if {*allowed} <= {bool, int, float, str, NoneType}
    }


_PLAIN_TYPES = {kind: _plain_types(kind) for kind in (Category, EnumEntry, Feature, FeatureDescription)}


def dumps(result: object) -> str:
    """Encode plain data, features, categories, device infos or results of writes as JSON."""
    return to_json(result, default=_plain, compact=True)


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
    if feature.kind is FeatureKind.INTEGER:
        for number in (feature.value, feature.minimum, feature.maximum, feature.increment):
            if isinstance(number, float) and not number.is_integer():
                raise RemoteProtocolError(f"{feature.name} is an integer, but the reply has {number}")
    return feature


def read_write_result(data: object) -> WriteResult:
    """Return a WriteResult out of a reply. Raises RemoteProtocolError."""
    table = table_of(data)
    feature = read_feature(table.get("feature"))
    written, consequences = (
        tuple(map(_change, _array(table.get(name, [])))) for name in ("written", "consequences")
    )
    if not written:
        raise RemoteProtocolError(f"the reply does not contain what was written to {feature.name}")
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
    """Return an object made from the fields that we know; a newer peer may send more."""
    table = table_of(data)
    names = {field.name for field in fields(kind)}
    values = {key: value for key, value in table.items() if key in names}
    try:
        for key, plain in _PLAIN_TYPES[kind].items():
            if key in values and not isinstance(values[key], plain):
                raise ValueError(f"its {key} is a {type(values[key]).__name__}")
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
    if not isinstance(found, type) or not issubclass(found, GrabberError):
        return GrabberError(message)
    if issubclass(found, FeatureError):
        return found(message, feature)
    # Others need more than a message, such as a file's name, which is not transmitted.
    own = any("__init__" in vars(each) for each in found.__mro__ if issubclass(each, GrabberError))
    return GrabberError(message) if own else found(message)
