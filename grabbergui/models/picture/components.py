"""The components of a frame by the labels that a user chooses from."""

from __future__ import annotations

from collections import Counter

from grabbergui.core.component import Component, ComponentKind, own_component
from grabbergui.core.frame import Frame
from grabbergui.models.language import translate

MOST_BESIDE = 9
"""Components that are shown side by side; more would be too small to be seen."""


def labels(frame: Frame) -> tuple[str, ...]:
    """Return the names of a frame's components in the user's language, each once; empty without a choice."""
    if len(frame.parts) < 2:
        return ()
    seen: Counter[str] = Counter()
    found = []
    several = len({part.source for part in frame.parts}) > 1
    for part in frame.parts:
        name = _name(part)
        if several:
            name = translate("Components", "{0}, source {1}").format(name, part.source)
        seen[name] += 1
        found.append(f"{name} {seen[name]}" if seen[name] > 1 else name)
    return tuple(found)


def own_label(frame: Frame) -> str:
    """Return the label of the frame's own image; empty without a choice."""
    own = own_component(frame.parts)
    return next((label for label, part in zip(labels(frame), frame.parts, strict=False) if part is own), "")


def chosen(frame: Frame, label: str) -> Frame:
    """Return the component of that label as a frame; the frame itself for its own image."""
    known = labels(frame)
    if label not in known or label == own_label(frame):
        return frame
    return frame.of_component(frame.parts[known.index(label)])


def beside(labels: tuple[str, ...], label: str) -> tuple[str, ...]:
    """Return the labels of the components to show beside that of `label`, at most `MOST_BESIDE` in all."""
    return tuple(other for other in labels if other != label)[: MOST_BESIDE - 1]


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
