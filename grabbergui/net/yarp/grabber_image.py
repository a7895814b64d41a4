"""The images that a frame grabber sends of a frame: RGB, or raw, by the capability that was asked for."""

from __future__ import annotations

from enum import Enum
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import Family
from grabbergui.net.yarp.image import encode, to_bottle
from grabbergui.net.yarp.os.bottle import Bottle

PixelsAndCode = tuple[NDArray[Any], str]
"""Pixels and YARP's code for them."""

PIXELS: Final = "pixels"
"""Our modifier of carriers; others ignore it. `fast_tcp+pixels.mono` asks for images without colour as [mono]
where everybody else gets [rgb], three times the bytes."""

MONO: Final = "mono"
"""The only value of `PIXELS` that means something."""

_INTERLEAVED = {"RGB": "rgb", "BGR": "bgr", "RGBa": "rgba", "BGRa": "bgra"}


class Capability(Enum):
    """YARP's two image interfaces."""

    COLOR = "COLOR"
    "RGB for every sensor."
    RAW = "RAW"
    "The sensor's own values; Bayer patterns as mono, which is what YARP's raw readers expect."

    def pixels(self, frame: Frame, *, mono: bool = False) -> PixelsAndCode:
        """Return the frame's pixels for this interface. Raises PixelFormatError.

        With `mono`, those of a sensor without colour are not repeated for each of three colours.
        """
        if self is Capability.RAW:
            return _raw(frame)
        if mono and frame.pixel_format.family is Family.MONO:
            return frame.mono(), "mono"
        return frame.rgb(), "rgb"

    def encode(self, frame: Frame, *, mono: bool = False) -> tuple[bytes, memoryview]:
        """Return the frame as an image message; `mono` as for `pixels`. Raises PixelFormatError."""
        return encode(*self.pixels(frame, mono=mono))

    def item(self, frame: Frame, box: tuple[int, int, int, int] | None = None) -> Bottle:
        """Return the frame, or its part (left, top, right, bottom), as an item of a reply."""
        pixels, code = self.pixels(frame)
        if box is not None:
            left, top, right, bottom = box
            pixels = pixels[top:bottom, left:right]
        return to_bottle(*encode(pixels, code))


def _raw(frame: Frame) -> PixelsAndCode:
    """Return the sensor's values where YARP has a code for their type, else the image for display."""
    pixels = frame.raw()
    if pixels.ndim == 2 and pixels.dtype == np.uint8:
        return pixels, "mono"
    if pixels.ndim == 2:
        deep = pixels.dtype == np.uint16
        return (pixels.astype("<u2", copy=False), "mo16") if deep else (frame.mono(), "mono")
    code = _INTERLEAVED.get(frame.pixel_format.order)
    return (pixels, code) if code and pixels.dtype == np.uint8 else (frame.rgb(), "rgb")
