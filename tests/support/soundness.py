"""Properties of features on which every view relies, whatever the description."""

from __future__ import annotations

import math

from grabbergui.core.features import AccessMode, Feature, FeatureKind


def assert_sound(feature: Feature) -> None:
    """Limits are finite and in order, steps lead somewhere, what fails says why."""
    low, high = feature.minimum, feature.maximum
    assert all(limit is None or math.isfinite(limit) for limit in (low, high)), feature
    assert low is None or high is None or low <= high, feature
    assert feature.increment is None or feature.increment > 0, feature
    if feature.kind is FeatureKind.ENUMERATION:
        # Perhaps none of those offered: cameras stand at entries that they say they do not implement.
        assert feature.value is None or isinstance(feature.value, str), feature
    assert not feature.problem or feature.access is AccessMode.NOT_AVAILABLE, feature
    assert feature.problem == feature.problem.strip() and "Exception thrown" not in feature.problem, feature
    assert feature.logarithmic in (True, False)
    assert feature.range_text()
