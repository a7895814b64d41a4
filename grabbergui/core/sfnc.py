"""The roles of features under their various names, and the companions of features.

A role is what the window's favourites, the YARP feature ids and the ROS 2 services mean by "exposure". Names
of the Standard Feature Naming Convention (SFNC) come first, those of older cameras and ROS drivers follow.

A companion is the automatic mode that regulates a feature, or its enabler: `ExposureTime` has the mode
`ExposureAuto`, `AcquisitionFrameRate` the enabler `AcquisitionFrameRateEnable` (SFNC; older cameras use other
names). `ExposureMode`, which must be `Timed` for the exposure time to act, is one too. Only this module
decides which companions a feature has, what must be written to them before it, and whether one of them makes
it read-only.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from enum import Enum

from grabbergui.core.features import AccessMode, Feature, FeatureDescription, FeatureKind, FeatureValue

FILE_ACCESS = frozenset({
    "FileSelector", "FileOperationSelector", "FileOperationExecute", "FileOpenMode", "FileAccessBuffer",
    "FileAccessOffset", "FileAccessLength", "FileOperationStatus", "FileOperationResult", "FileSize",
})  # fmt: skip
"""The features of FileAccessControl, which transfer files. None is a setting."""
PLAYBACK_POSITION = "PlaybackPosition"
"""Our own feature of recordings: the frame shown. It moves by itself while the recording plays."""
EXPOSURE_MODE, TIMED = "ExposureMode", "Timed"
"The feature that selects how exposure is controlled (SFNC), and its entry for control by ExposureTime."
AUTO_OFF = "Off"
AUTO_ONCE = "Once"
AUTO_CONTINUOUS = "Continuous"
_ENDINGS = ("Abs", "Raw")
"Endings of a quantity's pre-SFNC names, which its companions' names omit."
Has = Callable[[str], bool]
"Whether the camera has a feature of this name."


class Role(Enum):
    """The purpose of a feature, with its names in cameras, best first."""

    EXPOSURE = (
        "ExposureTime", "ExposureTimeAbs", "ExposureTimeRaw", "Shutter", "ManualDirectShutter",
        "exposure_time",
    )  # fmt: skip
    GAIN = ("Gain", "GainAbs", "GainRaw", "AnalogGain", "DigitalGain")
    FRAME_RATE = (
        "AcquisitionFrameRate", "AcquisitionFrameRateAbs", "AcquisitionFrameRateRaw", "FrameRate",
        "SensorFrameRate", "ConstantFrameRate", "FPS", "frame_rate",
        "AcquisitionLineRate", "AcquisitionLineRateAbs",
    )  # fmt: skip
    BLACK_LEVEL = ("BlackLevel", "BlackLevelAbs", "BlackLevelRaw", "Brightness")
    GAMMA = ("Gamma", "GammaAbs", "GammaRaw")
    BALANCE_RATIO = ("BalanceRatio", "BalanceRatioAbs", "BalanceRatioRaw")
    WIDTH = ("Width",)
    HEIGHT = ("Height",)
    PIXEL_FORMAT = ("PixelFormat",)
    TEMPERATURE = ("DeviceTemperature", "TemperatureAbs", "DeviceTemperatureRaw", "Temperature")
    SHARPNESS = ("Sharpness", "Sharpening", "SharpnessRaw", "SharpnessEnhancement")
    HUE = ("Hue", "HueAbs", "HueRaw")
    SATURATION = ("Saturation", "SaturationAbs", "SaturationRaw", "ColorSaturation")
    IRIS = ("Iris", "IrisPosition", "Aperture")
    FOCUS = ("Focus", "FocusPosition", "FocusPos")
    ZOOM = ("Zoom", "ZoomPosition")
    PAN = ("Pan", "PanPosition")
    TILT = ("Tilt", "TiltPosition")
    TRIGGER = ("TriggerMode",)
    TRIGGER_DELAY = ("TriggerDelay", "TriggerDelayAbs", "TriggerDelayRaw")
    SHADING = ("WhiteShading", "ShadingCorrection", "FlatFieldCorrection")
    OPTICAL_FILTER = ("OpticalFilter", "FilterPosition")
    CAPTURE_SIZE = ("CaptureSize",)
    CAPTURE_QUALITY = ("CaptureQuality", "ImageCompressionQuality")
    MIRROR = ("ReverseX", "Mirror")

    @property
    def names(self) -> tuple[str, ...]:
        """Feature names in order of preference; cameras may write them in other letter case."""
        names: tuple[str, ...] = self.value
        return names

    def accepts(self, kind: FeatureKind) -> bool:
        """Return whether a feature of this kind can have the role: no Boolean is a frame rate."""
        if self in _SWITCHES:
            return kind is not FeatureKind.COMMAND
        return kind in (FeatureKind.INTEGER, FeatureKind.FLOAT, FeatureKind.ENUMERATION)


_SWITCHES = (Role.TRIGGER, Role.SHADING, Role.OPTICAL_FILTER, Role.MIRROR)
"Roles that a Boolean can have."
_RANKS = {name.lower(): (role, rank) for role in Role for rank, name in enumerate(role.names)}


def features_by_role(features: Iterable[FeatureDescription]) -> dict[Role, str]:
    """Return the names of the features that have a role on a camera, numbers before enumerations."""
    best: dict[Role, tuple[bool, int, str]] = {}
    for feature in features:
        role, rank = _RANKS.get(feature.name.lower(), (None, 0))
        if role is not None and role.accepts(feature.kind):
            found = (feature.kind is FeatureKind.ENUMERATION, rank, feature.name)
            best[role] = min(best.get(role, found), found)
    return {role: name for role, (_, _, name) in best.items()}


FAVOURITES = (Role.EXPOSURE, Role.GAIN, Role.FRAME_RATE)
"""The roles that an operator needs first."""


def role_of(name: str) -> Role | None:
    """Return the role of a feature by its name; None if the name is unknown."""
    role, _ = _RANKS.get(name.lower(), (None, 0))
    return role


_AUTOMATIC = {
    Role.EXPOSURE: ("ExposureAuto",),
    Role.GAIN: ("GainAuto",),
    Role.FRAME_RATE: ("AcquisitionFrameRateAuto",),
    Role.BLACK_LEVEL: ("BlackLevelAuto",),
    Role.BALANCE_RATIO: ("BalanceWhiteAuto",),
}


@dataclass(frozen=True)
class Companions:
    """The names of a feature's companions; None if it has none."""

    mode: str | None = None
    enabler: str | None = None
    operation: str | None = None
    "The feature that says what determines the quantity, `ExposureMode`."

    @classmethod
    def of(cls, name: str, has: Has) -> Companions:
        """Find the companions of the feature `name` on a camera."""
        operation = EXPOSURE_MODE if role_of(name) is Role.EXPOSURE and has(EXPOSURE_MODE) else None
        return cls(automatic_mode_of(name, has), enabler_of(name, has), operation)

    @property
    def names(self) -> tuple[str, ...]:
        """Those that exist."""
        return tuple(name for name in (self.mode, self.enabler, self.operation) if name is not None)

    def impedes(self, companion: str, value: FeatureValue | None) -> bool:
        """Return whether a companion with this value keeps the feature from being written or acting."""
        if companion == self.operation:
            return value not in (TIMED, None)
        return is_on(value) == (companion == self.mode)


def automatic_mode_of(name: str, has: Has) -> str | None:
    """Return the feature that regulates `name` (`ExposureAuto` for `ExposureTime`), if there is one."""
    role = role_of(name)
    candidates = (*(_AUTOMATIC.get(role, ()) if role else ()), f"{_quantity(name)}Auto")
    return next((candidate for candidate in candidates if has(candidate)), None)


def enabler_of(name: str, has: Has) -> str | None:
    """Return the enabler of `name` (`AcquisitionFrameRateEnable`), if there is one."""
    quantity = _quantity(name)
    return next((found for found in (f"{quantity}Enable", f"{quantity}Enabled") if has(found)), None)


def regulated_by_mode(names: Iterable[str], has: Has) -> dict[str, list[str]]:
    """Map the automatic modes of these features to the features that each regulates."""
    found: dict[str, list[str]] = {}
    for name in names:
        if (mode := automatic_mode_of(name, has)) is not None:
            found.setdefault(mode, []).append(name)
    return found


def is_on(value: FeatureValue | None) -> bool:
    """Return whether an automatic mode or enabler with this value is on."""
    return value not in (AUTO_OFF, False, None)


def regulating(mode: Feature | None) -> bool:
    """Return whether an automatic mode is on."""
    return mode is not None and is_on(mode.value)


def offers(feature: Feature, entry: str) -> bool:
    """Return whether a feature is an enumeration with this entry."""
    return feature.kind is FeatureKind.ENUMERATION and any(entry == known.name for known in feature.entries)


def switched_off(mode: Feature) -> tuple[str, FeatureValue] | None:
    """Return the write that switches an automatic mode off; None if it is off or cannot be switched."""
    if not regulating(mode) or not mode.access.writable:
        return None
    if mode.kind is FeatureKind.BOOLEAN:
        return mode.name, False
    return switched_to(mode, AUTO_OFF)


def switched_on(enabler: Feature) -> tuple[str, FeatureValue] | None:
    """Return the write that switches an enabler on; None if it is on or cannot be switched."""
    off = enabler.kind is FeatureKind.BOOLEAN and enabler.value is False
    return (enabler.name, True) if off and enabler.access.writable else None


def switched_to(feature: Feature, entry: str) -> tuple[str, FeatureValue] | None:
    """Return the write that chooses an entry; None if it is chosen or cannot be."""
    can = feature.access.writable and any(e.name == entry and e.available for e in feature.entries)
    return (feature.name, entry) if can and feature.value != entry else None


def as_editable(feature: Feature, mode: Feature | None) -> Feature:
    """Return the feature with the access to offer for editing.

    A feature that is read-only because its own automatic mode is on can be written, as `write_feature`
    switches the mode off first. Every other lock stays.
    """
    if mode is None or mode.name != feature.auto or feature.access is not AccessMode.READ_ONLY:
        return feature
    if regulating(mode) and mode.access.writable:
        return replace(feature, access=AccessMode.READ_WRITE)
    return feature


def _quantity(name: str) -> str:
    for ending in _ENDINGS:
        if name.endswith(ending) and name != ending:
            return name.removesuffix(ending)
    return name
