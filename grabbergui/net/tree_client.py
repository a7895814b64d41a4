"""The features of a remote grabber that speaks the verbs of `net.tree_service`: the whole GenICam tree."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from grabbergui.core.errors import RemoteProtocolError
from grabbergui.core.features import Category, Feature, FeatureValue, format_value
from grabbergui.core.selection import SettingKey, WriteResult
from grabbergui.net.feature_json import read_category, read_feature, read_write_result, table_of

SELECTING_VERSION = 2
"From this version on a server takes selectors together with a name."
TIMEOUT = 7.0
"""Seconds for one request; a command may take five in the camera."""


class TreeFeatures:
    """Features of a server that knows our verbs. One thread at a time.

    `ask` carries a verb and its arguments over, and gives the result as plain data or raises what the server
    reported.
    """

    def __init__(self, ask: Callable[..., Any]) -> None:
        self._ask = ask
        self.tree: Category = read_category(self._ask("tree"))
        "What there is; asked of the server once."
        self._names = frozenset(description.name for description in self.tree.descriptions())
        self._revision = 0
        self._version: int | None = None
        "Of the server's verbs; asked for when it matters first."

    def has(self, name: str) -> bool:
        """Whether there is such a feature."""
        return name in self._names

    def read(self, name: str) -> Feature:
        """The feature as the server has it now."""
        found = self._ask("feature", name)
        if not isinstance(found, list) or len(found) != 1:
            raise RemoteProtocolError(f"the server did not describe {name}")
        return read_feature(found[0])

    def write(self, name: str, value: FeatureValue) -> Feature:
        """Set it; the server says what it is then."""
        return read_feature(self._ask("write", name, format_value(value)))

    def execute(self, name: str) -> None:
        """Run a command."""
        self._ask("execute", name)

    @property
    def selects(self) -> bool:
        """Whether the server selects, reads or writes, and selects back in one step."""
        if self._version is None:
            version = table_of(self._ask("hello")).get("version")
            self._version = version if isinstance(version, int) else 1
        return self._version >= SELECTING_VERSION

    def write_setting(self, key: SettingKey, value: FeatureValue) -> WriteResult:
        """Set it under its selectors; the server says all that changed. Only where it `selects`."""
        return read_write_result(self._ask("set", str(key), format_value(value)))

    def changes(self) -> frozenset[str]:
        """What others changed since the last call."""
        answer = self._ask("changes", str(self._revision))
        if not isinstance(answer, dict):
            raise RemoteProtocolError("the server's list of changes is malformed")
        revision, names = answer.get("revision"), answer.get("names")
        if not isinstance(revision, int) or not isinstance(names, (list, type(None))):
            raise RemoteProtocolError("the server's list of changes is malformed")
        first, self._revision = not self._revision, revision
        if names is None:
            return frozenset() if first else self._names
        return self._names.intersection(map(str, names))
