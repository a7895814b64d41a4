"""The components of a frame: their labels, and which of them are shown."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

from grabbergui.core.calibration import Calibration
from grabbergui.core.component import Component, ComponentKind, own_component
from grabbergui.core.frame import Frame
from grabbergui.core.pixels import DisplayImage
from grabbergui.models.image.quantities import Quantity
from grabbergui.models.language import translate

MOST_BESIDE = 9
"""Most components side by side; more would be too small to see."""


def labels(frame: Frame) -> tuple[str, ...]:
    """Return unique labels of a frame's components in the user's language; empty if it has only one."""
    if len(frame.parts) < 2:
        return ()
    seen: Counter[str] = Counter()
    found = []
    several = len({part.source for part in frame.parts}) > 1
    for part in frame.parts:
        name = _name(part)
        if part.camera:
            name = part.camera if part.kind is ComponentKind.INTENSITY else f"{part.camera}, {name}"
        elif several:
            name = translate("Components", "{0}, source {1}").format(name, part.source)
        seen[name] += 1
        found.append(f"{name} {seen[name]}" if seen[name] > 1 else name)
    return tuple(found)


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


def own_label(frame: Frame) -> str:
    """Return the label of the frame's own image; empty if the frame has only one component."""
    own = own_component(frame.parts)
    return next((label for label, part in zip(labels(frame), frame.parts, strict=False) if part is own), "")


def chosen(frame: Frame, label: str) -> Frame:
    """Return the component with this label as a frame; the frame itself for its own image."""
    known = labels(frame)
    if label not in known or label == own_label(frame):
        return frame
    return frame.of_component(frame.parts[known.index(label)])


def beside(labels: tuple[str, ...], label: str) -> tuple[str, ...]:
    """Return the labels of the components to show beside `label`, at most `MOST_BESIDE` in all."""
    return tuple(other for other in labels if other != label)[: MOST_BESIDE - 1]


@dataclass(frozen=True, eq=False)
class ShownImage:
    """A frame and its visible part, ready to be painted."""

    frame: Frame
    "The component that is shown, as a frame of its own."
    image: DisplayImage
    width: int
    height: int
    "Width and height of the whole view, exchanged if it is turned on its side."
    labels: tuple[str, ...] = ()
    "The components to choose from; empty if there is only one."
    label: str = ""
    "The component that is shown, one of `labels`."
    quantity: Quantity | None = None
    "The quantity that the colours represent; None for light."
    calibration: Calibration | None = None
    "The calibration by which it is shown undistorted; None if it is shown as it is."
    others: tuple[ShownImage, ...] = ()
    "The same part of the other components; empty unless all are shown side by side."
