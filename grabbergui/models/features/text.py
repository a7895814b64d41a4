"""Numbers as people read and type them. Pure functions."""

from __future__ import annotations

import ipaddress
import math
import re

from grabbergui.core.features import Feature, FeatureKind, Representation

CODED = (Representation.HEX_NUMBER, Representation.IPV4_ADDRESS, Representation.MAC_ADDRESS)
"""Representations of integers that are typed as text."""

DIGITS = 7
"""Significant digits of a fraction that is shown: what 32-bit floating point has."""

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

_POWERS = (
    {"s": 0, "ms": -3, "us": -6, "µs": -6, "ns": -9},
    {"Hz": 0, "kHz": 3, "MHz": 6},
)
"""Units that can be typed for each other, as powers of ten."""

_LOWER_UPPER = re.compile(r"(?<=[a-z0-9])(?=[A-Z])")
_ZERO_WIDTH_SPACE = "\u200b"


def unit_text(unit: str) -> str:
    """A unit as people write it: `us` is `µs`."""
    return _UNITS.get(unit, unit)


def breakable(title: str) -> str:
    """A title that may be broken into lines between its words, also where it is one CamelCase word."""
    return _LOWER_UPPER.sub(_ZERO_WIDTH_SPACE, title)


def number_text(number: int | float, digits: int = DIGITS) -> str:
    """A number to look at: integers in full, fractions with so many significant digits."""
    if isinstance(number, int):
        return str(number)
    if not math.isfinite(number) or (number and not 1e-6 <= abs(number) < 1e15):
        return f"{number:.{digits}g}"
    decimals = digits - 1 - math.floor(math.log10(abs(number))) if number else 0
    text = f"{number:.{max(decimals, 0)}f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


def parse_number(text: str, feature: Feature) -> int | float:
    """What somebody typed into a number's field, with or without a unit. Raises ValueError.

    The unit may be a multiple of the feature's own: `12,5 ms` is 12500 where that is `us`.
    """
    bare, power = _without_unit(text.strip(), feature.unit)
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


def _without_unit(text: str, unit: str) -> tuple[str, int]:
    """The number before a unit, and by which power of ten that is more than the feature's own unit."""
    for powers in _POWERS:
        for other in sorted(powers, key=len, reverse=True):
            if unit in powers and text.endswith(other):
                return text[: -len(other)].strip(), powers[other] - powers[unit]
    for own in (unit, unit_text(unit)):
        if own and text.endswith(own):
            return text[: -len(own)].strip(), 0
    return text, 0


def _fraction(text: str) -> float:
    number = float(text if "." in text else text.replace(",", ".", 1))
    if math.isnan(number):
        raise ValueError("not a number")
    return number


def coded_text(number: int, representation: Representation) -> str:
    """An integer as hexadecimal digits, an IPv4 or a MAC address; the first octet is the highest byte."""
    if representation is Representation.IPV4_ADDRESS and 0 <= number < 1 << 32:
        return str(ipaddress.IPv4Address(number))
    if representation is Representation.MAC_ADDRESS and 0 <= number < 1 << 48:
        return ":".join(f"{byte:02X}" for byte in number.to_bytes(6, "big"))
    return f"-0x{-number:X}" if number < 0 else f"0x{number:X}"


def parse_coded(text: str, representation: Representation) -> int:
    """The integer that somebody typed; also plain or hexadecimal digits. Raises ValueError."""
    bare = text.strip()
    if representation is Representation.IPV4_ADDRESS and "." in bare:
        return int(ipaddress.IPv4Address(bare))
    if representation is Representation.MAC_ADDRESS and re.fullmatch(
        r"[0-9A-Fa-f]{1,2}([:-][0-9A-Fa-f]{1,2}){5}", bare
    ):
        return int.from_bytes(bytes(int(octet, 16) for octet in re.split("[:-]", bare)), "big")
    try:
        return int(bare, 0)
    except ValueError:
        if representation is not Representation.HEX_NUMBER:
            raise
        return int(bare, 16)
