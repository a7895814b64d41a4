"""Tuning parameters: features that a tuning run adjusts, and the search for their values.

The search decides and touches no camera. The measurement is expected to grow with the parameter, not more:
it copes with a black level, a gamma curve, saturation and a scene that moves. Each proposal is a guess by the
parameter's law, held between the values that were found too small and too large.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from grabbergui.core.features import Feature, FeatureValue
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.selection import SettingKey
from grabbergui.core.sfnc import AUTO_ONCE, Role, automatic_mode_of, switched_off
from grabbergui.models.features.scale import nearest_allowed

STRONGEST = 8.0
"Largest factor by which one step changes the light."
NEARLY_BLACK = 0.01
"Part of white below which a measurement shows only that it is dark."
ROOM = 1e-3
"Relative distance of the bounds below which they are forgotten: the scene has changed since."
FLATTEST, STEEPEST = 0.25, 2.0
"Bounds, in logarithms, within which a step's effect is believed."
LEAST_STEP = 0.02
"Relative: what a smaller step did is lost in noise."


class Law(Enum):
    """Dependence of the measurement on a parameter."""

    PROPORTIONAL = "proportional"
    "An exposure time, a ratio."
    DECIBEL = "dB"
    "A gain in decibels of amplitude."
    UNKNOWN = "unknown"
    "A gain in the vendor's own numbers: only its direction is known."


class ParameterSearch:
    """Proposes values for one parameter between `low` and `high`, starting at its current value."""

    def __init__(self, value: float, low: float, high: float, law: Law) -> None:
        self.value = value
        "The parameter's current value."
        self._low, self._high = low, high
        self._law = law
        self._last: tuple[float, float] | None = None
        "Logarithms of the light and of the factor at the previous step."
        self._too_small: float | None = None
        self._too_large: float | None = None

    def propose(self, factor: float) -> float | None:
        """Return a value that should multiply the measurement by `factor`; None at the end of the range."""
        factor = min(max(factor, 1 / STRONGEST), STRONGEST)
        if (self.value >= self._high) if factor > 1 else (self.value <= self._low):
            return None
        if factor > 1:
            self._too_small = self.value
        else:
            self._too_large = self.value
        self._forget_outdated_bounds()
        guess = min(max(self._between(self._guess(factor)), self._low), self._high)
        self.value = guess
        return guess

    def accept(self, value: float) -> None:
        """Note the value that the camera made of the proposal."""
        self.value = value

    def _guess(self, factor: float) -> float:
        if self._law is Law.UNKNOWN:
            end = self._high if factor > 1 else self._low
            return (self.value + end) / 2 if abs(end - self.value) > 1 else end
        if self._law is Law.DECIBEL:
            return self.value + _decibels(self._step(_nepers(self.value), math.log(factor)))
        # From zero no factor has an effect.
        value = max(self.value, (self._high - self._low) * 1e-6)
        return value * math.exp(self._step(math.log(value), math.log(factor)))

    def _step(self, light: float, wanted: float) -> float:
        """Return the step as a logarithm: longer than `wanted` if the previous step did too little.

        A black level or a gamma curve makes every step fall short; two measurements show by how much.
        """
        slope = 1.0
        if self._last is not None:
            moved, achieved = light - self._last[0], self._last[1] - wanted
            if abs(moved) > LEAST_STEP:
                slope = min(max(achieved / moved, FLATTEST), STEEPEST)
        self._last = light, wanted
        return min(max(wanted / slope, -math.log(STRONGEST)), math.log(STRONGEST))

    def _between(self, guess: float) -> float:
        small, large = self._too_small, self._too_large
        if small is None or large is None or small < guess < large:
            return guess
        if self._law is Law.PROPORTIONAL and small > 0:
            return math.sqrt(small * large)
        return (small + large) / 2

    def _forget_outdated_bounds(self) -> None:
        small, large = self._too_small, self._too_large
        if small is not None and large is not None and large - small <= ROOM * abs(large):
            self._too_small = self._too_large = None


def _nepers(decibels: float) -> float:
    return decibels / 20 * math.log(10)


def _decibels(nepers: float) -> float:
    return nepers * 20 / math.log(10)


def light_factor(mean: float, saturated: float, target: float) -> float:
    """Return the factor by which the light has to change, as far as one measurement shows.

    Saturated pixels hide how bright they are, so an image with many of them is darkened by more.
    """
    if mean < NEARLY_BLACK:
        return STRONGEST if target > mean else 1 / STRONGEST
    factor = target / mean
    return factor * (1 - saturated) ** 2 if factor < 1 else factor


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
        """Make a parameter over the feature's range, or up to `highest`; None without a range or value.

        Without a `key` it is the instance that the selectors currently select.
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
        """Return the value to write for `factor` times as much; None if there is none."""
        before = self.search.value
        wanted = self.search.propose(factor)
        if wanted is None:
            return None
        allowed = nearest_allowed(self.feature, wanted)
        if allowed == before:
            # A coarse step: the next value on that side, if it is still on that side.
            step = self.feature.increment or 0
            allowed = nearest_allowed(self.feature, before + (step if factor > 1 else -step))
        self.search.accept(before)
        return None if allowed == before else allowed


def switch_to_manual(grabber: FrameGrabber, name: str) -> Feature:
    """Switch a feature's automatic mode off, and read the feature."""
    auto = automatic_mode_of(name, grabber.has_feature)
    if auto is not None and (off := switched_off(grabber.feature(auto))) is not None:
        grabber.write_feature(*off)
    return grabber.feature(name)


def automatic_once(grabber: FrameGrabber, role: Role) -> str | None:
    """Return the automatic mode of a role's feature if it can run once."""
    name = role.find(grabber.has_feature)
    auto = automatic_mode_of(name, grabber.has_feature) if name is not None else None
    if auto is None:
        return None
    mode = grabber.feature(auto)
    can = mode.access.writable and any(e.name == AUTO_ONCE and e.available for e in mode.entries)
    return auto if can else None
