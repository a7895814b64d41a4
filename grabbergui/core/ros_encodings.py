"""ROS's image encodings as pixel formats.

An encoding (`sensor_msgs/image_encodings.hpp`) specifies bits and channels; a PFNC name also their meaning,
so both Mono12 and Confidence16 are `mono16`. Depth cameras send `16UC1` and `32FC1` (REP 118); `8UC3` and
`8UC4` are B G R and B G R A, as in cv_bridge.
"""

from __future__ import annotations

from grabbergui.core import pfnc
from grabbergui.core.pfnc import Family, PixelFormat

_BAYER = {"RG": "rggb", "BG": "bggr", "GB": "gbrg", "GR": "grbg"}
_COLOUR = {"RGB": "rgb", "BGR": "bgr", "RGBa": "rgba", "BGRa": "bgra"}
_YUV = {"UYVY": "yuv422", "YUYV": "yuv422_yuy2"}
_GENERIC = ("8U", "8S", "16U", "16S", "32S", "32F", "64F")
"OpenCV's types, before the number of channels."

FORMATS = {
    "mono8": "Mono8",
    "8UC1": "Mono8",
    "mono16": "Mono16",
    **{f"bayer_{ros}{bits}": f"Bayer{order}{bits}" for bits in (8, 16) for order, ros in _BAYER.items()},
    **{f"{ros}{bits}": f"{order}{bits}" for bits in (8, 16) for order, ros in _COLOUR.items()},
    "8UC2": "Coord3D_AC8",
    "8UC3": "BGR8",
    "8UC4": "BGRa8",
    "yuv422": "YUV422_8_UYVY",
    "uyvy": "YUV422_8_UYVY",
    "yuv422_yuy2": "YUV422_8",
    "yuyv": "YUV422_8",
    "16UC1": "Coord3D_C16",
    "16UC2": "Coord3D_AC16",
    "16UC3": "Coord3D_ABC16",
    "32FC1": "Coord3D_C32f",
    "32FC2": "Coord3D_AC32f",
    "32FC3": "Coord3D_ABC32f",
    "8SC1": "Data8s",
    "16SC1": "Data16s",
    "32SC1": "Data32s",
    "64FC1": "Data64f",
}
"The PFNC name of each encoding that can be shown."


def encoding_of(pixel_format: PixelFormat) -> str:
    """Return the encoding of a format's `Frame.raw`, or an empty text if ROS has none."""
    if not pixel_format.convertible:
        return ""
    family, bits = pixel_format.family, 8 * pixel_format.sample_bytes
    if pixel_format.is_coordinate or (family is Family.MONO and (pixel_format.kind != "u" or bits > 16)):
        kind = f"{bits}{pixel_format.kind.upper().replace('I', 'S')}"
        return f"{kind}C{pixel_format.components}" if kind in _GENERIC else ""
    if pixel_format.depth < 8 or pixel_format.fields:
        return ""
    if family is Family.MONO:
        return f"mono{bits}"
    if family is Family.BAYER:
        return f"bayer_{_BAYER[pixel_format.order]}{bits}"
    if family is Family.RGB:
        return _COLOUR[pixel_format.order] + str(bits)
    if family is Family.YUV and bits == 8 and not pixel_format.standard:
        return _YUV.get(pixel_format.raw_order, "")
    return ""


def format_of(encoding: str) -> PixelFormat | None:
    """Return the pixel format of an encoding; None for one that cannot be shown."""
    name = FORMATS.get(encoding)
    return None if name is None else pfnc.by_name(name)
