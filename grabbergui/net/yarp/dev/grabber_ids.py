"""The numbers of YARP's frame grabber interfaces (IFrameGrabberControls, IFrameGrabberImage)."""

from __future__ import annotations

from enum import IntEnum


class FeatureId(IntEnum):
    """What a camera may have, by YARP's count; the same in 3.x and 4.0."""

    BRIGHTNESS = 0
    EXPOSURE = 1
    SHARPNESS = 2
    WHITE_BALANCE = 3
    "Two values: red, blue."
    HUE = 4
    SATURATION = 5
    GAMMA = 6
    SHUTTER = 7
    GAIN = 8
    IRIS = 9
    FOCUS = 10
    TEMPERATURE = 11
    TRIGGER = 12
    TRIGGER_DELAY = 13
    WHITE_SHADING = 14
    FRAME_RATE = 15
    ZOOM = 16
    PAN = 17
    TILT = 18
    OPTICAL_FILTER = 19
    CAPTURE_SIZE = 20
    CAPTURE_QUALITY = 21
    MIRROR = 22


def label(number: int) -> str:
    """What a feature's number means, for people."""
    try:
        return FeatureId(number).name.lower().replace("_", " ")
    except ValueError:
        return f"feature number {number}"


class FeatureMode(IntEnum):
    """Who regulates a feature."""

    UNKNOWN = 0
    MANUAL = 1
    AUTO = 2


class BusType(IntEnum):
    """How a camera is attached; YARP knows no Ethernet."""

    UNKNOWN = 0
    FIREWIRE = 1
    USB = 2


class CropType(IntEnum):
    """What the vertices of a crop request mean."""

    RECTANGLE = 0
    "Two opposite corners, both within the picture cut out."
    LIST = 1
