"""The companions of a feature: the automatic mode that regulates it, and the switch that makes it act.

`ExposureTime` has the mode `ExposureAuto`, `AcquisitionFrameRate` the switch `AcquisitionFrameRateEnable`
(SFNC; older cameras use other names). Which companions a feature has, what must be written to them before it,
and whether one of them makes it read-only is decided here alone.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

from grabbergui.core.features import AccessMode, Feature, FeatureKind, FeatureValue
from grabbergui.core.sfnc import AUTO_OFF, Role

_AUTOMATIC = {
    Role.EXPOSURE: ("ExposureAuto",),
    Role.GAIN: ("GainAuto",),
    Role.FRAME_RATE: ("AcquisitionFrameRateAuto",),
    Role.BLACK_LEVEL: ("BlackLevelAuto",),
    Role.BALANCE_RATIO: ("BalanceWhiteAuto",),
}
_MODES_OF = {name: modes for role, modes in _AUTOMATIC.items() for name in role.names}
_FORMS = ("Abs", "Raw")
"Endings of the pre-SFNC names of one quantity; its companions are named without them."

Has = Callable[[str], bool]
"Whether the camera has a feature of this name."


@dataclass(frozen=True)
class Companions:
    """The names of a feature's companions; None where it has none."""

    mode: str | None = None
    enabler: str | None = None

    @classmethod
    def of(cls, name: str, has: Has) -> Companions:
        """Find the companions of the feature `name` on a camera."""
        return cls(automatic_mode_of(name, has), enabler_of(name, has))

    @property
    def names(self) -> tuple[str, ...]:
        """Those that exist."""
        return tuple(name for name in (self.mode, self.enabler) if name is not None)


def automatic_mode_of(name: str, has: Has) -> str | None:
    """Return the feature that regulates `name` (`ExposureAuto` for `ExposureTime`), if there is one."""
    candidates = (*_MODES_OF.get(name, ()), f"{_quantity(name)}Auto")
    return next((candidate for candidate in candidates if has(candidate)), None)


def enabler_of(name: str, has: Has) -> str | None:
    """Return the switch that makes `name` act (`AcquisitionFrameRateEnable`), if there is one."""
    quantity = _quantity(name)
    return next((found for found in (f"{quantity}Enable", f"{quantity}Enabled") if has(found)), None)


def regulated_by_mode(names: Iterable[str], has: Has) -> dict[str, list[str]]:
    """Return the automatic modes of these features, and which of the features each of them regulates."""
    found: dict[str, list[str]] = {}
    for name in names:
        if (mode := automatic_mode_of(name, has)) is not None:
            found.setdefault(mode, []).append(name)
    return found


def is_on(value: FeatureValue | None) -> bool:
    """Whether an automatic mode or a switch with this value is on."""
    return value not in (AUTO_OFF, False, None)


def regulating(mode: Feature | None) -> bool:
    """Whether an automatic mode is on."""
    return mode is not None and is_on(mode.value)


def offers(feature: Feature, entry: str) -> bool:
    """Whether a feature is an enumeration with this entry."""
    return feature.kind is FeatureKind.ENUMERATION and any(entry == known.name for known in feature.entries)


def switched_off(mode: Feature) -> tuple[str, FeatureValue] | None:
    """Return the write that switches an automatic mode off; None where it is off, or cannot be switched."""
    if not regulating(mode) or not mode.access.writable:
        return None
    if mode.kind is FeatureKind.BOOLEAN:
        return mode.name, False
    can_be_off = any(entry.name == AUTO_OFF and entry.available for entry in mode.entries)
    return (mode.name, AUTO_OFF) if can_be_off else None


def switched_on(enabler: Feature) -> tuple[str, FeatureValue] | None:
    """Return the write that turns a feature's switch on; None where it is on, or cannot be switched."""
    off = enabler.kind is FeatureKind.BOOLEAN and enabler.value is False
    return (enabler.name, True) if off and enabler.access.writable else None


def as_editable(feature: Feature, mode: Feature | None) -> Feature:
    """Return the feature as it is offered for editing.

    A feature that is read-only only because its own automatic mode is on can be written: `write_feature`
    switches the mode off first. Every other lock stays.
    """
    if mode is None or mode.name != feature.auto or feature.access is not AccessMode.READ_ONLY:
        return feature
    if regulating(mode) and mode.access.writable:
        return replace(feature, access=AccessMode.READ_WRITE)
    return feature


def _quantity(name: str) -> str:
    for form in _FORMS:
        if name.endswith(form) and name != form:
            return name.removesuffix(form)
    return name
