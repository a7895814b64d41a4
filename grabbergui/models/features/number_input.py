"""Numbers as people type them, with or without a unit. Pure functions."""

from __future__ import annotations

import math
import re

from grabbergui.core.features import CODED, Feature, FeatureKind, FeatureValue
from grabbergui.models.features.number_text import power_between, unit_family, unit_text

_NUMBER_BEGUN = re.compile(r"[+-]?(?:0[xX][0-9a-fA-F]*|[0-9]*[.,]?[0-9]*(?:[eE][+-]?[0-9]*)?)")
"""A number, or the beginning of one."""


def can_become_number(text: str, unit: str, shown_in: str) -> bool:
    """Return whether typed text is a number or can become one, with a unit of the feature's family.

    The unit that was shown before may still follow it.
    """
    text = text.strip()
    rest = text[_begun_number(text) :].strip()
    units = {unit, unit_text(unit), shown_in, unit_text(shown_in), *unit_family(unit)}
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
    family = unit_family(unit) or ({unit: 0} if unit else {})
    spelt = {power: unit_text(name) for name, power in reversed(family.items())}  # the usual is first
    return tuple(spelt[power] for power in sorted(spelt, reverse=True))


def typed_unit(text: str, unit: str) -> str:
    """Return the unit at the end of a typed text if it belongs to the family of `unit`; else nothing."""
    longest_first = sorted(unit_family(unit), key=len, reverse=True)
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
        return text[: -len(typed)].strip(), power_between(unit, typed)
    for own in (unit, unit_text(unit)):
        if own and text.endswith(own):
            return text[: -len(own)].strip(), 0
    return text, 0


_GROUPED = re.compile(r"[+-]?[0-9]{1,3}(?:(?:,[0-9]{3})+\.[0-9]*|(?:\.[0-9]{3})+,[0-9]*)")
"""Thousands apart from each other by one separator, and a fraction behind the other one."""


def _fraction(text: str) -> float:
    if _GROUPED.fullmatch(text):
        grouping = "," if text.index(",") < text.index(".") else "."
        text = text.replace(grouping, "")
    number = float(text if "." in text else text.replace(",", ".", 1))
    if math.isnan(number):
        raise ValueError("not a number")
    return number
