"""Pixel formats by the Pixel Format Naming Convention (PFNC 2.x): codes, names, layout.

A code is 0xCCBBIIII: CC 01 mono, 02 colour, from 80 on a vendor's own; BB bits per pixel; IIII an id.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Layout(Enum):
    """How pixels lie in memory."""

    WHOLE = "whole"
    "Components in whole bytes or 16-bit words, value in the low bits."
    PACKED_LSB = "p"
    "One continuous bit stream, pixel 0 in the least significant bits first (`Mono10p`)."
    PACKED_GIGE = "Packed"
    "GigE Vision's own: three bytes hold two pixels, their high bits in whole bytes (`Mono12Packed`)."
    YUV422 = "YUV422"
    "Luma for each pixel, chroma for pairs; 8 bits each."
    OTHER = "other"
    "Known by name only."


class Family(Enum):
    """The meaning of the components."""

    MONO = "mono"
    BAYER = "bayer"
    RGB = "rgb"
    YUV = "yuv"
    OTHER = "other"


@dataclass(frozen=True)
class PixelFormat:
    """One pixel format."""

    name: str
    "PFNC's, e.g. `BayerRG12p`; `0x81080001` where it is not known."
    code: int
    family: Family = Family.OTHER
    depth: int = 8
    "Significant bits of a component."
    components: int = 1
    "Interleaved components a pixel, e.g. 3 for RGB8."
    layout: Layout = Layout.OTHER
    order: str = ""
    "Memory order: `RG` of the Bayer pattern's first two pixels, `BGRa`, `YUYV`, `UYVY`."

    @property
    def bits_per_pixel(self) -> int:
        """Bits that one pixel takes in the payload."""
        return self.code >> 16 & 0xFF

    @property
    def convertible(self) -> bool:
        """Whether `core.pixels` can lay it out and convert it."""
        return self.layout is not Layout.OTHER

    @property
    def is_distance(self) -> bool:
        """Whether a value is a distance and no brightness, and 0 where none was measured."""
        return self.name.startswith("Coord3D_C")

    def line_bytes(self, width: int) -> int:
        """Bytes of a line that starts on a byte, without padding."""
        return (width * self.bits_per_pixel + 7) // 8

    def image_bytes(self, width: int, height: int) -> int:
        """Bytes of a picture without padding: packed formats go on over the line's end."""
        return (width * height * self.bits_per_pixel + 7) // 8

    def __str__(self) -> str:
        return self.name


def _mono_and_bayer() -> list[PixelFormat]:
    ids = {  # suffix: (mono, GR, RG, GB, BG), bits, depth, layout
        "8": ((0x01, 0x08, 0x09, 0x0A, 0x0B), 8, 8, Layout.WHOLE),
        "10": ((0x03, 0x0C, 0x0D, 0x0E, 0x0F), 16, 10, Layout.WHOLE),
        "12": ((0x05, 0x10, 0x11, 0x12, 0x13), 16, 12, Layout.WHOLE),
        "14": ((0x25, 0x109, 0x10A, 0x10B, 0x10C), 16, 14, Layout.WHOLE),
        "16": ((0x07, 0x2E, 0x2F, 0x30, 0x31), 16, 16, Layout.WHOLE),
        "10p": ((0x46, 0x56, 0x58, 0x54, 0x52), 10, 10, Layout.PACKED_LSB),
        "12p": ((0x47, 0x57, 0x59, 0x55, 0x53), 12, 12, Layout.PACKED_LSB),
        "10Packed": ((0x04, 0x26, 0x27, 0x28, 0x29), 12, 10, Layout.PACKED_GIGE),
        "12Packed": ((0x06, 0x2A, 0x2B, 0x2C, 0x2D), 12, 12, Layout.PACKED_GIGE),
    }
    formats = []
    for suffix, (codes, bits, depth, layout) in ids.items():
        for order, low in zip(("", "GR", "RG", "GB", "BG"), codes, strict=True):
            family = Family.BAYER if order else Family.MONO
            name = f"Bayer{order}{suffix}" if order else f"Mono{suffix}"
            formats.append(PixelFormat(name, 0x01000000 | bits << 16 | low, family, depth, 1, layout, order))
    return formats


_FORMATS = (
    *_mono_and_bayer(),
    PixelFormat("RGB8", 0x02180014, Family.RGB, 8, 3, Layout.WHOLE, "RGB"),
    PixelFormat("BGR8", 0x02180015, Family.RGB, 8, 3, Layout.WHOLE, "BGR"),
    PixelFormat("RGBa8", 0x02200016, Family.RGB, 8, 4, Layout.WHOLE, "RGBa"),
    PixelFormat("BGRa8", 0x02200017, Family.RGB, 8, 4, Layout.WHOLE, "BGRa"),
    PixelFormat("YUV422_8", 0x02100032, Family.YUV, 8, 2, Layout.YUV422, "YUYV"),
    PixelFormat("YUV422_8_UYVY", 0x0210001F, Family.YUV, 8, 2, Layout.YUV422, "UYVY"),
    PixelFormat("YCbCr422_8", 0x0210003B, Family.YUV, 8, 2, Layout.YUV422, "YUYV"),
    PixelFormat("YCbCr422_8_CbYCrY", 0x02100043, Family.YUV, 8, 2, Layout.YUV422, "UYVY"),
    # Known by name, so that an error can say what it is.
    PixelFormat("Mono1p", 0x01010037, Family.MONO, 1),
    PixelFormat("Mono2p", 0x01020038, Family.MONO, 2),
    PixelFormat("Mono4p", 0x01040039, Family.MONO, 4),
    PixelFormat("Mono8s", 0x01080002, Family.MONO, 8),
    PixelFormat("RGB10", 0x02300018, Family.RGB, 10, 3),
    PixelFormat("RGB12", 0x0230001A, Family.RGB, 12, 3),
    PixelFormat("RGB16", 0x02300033, Family.RGB, 16, 3),
    PixelFormat("RGB10p", 0x021E005C, Family.RGB, 10, 3),
    PixelFormat("RGB12p", 0x0224005D, Family.RGB, 12, 3),
    PixelFormat("RGB565p", 0x02100035, Family.RGB, 5, 3),
    PixelFormat("RGB8_Planar", 0x02180021, Family.RGB, 8, 3),
    PixelFormat("YUV411_8_UYYVYY", 0x020C001E, Family.YUV),
    PixelFormat("YUV8_UYV", 0x02180020, Family.YUV),
    PixelFormat("YCbCr8", 0x0218005B, Family.YUV),
    PixelFormat("YCbCr8_CbYCr", 0x0218003A, Family.YUV),
    PixelFormat("YCbCr601_422_8", 0x0210003E, Family.YUV),
    PixelFormat("YCbCr709_422_8", 0x02100041, Family.YUV),
    PixelFormat("Coord3D_C16", 0x011000B8, Family.MONO, 16, 1, Layout.WHOLE),  # ROS's 16UC1 of depth cameras
    PixelFormat("Coord3D_ABC32f", 0x026000C0),
    PixelFormat("Confidence8", 0x010800C6),
)

_BY_CODE = {pixel_format.code: pixel_format for pixel_format in _FORMATS}
_BY_NAME = {pixel_format.name: pixel_format for pixel_format in _FORMATS}

CONVERTIBLE = tuple(pixel_format for pixel_format in _FORMATS if pixel_format.convertible)
"""The formats that can be shown."""


def by_code(code: int) -> PixelFormat:
    """The format of a PFNC code; an unknown one is named by its code and is not convertible."""
    return _BY_CODE.get(code) or PixelFormat(f"0x{code:08X}", code)


def by_name(name: str) -> PixelFormat:
    """The format of a PFNC name. Raises KeyError."""
    return _BY_NAME[name]
