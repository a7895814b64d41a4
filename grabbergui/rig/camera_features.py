"""The features of a rig: those of its cameras, each behind its camera's name, and its own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TypeVar

from grabbergui.core.features import Category, Feature, FeatureDescription, FeatureKind, FeatureValue
from grabbergui.core.grabber import FrameGrabber
from grabbergui.rig.set_statistics import SetCounts
from grabbergui.rig.trigger_setup import RIG_SOURCE

SEPARATOR = "."
"Between the name of a camera and that of its feature: `left.ExposureTime`."
SEND = "RigTriggerSend"
_CATEGORY = "RigControl"

Described = TypeVar("Described", bound=FeatureDescription)


def _own(name: str, kind: FeatureKind, title: str, tooltip: str) -> FeatureDescription:
    return FeatureDescription(name=name, kind=kind, category=_CATEGORY, display_name=title, tooltip=tooltip)


OWN = {
    each.name: each
    for each in (
        _own("RigSetsComplete", FeatureKind.INTEGER, "Complete Sets", "Sets with a frame of every camera."),
        _own("RigSetsLate", FeatureKind.INTEGER, "Late Sets", "Complete sets that took longer."),
        _own("RigSetsIncomplete", FeatureKind.INTEGER, "Incomplete Sets", "Sets without a camera's frame."),
        _own("RigSkewMedian", FeatureKind.FLOAT, "Skew (Median)", "Time within a set, of half of the sets."),
        _own("RigSkewP99", FeatureKind.FLOAT, "Skew (p99)", "Time within a set, of 99 % of the sets."),
        _own("RigSkewWorst", FeatureKind.FLOAT, "Skew (Worst)", "The longest time within a set."),
        _own("RigTriggersSent", FeatureKind.INTEGER, "Triggers Sent", "Triggers sent by the rig."),
        _own("RigTriggersMissed", FeatureKind.INTEGER, "Triggers Missed", "Triggers that a camera refused."),
        _own(RIG_SOURCE, FeatureKind.STRING, "Trigger", "What triggers the cameras; empty: they run freely."),
        _own(SEND, FeatureKind.COMMAND, "Send Trigger", "Trigger all cameras once."),
    )
}
"The rig's own features by name."


def own_values(counts: SetCounts, sent: int, missed: int, source: str) -> dict[str, FeatureValue]:
    """Return the values of the rig's own features."""
    return {
        "RigSetsComplete": counts.complete,
        "RigSetsLate": counts.late,
        "RigSetsIncomplete": counts.incomplete,
        "RigSkewMedian": counts.skew_median_ns / 1000,
        "RigSkewP99": counts.skew_p99_ns / 1000,
        "RigSkewWorst": counts.skew_worst_ns / 1000,
        "RigTriggersSent": sent,
        "RigTriggersMissed": missed,
        RIG_SOURCE: source,
    }


def tree_of(cameras: Mapping[str, FrameGrabber]) -> Category:
    """Return the root category: the rig's own, and one for each camera."""
    own = Category(_CATEGORY, "Rig", members=tuple(OWN.values()))
    members = (_category(name, grabber.feature_tree(), top=True) for name, grabber in cameras.items())
    return Category("Root", members=(own, *members))


def _category(camera: str, category: Category, *, top: bool = False) -> Category:
    members = tuple(
        _category(camera, member) if isinstance(member, Category) else named(camera, member)
        for member in category.members
    )
    name = prefixed(camera, category.name)
    return replace(category, name=name, display_name=camera if top else category.title, members=members)


def prefixed(camera: str, name: str) -> str:
    """Return the name of a camera's feature in the rig."""
    return f"{camera}{SEPARATOR}{name}"


def named(camera: str, feature: Described) -> Described:
    """Return a camera's feature, or its description, as the rig has it."""
    made = replace(
        feature,
        name=prefixed(camera, feature.name),
        display_name=feature.title,
        category=prefixed(camera, feature.category),
        selectors=tuple(prefixed(camera, selector) for selector in feature.selectors),
    )
    if isinstance(made, Feature) and made.auto is not None:
        made = replace(made, auto=prefixed(camera, made.auto))
    return made


def split(name: str, cameras: Mapping[str, FrameGrabber]) -> tuple[FrameGrabber, str] | None:
    """Return the camera of a feature and its name there; None for the rig's own and unknown ones."""
    camera, separator, feature = name.partition(SEPARATOR)
    grabber = cameras.get(camera)
    return (grabber, feature) if separator and grabber is not None else None
