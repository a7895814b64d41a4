"""The search for a parameter's value that brings a measurement to its target. No I/O."""

from __future__ import annotations

import math
from enum import Enum

STRONGEST = 8.0
"Largest factor by which one step changes the light."
NEARLY_BLACK = 0.01
"Fraction of white below which a measurement shows only that it is dark."
ROOM = 1e-3
"Relative distance below which the bounds are forgotten: the scene must have changed."
FLATTEST, STEEPEST = 0.25, 2.0
"Plausible range of the measured slope, light over parameter in logarithms."
LEAST_STEP = 0.02
"Smallest relative step whose effect stands out from noise."


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
        """Set the value that the camera has after the proposal was written."""
        self.value = value

    def _guess(self, factor: float) -> float:
        if self._law is Law.UNKNOWN:
            end = self._high if factor > 1 else self._low
            return (self.value + end) / 2 if abs(end - self.value) > 1 else end
        if self._law is Law.DECIBEL:
            return self.value + _decibels(self._step(_nepers(self.value), math.log(factor)))
        # Zero cannot be multiplied.
        value = max(self.value, (self._high - self._low) * 1e-6)
        return value * math.exp(self._step(math.log(value), math.log(factor)))

    def _step(self, light: float, wanted: float) -> float:
        """Return the step as a logarithm: longer than `wanted` if the previous step had too little effect.

        A black level or a gamma curve makes every step fall short; two measurements show by how much.
        """
        slope = 1.0
        if self._last is not None:
            step, effect = light - self._last[0], self._last[1] - wanted
            if abs(step) > LEAST_STEP:
                slope = min(max(effect / step, FLATTEST), STEEPEST)
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
    """Return the factor by which the light has to change, estimated from one measurement.

    Saturated pixels hide how bright they are, so an image with many of them is darkened by more.
    """
    if mean < NEARLY_BLACK:
        return STRONGEST if target > mean else 1 / STRONGEST
    factor = target / mean
    return factor * (1 - saturated) ** 2 if factor < 1 else factor
