"""The sources that were seen last, their features and these features' values, for completion.

They are kept in the user's cache by commands that somebody types, never by services and scripts.
"""

from __future__ import annotations

import json
import os
import re
import sys
import time
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from grabbergui.core.environment import cache_home
from grabbergui.core.features import Feature, FeatureKind
from grabbergui.core.json_text import to_json

_SIMULATED = Path(__file__).parents[1] / "driver" / "sim" / "camera.xml"
_LISTED = re.compile(r"<pFeature>(\w+)</pFeature>")
_CATEGORY = re.compile(r'<Category Name="(\w+)"')
_ENUMERATION = re.compile(r'<Enumeration Name="(\w+)".*?</Enumeration>', re.DOTALL)
_BOOLEAN = re.compile(r'<Boolean Name="(\w+)"')
_ENTRY = re.compile(r'<EnumEntry Name="(\w+)"')
_SWITCH = ("true", "false")
_MOST_CAMERAS = 20
"""Cameras whose features are kept; those seen longest ago are dropped."""


@dataclass
class Seen:
    """The cache of one user: sources and feature names of the last commands.

    Losing the file costs nothing, so errors of reading and writing it are ignored.
    """

    file: Path = field(default_factory=lambda: cache_home() / "grabbergui" / "seen.json")
    clock: Callable[[], float] = time.time

    def sources(self, within: float) -> list[str] | None:
        """Return the URIs of the last search; None if it is older than `within` seconds."""
        entry = self._read().get("sources", {})
        age = self.clock() - _number(entry.get("time") if isinstance(entry, dict) else None)
        return _texts(entry.get("uris")) if 0 <= age <= within else None

    def features(self, uri: str) -> list[str]:
        """Return a source's feature names; the simulated camera's if that source was never open."""
        return _texts(self._part("features").get(uri)) or simulated_features()

    def values(self, uri: str, name: str) -> list[str]:
        """Return the values of an enumeration or switch; the simulated camera's if it was never read."""
        known = self._part("values").get(uri)
        known = _texts(known.get(name)) if isinstance(known, dict) else []
        return known or simulated_values().get(name, [])

    def keep_sources(self, uris: Iterable[str]) -> None:
        """Remember the result of a search."""
        self._write({**self._read(), "sources": {"time": self.clock(), "uris": list(uris)}})

    def keep_features(self, uri: str, names: Iterable[str]) -> None:
        """Remember a source's feature names."""
        self._keep("features", uri, list(names))

    def keep_values(self, uri: str, features: Iterable[Feature]) -> None:
        """Remember the values of those of a source's features that have few."""
        known = self._part("values").get(uri)
        read = {each.name: list(_few_values(each)) for each in features}
        self._keep(
            "values",
            uri,
            {
                **(known if isinstance(known, dict) else {}),
                **{name: values for name, values in read.items() if values},
            },
        )

    def _part(self, name: str) -> dict[str, Any]:
        part = self._read().get(name)
        return part if isinstance(part, dict) else {}

    def _keep(self, name: str, uri: str, content: object) -> None:
        """Keep something of a source, as the newest of its kind."""
        others = {each: kept for each, kept in self._part(name).items() if each != uri}
        recent = dict(list(others.items())[-_MOST_CAMERAS + 1 :])
        self._write({**self._read(), name: {**recent, uri: content}})

    def _read(self) -> dict[str, Any]:
        try:
            kept = json.loads(self.file.read_text("utf-8"))
        except (OSError, ValueError):
            return {}
        return kept if isinstance(kept, dict) else {}

    def _write(self, kept: dict[str, Any]) -> None:
        unfinished = self.file.with_name(f"{self.file.name}.{os.getpid()}")
        with suppress(OSError):
            self.file.parent.mkdir(parents=True, exist_ok=True)
            unfinished.write_text(to_json(kept), "utf-8")
            unfinished.replace(self.file)


def somebody_types() -> bool:
    """Return whether this command was typed into a terminal."""
    return sys.stdin is not None and sys.stdin.isatty()


def simulated_features() -> list[str]:
    """Return the feature names of the simulated camera, most of which are SFNC's."""
    description = _SIMULATED.read_text("utf-8")
    return sorted(set(_LISTED.findall(description)) - set(_CATEGORY.findall(description)))


def simulated_values() -> dict[str, list[str]]:
    """Return the entries of the simulated camera's enumerations, and the values of its switches, by name."""
    description = _SIMULATED.read_text("utf-8")
    entries = {found[1]: _ENTRY.findall(found[0]) for found in _ENUMERATION.finditer(description)}
    return entries | {name: [*_SWITCH] for name in _BOOLEAN.findall(description)}


def _few_values(feature: Feature) -> Iterable[str]:
    if feature.kind is FeatureKind.BOOLEAN:
        return _SWITCH
    return (entry.name for entry in feature.entries if entry.available)


def _texts(value: object) -> list[str]:
    return [each for each in value if isinstance(each, str)] if isinstance(value, list) else []


def _number(value: object) -> float:
    return float(value) if isinstance(value, int | float) else 0.0
