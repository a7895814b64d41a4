"""PFNC pixel formats and ROS's `sensor_msgs/image_encodings`, without ROS.

Formats of 8 bits, Bayer and mono deeper than 8 bits, and YUV 4:2:2 travel as the sensor has them; packed
formats are laid out in 16 bits. Values stay in the low bits: a `mono16` of a 12-bit sensor ends at 4095.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from grabbergui.core import pfnc
from grabbergui.core.errors import PixelFormatError
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import Family, PixelFormat

_BAYER = {"RG": "rggb", "BG": "bggr", "GB": "gbrg", "GR": "grbg"}
_COLOUR = {"RGB": "rgb8", "BGR": "bgr8", "RGBa": "rgba8", "BGRa": "bgra8"}
_YUV = {"UYVY": "yuv422", "YUYV": "yuv422_yuy2"}

_FORMATS = {
    "mono8": "Mono8",
    "8UC1": "Mono8",
    "mono16": "Mono16",
    "16UC1": "Coord3D_C16",  # what depth cameras send (REP 118)
    "8UC3": "BGR8",
    **{f"bayer_{ros}8": f"Bayer{order}8" for order, ros in _BAYER.items()},
    **{f"bayer_{ros}16": f"Bayer{order}16" for order, ros in _BAYER.items()},
    "rgb8": "RGB8",
    "bgr8": "BGR8",
    "rgba8": "RGBa8",
    "bgra8": "BGRa8",
    "yuv422": "YUV422_8_UYVY",
    "uyvy": "YUV422_8_UYVY",
    "yuv422_yuy2": "YUV422_8",
    "yuyv": "YUV422_8",
}


def encoding_of(pixel_format: PixelFormat) -> str:
    """ROS's name for what `pixels_of` gives. Raises PixelFormatError where there is none."""
    bits = "8" if pixel_format.depth == 8 else "16"
    name: str | None = None
    if pixel_format.convertible:
        if pixel_format.family is Family.MONO:
            name = "16UC1" if pixel_format.is_distance else f"mono{bits}"
        elif pixel_format.family is Family.BAYER:
            name = f"bayer_{_BAYER[pixel_format.order]}{bits}"
        elif pixel_format.family is Family.RGB:
            name = _COLOUR.get(pixel_format.order)
        elif pixel_format.family is Family.YUV:
            name = _YUV.get(pixel_format.order)
    if name is None:
        raise PixelFormatError(
            f"ROS has no encoding for {pixel_format} (0x{pixel_format.code:08X}); set another PixelFormat"
        )
    return name


def pixels_of(frame: Frame) -> NDArray[Any]:
    """The pixels in the layout of `encoding_of`: a view of the payload except for packed formats.

    Shape (height, width) or (height, width, n); uint8, or uint16 in little-endian order.
    """
    pixels = frame.raw()
    return pixels.astype("<u2", copy=False) if pixels.dtype == np.uint16 else pixels


def format_of(encoding: str) -> PixelFormat:
    """The pixel format of an encoding. Raises PixelFormatError naming one that we cannot show."""
    name = _FORMATS.get(encoding)
    if name is None:
        known = ", ".join(_FORMATS)
        raise PixelFormatError(f"images with the encoding '{encoding}' cannot be shown; known are {known}")
    return pfnc.by_name(name)
