"""What the operator set, so that it can be set again on a camera that lost its power."""

from __future__ import annotations

import logging
from collections.abc import Callable

from grabbergui.core.errors import FeatureError
from grabbergui.core.features import Feature, FeatureValue

log = logging.getLogger(__name__)

_Key = tuple[str, tuple[FeatureValue | None, ...]]


class SettingsMemory:
    """The last value written to each feature, in the order of writing; selected instances apart."""

    def __init__(self) -> None:
        self._written: dict[_Key, tuple[dict[str, FeatureValue], FeatureValue]] = {}

    def note(self, feature: Feature, value: FeatureValue, read: Callable[[str], Feature]) -> None:
        """Remember a write that worked; `read` tells what its selectors stand at."""
        standing = {name: read(name).value for name in feature.selectors}
        selected = {name: choice for name, choice in standing.items() if choice is not None}
        key = (feature.name, tuple(selected.values()))
        # Written again goes to the end: what was set last is set last.
        self._written.pop(key, None)
        self._written[key] = (selected, value)

    def replay(self, write: Callable[[str, FeatureValue], object]) -> list[str]:
        """Write everything again in order; returns what the camera refused, a sentence each."""
        refused = []
        for (name, _), (selected, value) in self._written.items():
            try:
                for selector, choice in selected.items():
                    write(selector, choice)
                write(name, value)
            except FeatureError as error:
                refused.append(str(error))
        return refused

    def __len__(self) -> int:
        return len(self._written)
