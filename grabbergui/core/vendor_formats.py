"""Pixel formats outside the Pixel Format Naming Convention: vendors' own codes, and names of older standards.

A code with its highest bit set means what its vendor likes: 0x81100007 is Basler's BayerRG16 and Hikrobot's
compressed Mono16. So the name that the camera's own PixelFormat has for a code comes first, then the table of
its vendor. What neither knows stays raw data under that name: a wrong picture is worse than none.
"""

from __future__ import annotations

import re

from grabbergui.core import pfnc
from grabbergui.core.pfnc import PixelFormat

CUSTOM = 0x80000000
"The bit of a vendor's own code."

_CODES: dict[str, dict[int, str]] = {
    # pylon's list of the formats that older Basler cameras send under codes of their own.
    "basler": {
        0x810C0001: "BayerGR12Packed",
        0x810C0002: "BayerRG12Packed",
        0x810C0003: "BayerGB12Packed",
        0x810C0004: "BayerBG12Packed",
        0x81100006: "BayerGR16",
        0x81100007: "BayerRG16",
        0x81100008: "BayerGB16",
        0x81100009: "BayerBG16",
        0x82100005: "YUV422_8",
        0x8224000A: "RGB12V1Packed",
    },
}
"By the beginning of the vendor's name, in lower case."
_COMPRESSING = ("hik",)
"Vendors for whom the bit means that the payload is compressed, by an algorithm that is not published."

_NAMES = {
    "YUV422_YUYV_Packed": "YUV422_8",
    "YUV422YUYVPacked": "YUV422_8",
    "YUV411Packed": "YUV411_8_UYYVYY",
    "YUV422Packed": "YUV422_8_UYVY",
    "YUV444Packed": "YUV8_UYV",
    "RGB10V2Packed": "RGB10p32",
    "RGB565Packed": "RGB565p",
    "BGR565Packed": "BGR565p",
    "Mono8Signed": "Mono8s",
    "Mono1Packed": "Mono1p",
    "Mono2Packed": "Mono2p",
    "Mono4Packed": "Mono4p",
}
"Names of GigE Vision 1.x that the rules below do not lead to PFNC's."
_PACKED = re.compile(r"(RGB|BGR)(A?)(8|10|12|14|16)Packed")
"`RGBA8Packed` is RGBa8: whole bytes, packed only as opposed to planar."
_PLANAR = re.compile(r"(RGB\d+)Planar")
_POLARISED = re.compile(r"Polari[sz]ed?(?:Mono)?(\d+\w*)")
"A grey mosaic of four directions, such as FLIR's `Polarized12p`. One with colours has no rule here."


def named(name: str) -> PixelFormat | None:
    """Return the format that a camera calls so; None if its layout is not known."""
    name = _NAMES.get(name, name)
    for pattern, convention in ((_PACKED, _unpacked_name), (_PLANAR, r"\1_Planar"), (_POLARISED, r"Mono\1")):
        if pattern.fullmatch(name):
            name = pattern.sub(convention, name)
    try:
        return pfnc.by_name(name)
    except KeyError:
        return None


def of_camera(code: int, name: str = "", vendor: str = "") -> PixelFormat:
    """Return the format of a code from a camera of this vendor, which has the `name` for it, if any."""
    if pfnc.is_known(code):
        return pfnc.by_code(code)
    maker = vendor.lower()
    if not name:
        table = next((codes for begin, codes in _CODES.items() if maker.startswith(begin)), {})
        name = table.get(code, "")
        if code & CUSTOM and maker.startswith(_COMPRESSING) and pfnc.is_known(code ^ CUSTOM):
            name = f"{pfnc.by_code(code ^ CUSTOM).name}HB"
    unknown, found = pfnc.by_code(code), named(name)
    if found is None:
        return PixelFormat(name, code) if name else unknown
    return found if found.bits_per_pixel == unknown.bits_per_pixel else unknown


def _unpacked_name(match: re.Match[str]) -> str:
    return match[1] + match[2].lower() + match[3]
