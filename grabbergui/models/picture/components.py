"""The components of a frame by the labels that a user chooses from."""

from __future__ import annotations

from collections import Counter

from grabbergui.core.component import Component, ComponentKind, own_component
from grabbergui.core.frame import Frame
from grabbergui.models.language import translate


def labels(frame: Frame) -> tuple[str, ...]:
    """Return the names of a frame's components in the user's language, each once; empty without a choice."""
    if len(frame.parts) < 2:
        return ()
    seen: Counter[str] = Counter()
    found = []
    for part in frame.parts:
        name = _name(part)
        seen[name] += 1
        found.append(f"{name} {seen[name]}" if seen[name] > 1 else name)
    return tuple(found)


def own_label(frame: Frame) -> str:
    """Return the label of the frame's own image; empty without a choice."""
    own = own_component(frame.parts)
    return next((label for label, part in zip(labels(frame), frame.parts, strict=False) if part is own), "")


def chosen(frame: Frame, label: str) -> Frame:
    """Return the component of that label as a frame; the frame itself where it has none of that label."""
    if not label or len(frame.parts) < 2:
        return frame
    known = labels(frame)
    return frame.of_component(frame.parts[known.index(label)]) if label in known else frame


def _name(part: Component) -> str:
    return {
        ComponentKind.INTENSITY: translate("Components", "Intensity"),
        ComponentKind.INFRARED: translate("Components", "Infrared"),
        ComponentKind.ULTRAVIOLET: translate("Components", "Ultraviolet"),
        ComponentKind.RANGE: translate("Components", "Range"),
        ComponentKind.REFLECTANCE: translate("Components", "Reflectance"),
        ComponentKind.CONFIDENCE: translate("Components", "Confidence"),
        ComponentKind.SCATTER: translate("Components", "Scatter"),
        ComponentKind.DISPARITY: translate("Components", "Disparity"),
        ComponentKind.MULTISPECTRAL: translate("Components", "Multispectral"),
    }.get(part.kind, translate("Components", "Component"))
