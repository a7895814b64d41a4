"""Numbers of features: as text with units, as typed, on a slider, by arrow keys. Pure functions."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from enum import Enum

from grabbergui.core.features import CODED, Feature, FeatureKind, FeatureValue, Representation
from grabbergui.core.visible_text import shortened
from grabbergui.models.language import localized

"""Representations of integers that are typed as text."""

# -- as text -------------------------------------------------------------------------------------
DIGITS = 7
"""Significant digits shown of a fraction: those of 32-bit floating point."""

_UNITS = {
    "us": "µs",
    "usec": "µs",
    "C": "°C",
    "degC": "°C",
    "DegC": "°C",
    "Celsius": "°C",
    "deg": "°",
    "Percent": "%",
    "percent": "%",
}

LONG = 10_000
"""Numbers from here on are shown in a larger unit, if there is one."""

SHORT = 0.1
"""A number below this in the larger unit returns to a smaller one."""

_POWERS = (
    {"s": 0, "sec": 0, "ms": -3, "us": -6, "µs": -6, "ns": -9},
    {"Hz": 0, "kHz": 3, "MHz": 6},
    {"Bps": 0, "kBps": 3, "MBps": 6, "GBps": 9},
)
"""Families of units that can be typed for each other, with their powers of ten."""

_SHOWN_IN = (("s", "ms", "µs"), ("MHz", "kHz"), ("GBps", "MBps", "kBps"))
"""For each of those families, the units in which long numbers are shown, largest first."""


MOST_UNIT = 20
"Characters of a unit."


def unit_text(unit: str) -> str:
    """Return a unit as display text: `us` is `µs`."""
    return _UNITS.get(unit) or shortened(unit, MOST_UNIT)


def shown_unit(number: int | float, unit: str, before: str = "") -> str:
    """Return the unit in which to show a number that has `unit`: seconds for a million microseconds.

    A larger unit in which it was shown `before` is kept until the number is `SHORT` in it: a user who types 9
    over "10 ms", and then 8, means milliseconds both times.
    """
    shown = _long_unit(number, unit)
    kept = _power_between(unit, before)
    return before if kept > _power_between(unit, shown) and abs(number) >= SHORT * 10.0**kept else shown


def _long_unit(number: int | float, unit: str) -> str:
    """Return the largest unit in which a long number is at least 1; its own unit for a short number."""
    for powers, larger in zip(_POWERS, _SHOWN_IN, strict=True):
        if unit in powers and LONG <= abs(number) < math.inf:
            exact = [name for name in larger if abs(number) >= 10.0 ** (powers[name] - powers[unit])]
            if exact and powers[exact[0]] > powers[unit]:
                return exact[0]
    return unit


def quantity_text(number: int | float, unit: str, digits: int = DIGITS, shown_in: str | None = None) -> str:
    """Return a number with its unit as display text: `1 s` for 1000000 us, or in the unit `shown_in`."""
    shown = shown_unit(number, unit) if shown_in is None else shown_in
    if (powers := _power_between(unit, shown)) > 0:
        # An integer keeps its digits.
        digits = max(digits, len(str(abs(number)))) if isinstance(number, int) else digits
        number = number / 10**powers
    return f"{number_text(number, digits)} {unit_text(shown)}".rstrip()


def in_unit(number: float, unit: str, shown_in: str) -> float:
    """Return a number that has `unit` in another unit of its family: 10 for 10000 us shown in ms."""
    return number / 10.0 ** _power_between(unit, shown_in)


def _family(unit: str) -> dict[str, int]:
    """Return the family of a unit, with powers of ten; none for other units."""
    return next((powers for powers in _POWERS if unit in powers), {})


def _power_between(unit: str, larger: str) -> int:
    """Return the power of ten between two units of a family; 0 for other units."""
    powers = _family(unit)
    return powers[larger] - powers[unit] if larger in powers else 0


def number_text(number: int | float, digits: int = DIGITS) -> str:
    """Return a number as display text: integers in full, fractions rounded to significant digits."""
    if isinstance(number, int):
        return str(number)
    if not math.isfinite(number) or (number and not 1e-6 <= abs(number) < 1e15):
        return localized(f"{number:.{digits}g}")
    decimals = digits - 1 - math.floor(math.log10(abs(number))) if number else 0
    text = f"{number:.{max(decimals, 0)}f}"
    return localized(text.rstrip("0").rstrip(".") if "." in text else text)


# -- typed ---------------------------------------------------------------------------------------
_NUMBER_BEGUN = re.compile(r"[+-]?(?:0[xX][0-9a-fA-F]*|[0-9]*[.,]?[0-9]*(?:[eE][+-]?[0-9]*)?)")
"""A number, or the beginning of one."""


def can_become_number(text: str, unit: str, shown_in: str) -> bool:
    """Return whether typed text is a number or can become one, with a unit of the feature's family.

    The unit that was shown before may still follow it.
    """
    text = text.strip()
    rest = text[_begun_number(text) :].strip()
    units = {unit, unit_text(unit), shown_in, unit_text(shown_in), *_family(unit)}
    typed = rest.removesuffix(unit_text(shown_in)).strip() if unit_text(shown_in) else rest
    return any(name.startswith(part) for part in (rest, typed) for name in units)


def without_shown_unit(text: str, shown_in: str) -> str:
    """Drop the shown unit from a text if the user typed another one before it."""
    typed = text.removesuffix(f" {unit_text(shown_in)}").strip()
    another = typed != text.strip() and bool(typed[_begun_number(typed) :].strip())
    return typed if another else text


def _begun_number(text: str) -> int:
    """Return the length of the number at the beginning."""
    begun = _NUMBER_BEGUN.match(text)
    return begun.end() if begun is not None else 0


def parse_number(text: str, feature: Feature, shown_in: str = "") -> int | float:
    """Return the number that the user typed, with or without a unit. Raises ValueError.

    The unit may be a multiple of the feature's own: `12,5 ms` is 12500 for a feature in `us`. A number
    without a unit is in the unit `shown_in`, or else in the feature's own.
    """
    text = text.strip()
    if shown_in and _begun_number(text) == len(text):
        text = f"{text} {shown_in}"
    bare, power = _without_unit(text, feature.unit)
    if power:
        scale = 10.0 ** abs(power)
        number = _fraction(bare) * scale if power > 0 else _fraction(bare) / scale
        if not math.isfinite(number):
            raise ValueError("not a finite number")
        return round(number) if feature.kind is FeatureKind.INTEGER else number
    if feature.kind is FeatureKind.INTEGER:
        try:
            return int(bare, 0)
        except ValueError:
            as_float = float(bare)
            if not math.isfinite(as_float):
                raise ValueError("not a finite number") from None
            return round(as_float)
    return _fraction(bare)


def units_to_type(unit: str) -> tuple[str, ...]:
    """Return the units with which a number in `unit` can be typed, as display text, the largest first."""
    family = _family(unit) or ({unit: 0} if unit else {})
    spelt = {power: unit_text(name) for name, power in reversed(family.items())}  # the usual is first
    return tuple(spelt[power] for power in sorted(spelt, reverse=True))


def typed_unit(text: str, unit: str) -> str:
    """Return the unit at the end of a typed text if it belongs to the family of `unit`; else nothing."""
    longest_first = sorted(_family(unit), key=len, reverse=True)
    return next((name for name in longest_first if text.rstrip().endswith(name)), "")


def typed_value(text: str, feature: Feature) -> FeatureValue:
    """Return the value to write for a text from a command line: `20ms` is 20000 for a feature in `us`.

    Any text but a number with a unit is returned unchanged; writing an invalid one raises an error with the
    allowed values.
    """
    is_number = feature.kind in (FeatureKind.INTEGER, FeatureKind.FLOAT)
    has_unit = is_number and _without_unit(text.strip(), feature.unit)[0] != text.strip()
    if not has_unit or feature.representation in CODED:
        return text
    try:
        return parse_number(text, feature)
    except ValueError:
        return text


def _without_unit(text: str, unit: str) -> tuple[str, int]:
    """Return the number before a unit, and the unit's power of ten relative to the feature's own unit."""
    if typed := typed_unit(text, unit):
        return text[: -len(typed)].strip(), _power_between(unit, typed)
    for own in (unit, unit_text(unit)):
        if own and text.endswith(own):
            return text[: -len(own)].strip(), 0
    return text, 0


def _fraction(text: str) -> float:
    number = float(text if "." in text else text.replace(",", ".", 1))
    if math.isnan(number):
        raise ValueError("not a number")
    return number


# -- on a slider ---------------------------------------------------------------------------------
SLIDER_STEPS = 1000
"""Positions of a slider; fewer if an integer has fewer values."""

HUGE_RANGE = 1e9
"""A range from here on gets no slider: no user can find a value in it."""

_TINY = 1e-200
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
        if not _TINY < high - low < HUGE_RANGE:
            return None
        integer = feature.kind is FeatureKind.INTEGER
        increment = _increment(feature)
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
        low, high = (_significant(self._floor * math.exp(end), 3) for end in (start, start + span))
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
            number = _significant(exact, 1 + math.ceil(-math.log10(ratio)))
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
    step = int(_increment(feature))
    if low is None or step <= 1:
        return whole
    snapped = int(low) + (whole - int(low) + step // 2) // step * step
    return snapped if high is None or snapped <= high else snapped - step


# -- by arrow keys -------------------------------------------------------------------------------
KEY_STEP = 0.01
"""One step of an arrow key, as a fraction of the range or the number."""


class Pace(Enum):
    """Size of one step: Shift makes it fine, Ctrl coarse."""

    FINE = 0.1
    USUAL = 1.0
    COARSE = 10.0


def natural_step(feature: Feature, pace: Pace = Pace.USUAL) -> int | float:
    """Return what one press of an arrow key adds: the increment, or about 1 %.

    That is 1 % of the range, or of the value if the scale is logarithmic or unlimited. A tenth of it with
    Pace.FINE, ten times as much with Pace.COARSE, and never less than the increment.
    """
    integer = feature.kind is FeatureKind.INTEGER
    scale = SliderScale.of(feature)
    linear = scale is not None and not scale.logarithmic
    least = _increment(feature)
    if linear and scale is not None:
        size = scale.maximum - scale.minimum
    else:
        size = abs(feature.value) if isinstance(feature.value, int | float) else 0
    step: int | float = _significant(size * KEY_STEP, 1) if _TINY < size < 1 / _TINY else 1.0
    # With a very small increment (1e-6 dB) a step of one increment would take thousands of presses.
    if least and not feature.logarithmic and (integer or not linear or least * 1000 >= size):
        step = least
    step *= pace.value
    if least:
        step = max(1, round(step / least)) * least
    return int(step) if integer else step


def stepped(feature: Feature, steps: int, pace: Pace = Pace.USUAL) -> int | float:
    """Return the value after some presses of an arrow key; 64-bit integers exact, fractions rounded."""
    step = natural_step(feature, pace)
    value = feature.value if isinstance(feature.value, int | float) else feature.minimum or 0
    number = value + steps * step
    if isinstance(number, float) and not feature.increment:
        number = round(number, max(0, -math.floor(math.log10(step))))
    return nearest_allowed(feature, number)


def _increment(feature: Feature) -> int | float:
    """Return the increment; without a usable one, 1 for an integer and 0 for a fraction."""
    increment = feature.increment or 0
    if not _TINY < increment < 1 / _TINY:  # remote cameras may send anything
        increment = 0
    return max(1, int(increment)) if feature.kind is FeatureKind.INTEGER else increment


def _significant(number: float, digits: int) -> float:
    return float(f"{number:.{max(digits, 1)}g}")
