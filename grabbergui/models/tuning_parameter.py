"""Parameters of a camera that a tuning run adjusts."""

from __future__ import annotations

from dataclasses import dataclass

from grabbergui.core.feature_source import FeatureSource
from grabbergui.core.features import Feature, FeatureValue
from grabbergui.core.settings import SettingKey
from grabbergui.core.sfnc import (
    AUTO_ONCE,
    Role,
    automatic_mode_of,
    switched_off,
)
from grabbergui.models.features.slider_scale import nearest_allowed
from grabbergui.models.parameter_search import Law, ParameterSearch


@dataclass
class TuningParameter:
    """A number feature, perhaps behind a selector, and the search for its value."""

    feature: Feature
    search: ParameterSearch
    key: SettingKey

    @classmethod
    def of(
        cls,
        feature: Feature,
        law: Law,
        *,
        highest: float | None = None,
        key: SettingKey | None = None,
    ) -> TuningParameter | None:
        """Return a parameter over the feature's range, or up to `highest`; None without a range or value.

        Without a `key` it is the instance that is selected at present.
        """
        low, high = feature.minimum, feature.maximum
        if low is None or high is None or not isinstance(feature.value, int | float):
            return None
        if highest is not None:
            step = feature.increment or 0
            highest = low + (highest - low) // step * step if step else highest
            high = max(min(high, highest), feature.value)
        return cls(feature, ParameterSearch(feature.value, low, high, law), key or SettingKey(feature.name))

    def proposed(self, factor: float) -> FeatureValue | None:
        """Return the value to write for `factor` times the light; None at the end of the range."""
        before = self.search.value
        wanted = self.search.propose(factor)
        if wanted is None:
            return None
        allowed = nearest_allowed(self.feature, wanted)
        if allowed == before:
            # The increment is coarse: propose the next value on that side, if there is one.
            step = self.feature.increment or 0
            allowed = nearest_allowed(self.feature, before + (step if factor > 1 else -step))
        self.search.accept(before)
        return None if allowed == before else allowed


def switch_to_manual(grabber: FeatureSource, name: str) -> Feature:
    """Switch a feature's automatic mode off, and return the feature."""
    auto = automatic_mode_of(name, grabber.has_feature)
    if auto is not None and (off := switched_off(grabber.feature(auto))) is not None:
        grabber.write_feature(*off)
    return grabber.feature(name)


def automatic_once(grabber: FeatureSource, role: Role) -> str | None:
    """Return the automatic mode of a role's feature if it can run once."""
    name = grabber.role(role)
    auto = automatic_mode_of(name, grabber.has_feature) if name is not None else None
    if auto is None:
        return None
    mode = grabber.feature(auto)
    can = mode.access.writable and any(e.name == AUTO_ONCE and e.available for e in mode.entries)
    return auto if can else None
