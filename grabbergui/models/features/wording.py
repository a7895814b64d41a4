"""Features in the user's language: value, range, why one cannot be used, all of it as a tooltip.

In English, range and reason are those of `Feature.range_text` and `Feature.access_problem`, with units as
people write them. Pure functions.
"""

from __future__ import annotations

import html

from grabbergui.core.features import (
    AccessMode,
    Feature,
    FeatureKind,
    FeatureValue,
    format_number,
    format_value,
)
from grabbergui.models.features.text import CODED, coded_text, quantity_text, unit_text
from grabbergui.models.language import localized, translate


def access_text(feature: Feature) -> str:
    """Why it cannot be written, as the end of a sentence."""
    if feature.problem:
        return translate("Features", "is not available: {0}").format(feature.problem)
    if feature.constant:
        return translate("Features", "is read-only")
    if feature.access is AccessMode.NOT_IMPLEMENTED:
        return translate("Features", "is not implemented by this camera")
    if feature.access is AccessMode.NOT_AVAILABLE:
        return translate("Features", "is not available just now; another feature's value hides it")
    if feature.access is AccessMode.READ_ONLY:
        return translate("Features", "is read-only; streaming or another feature may lock it")
    return translate("Features", "cannot be used just now")


def range_text(feature: Feature) -> str:
    """What is allowed: `10 … 1000000 µs, step 1`, `one of Off, Once`."""
    if feature.kind is FeatureKind.ENUMERATION:
        entries = ", ".join(entry.name for entry in feature.entries if entry.available)
        return translate("Features", "one of {0}").format(entries)
    if feature.kind is FeatureKind.BOOLEAN:
        return translate("Features", "true or false")
    if feature.kind is FeatureKind.STRING:
        if feature.maximum_length:
            return translate("Features", "up to {0} bytes of text").format(feature.maximum_length)
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
    """The value with its unit, as a read-only row shows it; a dash where there is none."""
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
    """All there is to know about a feature, for a tooltip: why it cannot be used, help, range, name."""
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
    """The value with all its digits, which the control may have no room for."""
    text = format_value(feature.value)
    number = isinstance(feature.value, int | float)
    return f"{localized(text) if number else text} {unit_text(feature.unit)}".rstrip()


def _shortened(text: str, length: int = 300) -> str:
    return text if len(text) <= length else text[: length - 1] + "…"
