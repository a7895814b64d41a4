"""The roles of features, under any of the names that cameras give them.

The Standard Feature Naming Convention (SFNC) names come first; older cameras and ROS drivers follow. A role
is what the window's favourites, the YARP feature ids and the ROS 2 services mean when they say "exposure".
"""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum


class Role(Enum):
    """A purpose, and the names cameras have given to it, best first."""

    EXPOSURE = (
        "ExposureTime", "ExposureTimeAbs", "ExposureTimeRaw", "Shutter", "ManualDirectShutter",
        "exposure_time",
    )  # fmt: skip
    GAIN = ("Gain", "GainAbs", "GainRaw", "AnalogGain", "DigitalGain", "gain")
    FRAME_RATE = (
        "AcquisitionFrameRate", "AcquisitionFrameRateAbs", "AcquisitionFrameRateRaw", "FrameRate",
        "SensorFrameRate", "ConstantFrameRate", "frame_rate",
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
        """Feature names in order of preference."""
        names: tuple[str, ...] = self.value
        return names

    def find(self, has: Callable[[str], bool]) -> str | None:
        """The first name for which `has` holds, or None."""
        return next((name for name in self.names if has(name)), None)


FAVOURITES = (Role.EXPOSURE, Role.GAIN, Role.FRAME_RATE)
"""The roles that an operator needs first."""

FILE_ACCESS = frozenset({
    "FileSelector", "FileOperationSelector", "FileOperationExecute", "FileOpenMode", "FileAccessBuffer",
    "FileAccessOffset", "FileAccessLength", "FileOperationStatus", "FileOperationResult", "FileSize",
})  # fmt: skip
"""The features of FileAccessControl, by which files are moved: none is a setting."""

AUTO_OFF = "Off"
AUTO_ONCE = "Once"
AUTO_CONTINUOUS = "Continuous"


def role_of(name: str) -> Role | None:
    """Return the role of a feature of this name; None if it is not known."""
    return next((role for role in Role if name in role.names), None)
