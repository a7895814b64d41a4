"""Numbers of features as text, with units. Pure functions."""

from __future__ import annotations

import math

from grabbergui.core.visible_text import shortened
from grabbergui.models.language import localized

DIGITS = 7
"""Significant digits shown of a fraction: those of 32-bit floating point."""

_UNITS = {
    "us": "µs",
    "usec": "µs",
    "um": "µm",
    "C": "°C",
    "degC": "°C",
    "DegC": "°C",
    "Celsius": "°C",
    "deg": "°",
    "Percent": "%",
    "percent": "%",
}

MOST_UNIT = 20
"Characters of a unit."
LONG = 1000
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


def unit_text(unit: str) -> str:
    """Return a unit as display text: `us` is `µs`."""
    return _UNITS.get(unit) or shortened(unit, MOST_UNIT)


def shown_unit(number: int | float, unit: str, before: str = "") -> str:
    """Return the unit in which to show a number that has `unit`: seconds for a million microseconds.

    A larger unit in which it was shown `before` is kept until the number is `SHORT` in it: a user who types 9
    over "10 ms", and then 8, means milliseconds both times.
    """
    shown = _long_unit(number, unit)
    kept = power_between(unit, before)
    return before if kept > power_between(unit, shown) and abs(number) >= SHORT * 10.0**kept else shown


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
    if (powers := power_between(unit, shown)) > 0:
        # An integer keeps its digits.
        digits = max(digits, len(str(abs(number)))) if isinstance(number, int) else digits
        number = number / 10**powers
    return f"{number_text(number, digits)} {unit_text(shown)}".rstrip()


def in_unit(number: float, unit: str, shown_in: str) -> float:
    """Return a number that has `unit` in another unit of its family: 10 for 10000 us shown in ms."""
    return number / 10.0 ** power_between(unit, shown_in)


def unit_family(unit: str) -> dict[str, int]:
    """Return the family of a unit, with powers of ten; none for other units."""
    return next((powers for powers in _POWERS if unit in powers), {})


def power_between(unit: str, larger: str) -> int:
    """Return the power of ten between two units of a family; 0 for other units."""
    powers = unit_family(unit)
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
