"""The sources and feature names that were seen last, kept in the user's cache for completion.

Only commands that somebody types keep them, never services and scripts. Losing the file costs nothing, so
errors of reading and writing it are ignored.
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

_SIMULATED = Path(__file__).parents[1] / "driver" / "sim" / "camera.xml"
_LISTED = re.compile(r"<pFeature>(\w+)</pFeature>")
_CATEGORY = re.compile(r'<Category Name="(\w+)"')
_MOST_CAMERAS = 20
"""Cameras whose features are kept; those seen longest ago are dropped."""


@dataclass
class Seen:
    """The cache of one user: sources and feature names of the last commands."""

    file: Path = field(default_factory=lambda: cache_home() / "grabbergui" / "seen.json")
    clock: Callable[[], float] = time.time

    def sources(self, within: float) -> list[str] | None:
        """Return the URIs of the last search; None if it is older than `within` seconds."""
        entry = self._read().get("sources", {})
        age = self.clock() - _number(entry.get("time") if isinstance(entry, dict) else None)
        return _texts(entry.get("uris")) if 0 <= age <= within else None

    def features(self, uri: str) -> list[str]:
        """Return a source's feature names; the simulated camera's if that source was never open."""
        features = self._read().get("features", {})
        return (_texts(features.get(uri)) if isinstance(features, dict) else []) or simulated_features()

    def keep_sources(self, uris: Iterable[str]) -> None:
        """Remember the result of a search."""
        self._write({**self._read(), "sources": {"time": self.clock(), "uris": list(uris)}})

    def keep_features(self, uri: str, names: Iterable[str]) -> None:
        """Remember a source's feature names."""
        kept = self._read()
        features = kept.get("features", {})
        others = (
            {each: names for each, names in features.items() if each != uri}
            if isinstance(features, dict)
            else {}
        )
        recent = dict(list(others.items())[-_MOST_CAMERAS + 1 :])
        self._write({**kept, "features": {**recent, uri: list(names)}})

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
            unfinished.write_text(json.dumps(kept), "utf-8")
            unfinished.replace(self.file)


def somebody_types() -> bool:
    """Return whether this command was typed into a terminal."""
    return sys.stdin is not None and sys.stdin.isatty()


def simulated_features() -> list[str]:
    """Return the feature names of the simulated camera, most of which are SFNC's."""
    description = _SIMULATED.read_text("utf-8")
    return sorted(set(_LISTED.findall(description)) - set(_CATEGORY.findall(description)))


def _texts(value: object) -> list[str]:
    return [each for each in value if isinstance(each, str)] if isinstance(value, list) else []


def _number(value: object) -> float:
    return float(value) if isinstance(value, int | float) else 0.0
