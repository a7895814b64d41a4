"""Features as the window shows them: which of them, and their values, ranges and tooltips as display text.

In English, the texts are those of `Feature.range_text` and `Feature.access_problem`, but with typographic
units. Pure functions.
"""

from __future__ import annotations

import re
from dataclasses import replace

from grabbergui.core.features import (
    CODED,
    TRANSPORT_LOCK,
    AccessMode,
    Feature,
    FeatureKind,
    FeatureValue,
    coded_text,
    format_number,
)
from grabbergui.core.visible_text import shortened
from grabbergui.models.features.number_text import quantity_text, unit_text
from grabbergui.models.language import counted, driver_text, localized, translate
from grabbergui.models.markup import Markup, joined, markup

_LOWER_UPPER = re.compile(r"(?<=[a-z0-9])(?=[A-Z])")
_ZERO_WIDTH_SPACE = "\u200b"
MOST_VALUE = 300
"Characters of a value, a name or a range in a tooltip."
MOST_HELP = 2000
"Characters of each of the camera's own texts in a tooltip."


def breakable(title: str) -> str:
    """Return a title that can be broken into lines between the words of a CamelCase name."""
    return _LOWER_UPPER.sub(_ZERO_WIDTH_SPACE, title)


def access_text(feature: Feature) -> str:
    """Return why the feature cannot be written, as the end of a sentence."""
    if feature.problem:
        return translate("Features", "is not available: {0}").format(driver_text(feature.problem))
    if feature.constant:
        return translate("Features", "is read-only")
    if feature.access is AccessMode.NOT_IMPLEMENTED:
        return translate("Features", "is not implemented by this camera")
    if feature.conditions:
        return _condition_text(feature)
    if feature.access is AccessMode.NOT_AVAILABLE:
        return translate("Features", "is not available at the moment; another feature's value hides it")
    if feature.access is AccessMode.READ_ONLY:
        return translate("Features", "is read-only; streaming or another feature may lock it")
    return translate("Features", "cannot be used at the moment")


def _condition_text(feature: Feature) -> str:
    """Return which values hide or lock the feature, and what to set instead."""
    hidden = feature.access is AccessMode.NOT_AVAILABLE
    if any(each.feature == TRANSPORT_LOCK for each in feature.conditions):
        if hidden:
            return translate("Features", "is not available while the camera streams; stop it first")
        return translate("Features", "is read-only while the camera streams; stop it first")
    conjunction = translate("Features", " and ")
    held = conjunction.join(
        translate("Features", "{0} is {1}").format(each.feature, each.value) for each in feature.conditions
    )
    if not all(each.wanted for each in feature.conditions):
        if hidden:
            text = translate("Features", "is not available at the moment; it depends on other features: {0}")
        else:
            text = translate("Features", "is read-only at the moment; it depends on other features: {0}")
        return text.format(held)
    remedy = conjunction.join(
        translate("Features", "{0} to {1}").format(
            each.feature, translate("Features", " or ").join(each.wanted)
        )
        for each in feature.conditions
    )
    if hidden:
        return translate("Features", "is not available while {0}; set {1}").format(held, remedy)
    return translate("Features", "is read-only while {0}; set {1}").format(held, remedy)


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


def limit_text(feature: Feature, typed: int | float, taken: int | float) -> str:
    """Return why another number was taken than was typed; empty if that is only its rounding."""
    taken_text = value_text(replace(feature, value=taken))
    if feature.minimum is not None and typed < feature.minimum:
        return translate("Features", "At least {0}").format(taken_text)
    if feature.maximum is not None and typed > feature.maximum:
        return translate("Features", "At most {0}").format(taken_text)
    if feature.kind is FeatureKind.INTEGER and taken != round(typed):
        return translate("Features", "Only in steps of {0}").format(feature.increment)
    return ""


def value_text(feature: Feature) -> str:
    """Return the value with its unit, as a read-only row shows it; a dash without a value."""
    value: FeatureValue | None = feature.value
    if value is None:
        return "–"
    if isinstance(value, bool):
        return translate("Features", "yes") if value else translate("Features", "no")
    if isinstance(value, str):
        known = next((e.title for e in feature.entries if e.name == value), value)
        return shortened(known, MOST_HELP)
    if feature.representation in CODED and isinstance(value, int):
        return coded_text(value, feature.representation)
    return quantity_text(value, feature.unit)


def tooltip(feature: Feature) -> Markup:
    """Return a feature's tooltip: why it cannot be used, help, range, name."""
    parts: list[str] = [markup("<b>{0}</b>", feature.title)]
    if not feature.access.writable:
        why = translate("Features", "It {0}.").format(access_text(feature))
        parts.append(markup("<i>{0}</i>", why))
    elif feature.pauses_stream:
        pause = translate("Features", "Changing it pauses the stream for a moment.")
        parts.append(markup("<i>{0}</i>", pause))
    parts += [shortened(text, MOST_HELP) for text in _help(feature)]
    if feature.kind is not FeatureKind.COMMAND and not feature.problem:
        if feature.value is not None:
            parts.append(_line(translate("Features", "Value: {0}"), _exact(feature)))
        parts.append(_line(translate("Features", "Range: {0}"), range_text(feature)))
    if feature.selectors:
        parts.append(_line(translate("Features", "Selected by: {0}"), ", ".join(feature.selectors)))
    parts.append(markup("<code>{0}</code>", shortened(feature.name, MOST_VALUE)))
    return joined(parts, "<br>")


def _help(feature: Feature) -> list[str]:
    """Return the camera's tooltip and description, without a tooltip that the description repeats."""
    tooltip, description = feature.tooltip.strip(), feature.description.strip()
    repeated = description.startswith(tooltip.rstrip("."))
    return [text for text in ("" if repeated else tooltip, description) if text]


def _line(text: str, value: str) -> str:
    return text.format(shortened(value, MOST_VALUE))


def _exact(feature: Feature) -> str:
    """Return the value with all its digits, for which the control may lack room."""
    text = feature.text
    number = isinstance(feature.value, int | float) and not feature.coded
    return f"{localized(text) if number else text} {unit_text(feature.unit)}".rstrip()
