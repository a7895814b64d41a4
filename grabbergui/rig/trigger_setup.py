"""Which triggers of a source are on, read from its features."""

from __future__ import annotations

from dataclasses import dataclass

from grabbergui.core.errors import GrabberError
from grabbergui.core.feature_source import FeatureSource
from grabbergui.core.features import FeatureValue
from grabbergui.core.settings import Selected, SettingKey

RIG_SOURCE = "RigTriggerSource"
"The source of a rig's trigger; empty if its cameras run freely."
SELECTOR = "TriggerSelector"


@dataclass(frozen=True)
class TriggerSetup:
    """A trigger that is on."""

    source: str = ""
    "TriggerSource: `Line1`, `Software`; empty if the camera does not say."
    selector: str = ""
    "TriggerSelector: `FrameStart`; empty if the camera has one trigger."
    activation: str = "RisingEdge"
    software: bool = False
    "Whether software can send it."

    @property
    def selected(self) -> Selected:
        """The selector's entry, for the settings of this trigger."""
        return ((SELECTOR, self.selector),) if self.selector else ()


def triggers_on(grabber: FeatureSource) -> tuple[TriggerSetup, ...]:
    """Return the triggers that are on, those of whole acquisitions before those of frames.

    Features that cannot be read are left out. Where the selector cannot be switched, as without control, the
    selected trigger counts.
    """
    if source := _value(grabber, SettingKey(RIG_SOURCE)):
        return (TriggerSetup(str(source), software=source in ("Software", "Action")),)
    if not grabber.has_feature("TriggerMode"):
        return ()
    found = [_setup(grabber, entry) for entry in _selectors(grabber)]
    return tuple(setup for setup in found if setup is not None)


def _selectors(grabber: FeatureSource) -> list[str]:
    """Return the entries of the selector, in the order in which their triggers are waited for."""
    try:
        if not grabber.has_feature(SELECTOR):
            return [""]
        feature = grabber.feature(SELECTOR)
    except GrabberError:
        return [""]
    names = [entry.name for entry in feature.entries if entry.available]
    if not feature.access.writable or len(names) < 2:
        return [""] if feature.value is None else [str(feature.value)]
    return sorted(names, key=lambda name: (not name.startswith("Acquisition"), "Burst" not in name))


def _setup(grabber: FeatureSource, selector: str) -> TriggerSetup | None:
    selected: Selected = ((SELECTOR, selector),) if selector else ()
    if _value(grabber, SettingKey("TriggerMode", selected)) != "On":
        return None
    source = _value(grabber, SettingKey("TriggerSource", selected))
    return TriggerSetup(
        "" if source is None else str(source),
        selector,
        str(_value(grabber, SettingKey("TriggerActivation", selected)) or "RisingEdge"),
        software=source in (None, "Software") and grabber.has_feature("TriggerSoftware"),
    )


def _value(grabber: FeatureSource, key: SettingKey) -> FeatureValue | None:
    try:
        return grabber.read_setting(key).value if grabber.has_feature(key.name) else None
    except GrabberError:
        return None
