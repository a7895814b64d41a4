"""All instances of a feature: one for each combination of the entries of its selectors."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

from grabbergui.core.feature_source import FeatureSource
from grabbergui.core.features import Feature, FeatureKind, format_value
from grabbergui.core.settings import Selected, SettingKey

MAX_INSTANCES = 4096
"Most instances of a feature, enough for a 12-bit look-up table. A feature with more is reported."


def instances(grabber: FeatureSource, path: Sequence[str]) -> tuple[list[Selected], str]:
    """Return every combination of the selectors' entries, and the reason if some are omitted.

    Reads the selectors, writes nothing. If they cannot be changed, only their current entries are returned.
    """
    features = [grabber.feature(name) for name in path]
    current = tuple((f.name, format_value(f.value)) for f in features if f.value is not None)
    if len(current) < len(features):
        return [], ""  # a selector is not available, and so the feature is not either
    if not all(f.access.writable for f in features if len(selector_entries(f)) > 1):
        return [current], "only the present entry of its selector, which cannot be changed"
    choices = [selector_entries(feature) for feature in features]
    if math.prod(len(entries) for entries in choices) > MAX_INSTANCES:
        return [current], f"more than {MAX_INSTANCES} instances; only the selected one is kept"
    return [tuple(zip(path, entries, strict=True)) for entries in itertools.product(*choices)], ""


def instances_of(grabber: FeatureSource, name: str) -> list[SettingKey]:
    """Return a feature's settings under all entries of its selectors; none if the camera does not have it."""
    if not grabber.has_feature(name):
        return []
    found, _ = instances(grabber, grabber.selectors.of(name))
    return [SettingKey(name, selected) for selected in found]


def selector_entries(selector: Feature) -> Sequence[str]:
    """Return the values that a selector can take, as text."""
    if selector.kind is FeatureKind.ENUMERATION:
        return [entry.name for entry in selector.entries if entry.available]
    if selector.kind is FeatureKind.BOOLEAN:
        return ["false", "true"]
    low, high = selector.minimum, selector.maximum
    if selector.kind is FeatureKind.INTEGER and isinstance(low, int) and isinstance(high, int):
        numbers = range(low, high + 1, int(selector.increment or 1))
        # The first ones are enough to recognise that there are too many.
        return [str(number) for number in itertools.islice(numbers, MAX_INSTANCES + 1)]
    return [format_value(selector.value)]
