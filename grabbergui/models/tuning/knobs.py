"""Features that are turned by a tuning."""

from __future__ import annotations

from dataclasses import dataclass

from grabbergui.core.companions import automatic_mode_of, switched_off
from grabbergui.core.features import Feature, FeatureValue
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.selection import SettingKey
from grabbergui.core.sfnc import AUTO_ONCE, Role
from grabbergui.models.features.scale import nearest_allowed
from grabbergui.models.tuning.knob_search import KnobSearch, Law


@dataclass
class Knob:
    """A number feature, perhaps behind a selector, and the search for its value."""

    feature: Feature
    search: KnobSearch
    key: SettingKey

    @classmethod
    def of(
        cls,
        feature: Feature,
        law: Law,
        *,
        highest: float | None = None,
        key: SettingKey | None = None,
    ) -> Knob | None:
        """A knob over the feature's own range, or up to `highest`; None where it has no range or value.

        Without a `key` it is what its selectors select at the moment.
        """
        low, high = feature.minimum, feature.maximum
        if low is None or high is None or not isinstance(feature.value, int | float):
            return None
        if highest is not None:
            step = feature.increment or 0
            highest = low + (highest - low) // step * step if step else highest
            high = max(min(high, highest), feature.value)
        return cls(feature, KnobSearch(feature.value, low, high, law), key or SettingKey(feature.name))

    def proposed(self, factor: float) -> FeatureValue | None:
        """The value to write for `factor` times as much; None where no value leads there."""
        before = self.search.value
        wanted = self.search.propose(factor)
        if wanted is None:
            return None
        allowed = nearest_allowed(self.feature, wanted)
        if allowed == before:
            # A coarse step: the next value on that side, if it is still on that side.
            step = self.feature.increment or 0
            allowed = nearest_allowed(self.feature, before + (step if factor > 1 else -step))
        self.search.stood(before)
        return None if allowed == before else allowed


def hand_over(grabber: FrameGrabber, name: str) -> Feature:
    """Take a feature from its automatic mode, so that it can be turned, and read it."""
    auto = automatic_mode_of(name, grabber.has_feature)
    if auto is not None and (off := switched_off(grabber.feature(auto))) is not None:
        grabber.write_feature(*off)
    return grabber.feature(name)


def automatic_once(grabber: FrameGrabber, role: Role) -> str | None:
    """The automatic mode of a role's feature that can do it once, if the camera has one."""
    name = role.find(grabber.has_feature)
    auto = automatic_mode_of(name, grabber.has_feature) if name is not None else None
    if auto is None:
        return None
    mode = grabber.feature(auto)
    can = mode.access.writable and any(e.name == AUTO_ONCE and e.available for e in mode.entries)
    return auto if can else None
