"""What the camera regulates by itself just now. Pure functions."""

from __future__ import annotations

from dataclasses import replace

from grabbergui.core.features import AccessMode, Feature
from grabbergui.core.sfnc import AUTO_OFF


def regulating(auto: Feature | None) -> bool:
    """Whether an automatic mode is on."""
    return auto is not None and auto.value not in (AUTO_OFF, False, None)


def as_editable(feature: Feature, auto: Feature | None) -> Feature:
    """The feature as it is offered for editing.

    One that is locked only because its own automatic mode is on can be written: `write_feature` switches
    the mode off first. Every other lock stays.
    """
    if auto is None or auto.name != feature.auto or feature.access is not AccessMode.READ_ONLY:
        return feature
    if regulating(auto) and auto.access.writable:
        return replace(feature, access=AccessMode.READ_WRITE)
    return feature
