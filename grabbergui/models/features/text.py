"""Features as text in the user's language: numbers with units, values, ranges, tooltips, and typed numbers.

In English, range and reason are those of `Feature.range_text` and `Feature.access_problem`, with units as
people write them. Pure functions.
"""

from __future__ import annotations

import html
import ipaddress
import math
import re

from grabbergui.core.features import (
    AccessMode,
    Feature,
    FeatureKind,
    FeatureValue,
    Representation,
    format_number,
    format_value,
)
from grabbergui.models.language import counted, driver_text, localized, translate

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

LONG = 10_000
"""From here on a number is shown in a larger unit, where its unit has one."""

SHORT = 0.1
"""Below it a number is not shown any more in the larger unit that it was shown in."""

_POWERS = (
    {"s": 0, "sec": 0, "ms": -3, "us": -6, "µs": -6, "ns": -9},
    {"Hz": 0, "kHz": 3, "MHz": 6},
    {"Bps": 0, "kBps": 3, "MBps": 6, "GBps": 9},
)
"""Units that can be typed for each other, as powers of ten."""

_SHOWN_IN = (("s", "ms", "µs"), ("MHz", "kHz"), ("GBps", "MBps", "kBps"))
"""Of each of those families, the units that long numbers are shown in, largest first."""

_NUMBER_BEGUN = re.compile(r"[+-]?(?:0[xX][0-9a-fA-F]*|[0-9]*[.,]?[0-9]*(?:[eE][+-]?[0-9]*)?)")
"""A number, or the beginning of one."""

_LOWER_UPPER = re.compile(r"(?<=[a-z0-9])(?=[A-Z])")
_ZERO_WIDTH_SPACE = "\u200b"


def unit_text(unit: str) -> str:
    """Return a unit as display text: `us` is `µs`."""
    return _UNITS.get(unit, unit)


def shown_unit(number: int | float, unit: str, before: str = "") -> str:
    """Return the unit in which to show a number that has `unit`: seconds for a million microseconds.

    A larger unit in which it was shown `before` is kept until the number is short in it, so that who types 9
    over "10 ms", and then 8, means milliseconds twice.
    """
    shown = _long_unit(number, unit)
    kept = _power_between(unit, before)
    return before if kept > _power_between(unit, shown) and abs(number) >= SHORT * 10.0**kept else shown


def _long_unit(number: int | float, unit: str) -> str:
    """Return the largest unit in which a long number is at least 1; a short one's own."""
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


def _power_between(unit: str, larger: str) -> int:
    """Return the power of ten between two units of a family; 0 for units of no family."""
    return next((p[larger] - p[unit] for p in _POWERS if unit in p and larger in p), 0)


def breakable(title: str) -> str:
    """Return a title that may be broken into lines between its words, also where it is one CamelCase word."""
    return _LOWER_UPPER.sub(_ZERO_WIDTH_SPACE, title)


def number_text(number: int | float, digits: int = DIGITS) -> str:
    """Return a number as display text: integers in full, fractions rounded to significant digits."""
    if isinstance(number, int):
        return str(number)
    if not math.isfinite(number) or (number and not 1e-6 <= abs(number) < 1e15):
        return localized(f"{number:.{digits}g}")
    decimals = digits - 1 - math.floor(math.log10(abs(number))) if number else 0
    text = f"{number:.{max(decimals, 0)}f}"
    return localized(text.rstrip("0").rstrip(".") if "." in text else text)


def can_become_number(text: str, unit: str, shown_in: str) -> bool:
    """Return whether typed text is a number or can still become one, with a unit of the feature's family.

    It may be followed by the unit that was shown before typing.
    """
    text = text.strip()
    rest = text[_begun_number(text) :].strip()
    own = {unit, unit_text(unit), shown_in, unit_text(shown_in)}
    units = own.union(*(powers for powers in _POWERS if unit in powers))
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

    The unit may be a multiple of the feature's own: `12,5 ms` is 12500 where that is `us`. Without one it is
    the unit `shown_in`, or else the feature's own.
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


def typed_unit(text: str, unit: str) -> str:
    """Return the unit at the end of a typed text, if it is a multiple of `unit`; else nothing."""
    family = next((powers for powers in _POWERS if unit in powers), {})
    return next((name for name in sorted(family, key=len, reverse=True) if text.rstrip().endswith(name)), "")


def typed_value(text: str, feature: Feature) -> FeatureValue:
    """Return what to write for a text from a command line: `20ms` is 20000 where the unit is `us`.

    A text that is no number with a unit is returned unchanged; writing it raises an error with the allowed
    values.
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
    """Return the number before a unit, and by which power of ten that is more than the feature's own unit."""
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


def coded_text(number: int, representation: Representation) -> str:
    """Return an integer as hexadecimal, IPv4 or MAC address; the first octet is the highest byte."""
    if representation is Representation.IPV4_ADDRESS and 0 <= number < 1 << 32:
        return str(ipaddress.IPv4Address(number))
    if representation is Representation.MAC_ADDRESS and 0 <= number < 1 << 48:
        return ":".join(f"{byte:02X}" for byte in number.to_bytes(6, "big"))
    return f"-0x{-number:X}" if number < 0 else f"0x{number:X}"


def parse_coded(text: str, representation: Representation) -> int:
    """Parse a typed integer; also plain or hexadecimal digits. Raises ValueError."""
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


def access_text(feature: Feature) -> str:
    """Return why the feature cannot be written, as the end of a sentence."""
    if feature.problem:
        return translate("Features", "is not available: {0}").format(driver_text(feature.problem))
    if feature.constant:
        return translate("Features", "is read-only")
    if feature.access is AccessMode.NOT_IMPLEMENTED:
        return translate("Features", "is not implemented by this camera")
    if feature.access is AccessMode.NOT_AVAILABLE:
        return translate("Features", "is not available at the moment; another feature's value hides it")
    if feature.access is AccessMode.READ_ONLY:
        return translate("Features", "is read-only; streaming or another feature may lock it")
    return translate("Features", "cannot be used at the moment")


def range_text(feature: Feature) -> str:
    """Return the allowed values: `10 … 1000000 µs, step 1`, `one of Off, Once`."""
    if feature.kind is FeatureKind.ENUMERATION:
        entries = ", ".join(entry.name for entry in feature.entries if entry.available)
        return translate("Features", "one of {0}").format(entries)
    if feature.kind is FeatureKind.BOOLEAN:
        return translate("Features", "true or false")
    if feature.kind is FeatureKind.STRING:
        if feature.maximum_length:
            return counted(
                feature.maximum_length,
                translate("Features", "1 byte of text"),
                translate("Features", "up to {0} bytes of text"),
            )
        return translate("Features", "text")
    if feature.minimum is None or feature.maximum is None:
        return translate("Features", "a number")
    low, high = (localized(format_number(limit)) for limit in (feature.minimum, feature.maximum))
    text = f"{low} … {high} {unit_text(feature.unit)}"
    if feature.increment and feature.increment != 1:
        step = translate("Features", "{0}, step {1}")
        return step.format(text.rstrip(), localized(format_number(feature.increment)))
    return text.rstrip()


def value_text(feature: Feature) -> str:
    """Return the value with its unit, as a read-only row shows it; a dash where there is none."""
    value: FeatureValue | None = feature.value
    if value is None:
        return "–"
    if isinstance(value, bool):
        return translate("Features", "yes") if value else translate("Features", "no")
    if isinstance(value, str):
        return next((e.display_name or e.name for e in feature.entries if e.name == value), value)
    if feature.representation in CODED and isinstance(value, int):
        return coded_text(value, feature.representation)
    return quantity_text(value, feature.unit)


def tooltip_html(feature: Feature) -> str:
    """Return a feature's tooltip: the reason for which it cannot be used, help, range, name."""
    parts = [f"<b>{html.escape(feature.title)}</b>"]
    if not feature.access.writable:
        why = translate("Features", "It {0}.").format(access_text(feature))
        parts.append(f"<i>{html.escape(why)}</i>")
    elif feature.pauses_stream:
        pause = translate("Features", "Changing it pauses the stream for a moment.")
        parts.append(f"<i>{html.escape(pause)}</i>")
    parts.extend(html.escape(text) for text in dict.fromkeys((feature.tooltip, feature.description)) if text)
    if feature.kind is not FeatureKind.COMMAND and not feature.problem:
        if feature.value is not None:
            parts.append(_line(translate("Features", "Value: {0}"), _exact(feature)))
        parts.append(_line(translate("Features", "Range: {0}"), range_text(feature)))
    if feature.selectors:
        parts.append(_line(translate("Features", "Selected by: {0}"), ", ".join(feature.selectors)))
    parts.append(f"<code>{html.escape(feature.name)}</code>")
    return "<br>".join(parts)


def _line(text: str, value: str) -> str:
    return html.escape(text.format(_shortened(value)))


def _exact(feature: Feature) -> str:
    """Return the value with all its digits, which the control may have no room for."""
    text = format_value(feature.value)
    number = isinstance(feature.value, int | float)
    return f"{localized(text) if number else text} {unit_text(feature.unit)}".rstrip()


def _shortened(text: str, length: int = 300) -> str:
    return text if len(text) <= length else text[: length - 1] + "…"
