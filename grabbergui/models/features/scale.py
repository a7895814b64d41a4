"""Mapping between numbers and a slider's positions, and the numbers a feature takes. Pure functions."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import Enum

from grabbergui.core.features import Feature, FeatureKind, Representation

STEPS = 1000
"""Positions of a slider, less where an integer has fewer values."""

HUGE = 1e9
"""A range from here on gets no slider: nobody would find a value in it."""

PER_PIXEL = 0.025
"""Largest relative change of the number per pixel of a logarithmic track; coarser cannot be aimed."""

STEP = 0.01
"""One step of an arrow key, as a share of the range or the number."""

_SLIDABLE = (Representation.LINEAR, Representation.LOGARITHMIC)


class Pace(Enum):
    """Size of one step: Shift makes it fine, Ctrl coarse."""

    FINE = 0.1
    USUAL = 1.0
    COARSE = 10.0


@dataclass(frozen=True)
class SliderScale:
    """A feature's range as positions 0 … `steps`; linear or logarithmic, zero included.

    `around` is the part of it that a track shows.
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
        """Return the scale for a feature, or None where a slider makes no sense."""
        low, high = feature.minimum, feature.maximum
        if low is None or high is None or feature.representation not in _SLIDABLE:
            return None
        if not 0 < high - low < HUGE:
            return None
        integer = feature.kind is FeatureKind.INTEGER
        increment = feature.increment or (1 if integer else 0)
        if integer:
            # The highest value on a step, so that the slider's end is a value the camera takes.
            high = low + (int(high) - int(low)) // int(increment) * int(increment)
        return cls(low, high, increment, integer, feature.logarithmic) if high > low else None

    @property
    def steps(self) -> int:
        """The highest position."""
        if self.integer and not self.logarithmic:
            return min(STEPS, int(self.maximum - self.minimum) // int(self.increment))
        return STEPS

    def around(self, number: int | float, pixels: int, share: float = 0.5) -> SliderScale:
        """Return the part of the range that a track of so many pixels shows, with `number` on it.

        `share` is its position on the track, 0 … 1; near an end of the range the part begins or ends there.
        It is all of the range, unless a pixel of a logarithmic track would then change the number by more
        than `PER_PIXEL`.
        """
        span = pixels * math.log1p(PER_PIXEL)
        if not self.logarithmic or (longest := math.log(self.maximum / self._floor)) <= span:
            return self
        start = math.log(max(number, self._floor) / self._floor) - share * span
        start = min(max(start, 0.0), longest - span)
        low, high = (_significant(self._floor * math.exp(end), 3) for end in (start, start + span))
        low = self._on_step(low) if start > 0 else self.minimum
        high = self._on_step(high) if start < longest - span else self.maximum
        return replace(self, minimum=low, maximum=high, first=max(low, self._floor)) if high > low else self

    def to_value(self, position: int) -> int | float:
        """Return the number at a position: exact at both ends, else rounded to a visible difference."""
        if position <= 0:
            return self.minimum
        if position >= self.steps:
            return self.maximum
        if self.logarithmic:
            fraction = (position - self._zero) / (self.steps - self._zero)
            exact = self._floor * math.exp(fraction * math.log(self.maximum / self._floor))
            ratio = math.log(self.maximum / self._floor) / (self.steps - self._zero)
            number = _significant(exact, 1 + math.ceil(-math.log10(ratio)))
        else:
            resolution = (self.maximum - self.minimum) / self.steps
            exact = self.minimum + resolution * position
            number = round(exact, max(0, -math.floor(math.log10(resolution))))
        return self._on_step(number)

    def to_position(self, number: int | float) -> int:
        """Return the position nearest to a number; beyond the range, the end."""
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
        """Number where the logarithm begins: a slider has no use for more than nine decades."""
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
    """Return the nearest number that a feature takes: within its range, an integer on its step."""
    low, high = feature.minimum, feature.maximum
    if high is not None and number > high:
        number = high
    if low is not None and number < low:
        number = low
    if feature.kind is not FeatureKind.INTEGER:
        return float(number)
    whole = number if isinstance(number, int) else round(number)
    step = int(feature.increment or 1)
    if low is None or step <= 1:
        return whole
    snapped = int(low) + (whole - int(low) + step // 2) // step * step
    return snapped if high is None or snapped <= high else snapped - step


def natural_step(feature: Feature, pace: Pace = Pace.USUAL) -> int | float:
    """Return what one press of an arrow key adds: the increment, or about 1 %.

    That is 1 % of the range, or of the value where the scale is logarithmic or endless. A tenth of it with
    Pace.FINE, ten times as much with Pace.COARSE, and never less than the increment.
    """
    integer = feature.kind is FeatureKind.INTEGER
    scale = SliderScale.of(feature)
    linear = scale is not None and not scale.logarithmic
    least = feature.increment or (1 if integer else 0)
    if linear and scale is not None:
        size = scale.maximum - scale.minimum
    else:
        size = abs(feature.value) if isinstance(feature.value, int | float) else 0
    step: int | float = _significant(size * STEP, 1) if size and math.isfinite(size) else 1.0
    # An increment that only a machine counts in (1e-6 dB) would take thousands of presses.
    if least and not feature.logarithmic and (integer or not linear or least * 1000 >= size):
        step = least
    step *= pace.value
    if least:
        step = max(1, round(step / least)) * least
    return int(step) if integer else step


def stepped(feature: Feature, steps: int, pace: Pace = Pace.USUAL) -> int | float:
    """Return the value after some presses of an arrow key; 64-bit integers exact, fractions on the grid."""
    step = natural_step(feature, pace)
    value = feature.value if isinstance(feature.value, int | float) else feature.minimum or 0
    number = value + steps * step
    if isinstance(number, float) and not feature.increment:
        number = round(number, max(0, -math.floor(math.log10(step))))
    return nearest_allowed(feature, number)


def _significant(number: float, digits: int) -> float:
    return float(f"{number:.{max(digits, 1)}g}")
