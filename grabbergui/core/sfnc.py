"""What features are for, whatever a camera calls them.

The Standard Feature Naming Convention (SFNC) names come first; older cameras follow. A role is what the
window's favourites, the YARP feature ids and the ROS 2 services mean when they say "exposure".
"""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum


class Role(Enum):
    """A purpose, and the names cameras have given to it, best first."""

    EXPOSURE = ("ExposureTime", "ExposureTimeAbs", "ExposureTimeRaw", "Shutter")
    GAIN = ("Gain", "GainAbs", "GainRaw")
    FRAME_RATE = ("AcquisitionFrameRate", "AcquisitionFrameRateAbs", "AcquisitionFrameRateRaw", "FrameRate")
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
        """Feature names in order of preference."""
        names: tuple[str, ...] = self.value
        return names

    def find(self, has: Callable[[str], bool]) -> str | None:
        """The first name for which `has` holds, or None."""
        return next((name for name in self.names if has(name)), None)


FAVOURITES = (Role.EXPOSURE, Role.GAIN, Role.FRAME_RATE)
"""What an operator reaches for first."""

_AUTOMATIC = {
    Role.EXPOSURE: ("ExposureAuto",),
    Role.GAIN: ("GainAuto",),
    Role.FRAME_RATE: ("AcquisitionFrameRateAuto",),
    Role.BLACK_LEVEL: ("BlackLevelAuto",),
    Role.BALANCE_RATIO: ("BalanceWhiteAuto",),
}

_AUTO_OF = {name: autos for role, autos in _AUTOMATIC.items() for name in role.names}

AUTO_OFF = "Off"
AUTO_ONCE = "Once"
AUTO_CONTINUOUS = "Continuous"

_FORMS = ("Abs", "Raw")
"""Endings of the pre-SFNC names of one knob's forms; what belongs to the knob is named without them."""


def automatic_mode_of(name: str, has: Callable[[str], bool]) -> str | None:
    """The feature that regulates `name` by itself (`ExposureAuto` for `ExposureTime`), if there is one."""
    candidates = (*_AUTO_OF.get(name, ()), f"{_knob(name)}Auto")
    return next((candidate for candidate in candidates if has(candidate)), None)


def enabler_of(name: str, has: Callable[[str], bool]) -> str | None:
    """The switch that must be on for `name` to act (`AcquisitionFrameRateEnable`), if there is one."""
    knob = _knob(name)
    return next((candidate for candidate in (f"{knob}Enable", f"{knob}Enabled") if has(candidate)), None)


def role_of(name: str) -> Role | None:
    """What a feature of this name is for, where we know."""
    return next((role for role in Role if name in role.names), None)


def _knob(name: str) -> str:
    for form in _FORMS:
        if name.endswith(form) and name != form:
            return name.removesuffix(form)
    return name
