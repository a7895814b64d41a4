"""Frames as YARP images: in colour for most readers, or as the sensor has them."""

from __future__ import annotations

from enum import Enum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.frame import Frame
from grabbergui.net.yarp import image
from grabbergui.net.yarp.os.bottle import Bottle

Picture = tuple[NDArray[Any], str]
"""Pixels and YARP's code for them."""

_INTERLEAVED = {"RGB": "rgb", "BGR": "bgr", "RGBa": "rgba", "BGRa": "bgra"}


class Capability(Enum):
    """Which of YARP's two image interfaces a port offers."""

    COLOR = "COLOR"
    "RGB, whatever the sensor is."
    RAW = "RAW"
    "The sensor's own values; Bayer patterns as mono, which is what YARP's raw readers expect."

    def picture(self, frame: Frame) -> Picture:
        """The frame's pixels for this interface. Raises PixelFormatError."""
        return (frame.rgb(), "rgb") if self is Capability.COLOR else _raw(frame)

    def encode(self, frame: Frame) -> tuple[bytes, memoryview]:
        """The frame as an image message. Raises PixelFormatError."""
        return image.encode(*self.picture(frame))

    def item(self, frame: Frame, box: tuple[int, int, int, int] | None = None) -> Bottle:
        """The frame, or its part (left, top, right, bottom), as an item of a reply."""
        pixels, code = self.picture(frame)
        if box is not None:
            left, top, right, bottom = box
            pixels = pixels[top:bottom, left:right]
        return image.to_bottle(*image.encode(pixels, code))


def _raw(frame: Frame) -> Picture:
    pixels = frame.raw()
    if pixels.ndim == 2:
        return (pixels, "mono") if pixels.dtype == np.uint8 else (pixels.astype("<u2", copy=False), "mo16")
    code = _INTERLEAVED.get(frame.pixel_format.order)
    return (pixels, code) if code else (frame.rgb(), "rgb")
