"""The scale of a slider: linear or logarithmic, over any range. Pure functions."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from grabbergui.core.features import Feature, FeatureKind, Representation

SLIDER_STEPS = 1000
"""Positions of a slider; fewer if an integer has fewer values."""

HUGE_RANGE = 1e9
"""A range from here on gets no slider: no user can find a value in it."""

TINY = 1e-200
"""Ranges and steps below this, and steps above its reciprocal, make quotients overflow."""

PER_PIXEL = 0.025
"""Largest relative change of the number per pixel of a logarithmic track: coarser steps are hard to hit."""

_SLIDABLE = (Representation.LINEAR, Representation.LOGARITHMIC)


@dataclass(frozen=True)
class SliderScale:
    """A feature's range as slider positions 0 … `steps`, linear or logarithmic; a logarithmic one may hold 0.

    `around` returns the part that a track shows.
    """

    minimum: int | float
    maximum: int | float
    increment: int | float = 0
    "0 if every value in the range is valid."
    integer: bool = False
    logarithmic: bool = False
    first: float = 0.0
    "Start of the logarithmic part; 0 if it follows from the range."

    @classmethod
    def of(cls, feature: Feature) -> SliderScale | None:
        """Return the scale for a feature, or None if a slider makes no sense."""
        low, high = feature.minimum, feature.maximum
        if low is None or high is None or feature.representation not in _SLIDABLE:
            return None
        if not TINY < high - low < HUGE_RANGE:
            return None
        integer = feature.kind is FeatureKind.INTEGER
        increment = increment_of(feature)
        if integer:
            # The slider ends at a value that the camera accepts.
            high = low + (int(high) - int(low)) // int(increment) * int(increment)
        return cls(low, high, increment, integer, feature.logarithmic) if high > low else None

    @property
    def steps(self) -> int:
        """The highest position."""
        if self.integer and not self.logarithmic:
            return min(SLIDER_STEPS, int(self.maximum - self.minimum) // int(self.increment))
        return SLIDER_STEPS

    def around(self, number: int | float, pixels: int, share: float = 0.5) -> SliderScale:
        """Return the part of the range that a track of this many pixels shows, with `number` on it.

        `share` is the position of `number` on the track, 0 … 1, unless an end of the range is too near. The
        part is the whole range, unless a pixel of a logarithmic track would then change the number by more
        than `PER_PIXEL`.
        """
        span = pixels * math.log1p(PER_PIXEL)
        if not self.logarithmic or (longest := math.log(self.maximum / self._floor)) <= span:
            return self
        start = math.log(max(number, self._floor) / self._floor) - share * span
        start = min(max(start, 0.0), longest - span)
        low, high = (significant(self._floor * math.exp(end), 3) for end in (start, start + span))
        low = self._on_step(low) if start > 0 else self.minimum
        high = self._on_step(high) if start < longest - span else self.maximum
        return replace(self, minimum=low, maximum=high, first=max(low, self._floor)) if high > low else self

    def to_value(self, position: int) -> int | float:
        """Return the number at a position: exact at both ends, elsewhere rounded to the resolution."""
        if position <= 0:
            return self.minimum
        if position >= self.steps:
            return self.maximum
        if self.logarithmic:
            fraction = (position - self._zero) / (self.steps - self._zero)
            exact = self._floor * math.exp(fraction * math.log(self.maximum / self._floor))
            ratio = math.log(self.maximum / self._floor) / (self.steps - self._zero)
            number = significant(exact, 1 + math.ceil(-math.log10(ratio)))
        else:
            resolution = (self.maximum - self.minimum) / self.steps
            exact = self.minimum + resolution * position
            number = round(exact, max(0, -math.floor(math.log10(resolution))))
        return self._on_step(number)

    def to_position(self, number: int | float) -> int:
        """Return the position nearest to a number: an end for a number beyond the range."""
        if not number > self.minimum:
            return 0
        if number >= self.maximum:
            return self.steps
        if not self.logarithmic:
            return round((number - self.minimum) / (self.maximum - self.minimum) * self.steps)
        if number <= self._floor:
            return self._zero
        fraction = math.log(number / self._floor) / math.log(self.maximum / self._floor)
        return self._zero + round(fraction * (self.steps - self._zero))

    @property
    def _zero(self) -> int:
        """Position where the logarithm begins: 1 if the minimum is zero or nearly zero, else 0."""
        return 0 if self._floor == self.minimum else 1

    @property
    def _floor(self) -> float:
        """Number where the logarithm begins, at most nine decades below the maximum if the range has more."""
        if self.first:
            return self.first
        if self.minimum >= self.maximum * 1e-9:
            return self.minimum
        return min(self.increment or self.maximum * 1e-6, self.maximum / 2)

    def _on_step(self, number: int | float) -> int | float:
        if self.increment:
            steps = round((number - self.minimum) / self.increment)
            number = self.minimum + steps * self.increment
        number = min(max(number, self.minimum), self.maximum)
        return int(number) if self.integer else number


def nearest_allowed(feature: Feature, number: int | float) -> int | float:
    """Return the nearest number that a feature accepts: within its range, an integer on its increment."""
    low, high = feature.minimum, feature.maximum
    if high is not None and number > high:
        number = high
    if low is not None and number < low:
        number = low
    if feature.kind is not FeatureKind.INTEGER:
        return float(number)
    whole = number if isinstance(number, int) else round(number)
    step = int(increment_of(feature))
    if low is None or step <= 1:
        return whole
    snapped = int(low) + (whole - int(low) + step // 2) // step * step
    return snapped if high is None or snapped <= high else snapped - step


def increment_of(feature: Feature) -> int | float:
    """Return the increment; without a usable one, 1 for an integer and 0 for a fraction."""
    increment = feature.increment or 0
    if not TINY < increment < 1 / TINY:  # remote cameras may send anything
        increment = 0
    return max(1, int(increment)) if feature.kind is FeatureKind.INTEGER else increment


def significant(number: float, digits: int) -> float:
    """Return a number with so many significant digits."""
    return float(f"{number:.{max(digits, 1)}g}")
