"""Pixel formats of the Pixel Format Naming Convention (PFNC 2.4): names, codes and layouts.

A code is 0xCCBBIIII. CC is 01 for one component per pixel and 02 for several, with the highest bit set for a
vendor's own format; BB are the bits per pixel, IIII an id. The names are a small language (PFNC, chapters 5
and 6): components, bits, data type, packing and special features. The table below therefore contains names
and codes only; all other properties are parsed from the name.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from enum import Enum
from typing import Literal, cast

_CODES = """
Mono1p 01010037 Mono2p 01020038 Mono4p 01040039 Mono8 01080001 Mono8s 01080002 Mono10 01100003 Mono10p
010A0046 Mono10Packed 010C0004 Mono12 01100005 Mono12p 010C0047 Mono12Packed 010C0006 Mono14 01100025 Mono14p
010E0104 Mono16 01100007 Mono32 01200111
BayerGR4p 0104010D BayerGR8 01080008 BayerGR10 0110000C BayerGR10p 010A0056 BayerGR10Packed 010C0026
BayerGR12 01100010 BayerGR12p 010C0057 BayerGR12Packed 010C002A BayerGR14 01100109 BayerGR14p 010E0105
BayerGR16 0110002E
BayerRG4p 0104010E BayerRG8 01080009 BayerRG10 0110000D BayerRG10p 010A0058 BayerRG10Packed 010C0027
BayerRG12 01100011 BayerRG12p 010C0059 BayerRG12Packed 010C002B BayerRG14 0110010A BayerRG14p 010E0106
BayerRG16 0110002F
BayerGB4p 0104010F BayerGB8 0108000A BayerGB10 0110000E BayerGB10p 010A0054 BayerGB10Packed 010C0028
BayerGB12 01100012 BayerGB12p 010C0055 BayerGB12Packed 010C002C BayerGB14 0110010B BayerGB14p 010E0107
BayerGB16 01100030
BayerBG4p 01040110 BayerBG8 0108000B BayerBG10 0110000F BayerBG10p 010A0052 BayerBG10Packed 010C0029
BayerBG12 01100013 BayerBG12p 010C0053 BayerBG12Packed 010C002D BayerBG14 0110010C BayerBG14p 010E0108
BayerBG16 01100031
RGB8 02180014 RGB8_Planar 02180021 RGB10 02300018 RGB10_Planar 02300022 RGB10p 021E005C RGB10p32 0220001D
RGB12 0230001A RGB12_Planar 02300023 RGB12p 0224005D RGB14 0230005E RGB16 02300033 RGB16_Planar 02300024
RGB565p 02100035 RGB10V1Packed 0220001C RGB12V1Packed 02240034
BGR8 02180015 BGR10 02300019 BGR10p 021E0048 BGR12 0230001B BGR12p 02240049 BGR14 0230004A BGR16 0230004B
BGR565p 02100036
RGBa8 02200016 RGBa10 0240005F RGBa10p 02280060 RGBa12 02400061 RGBa12p 02300062 RGBa14 02400063 RGBa16
02400064 BGRa8 02200017 BGRa10 0240004C BGRa10p 0228004D BGRa12 0240004E BGRa12p 0230004F BGRa14 02400050
BGRa16 02400051 R8 010800C9 R10 01100120 R10_Deprecated 010A00CA R12 01100121 R12_Deprecated 010C00CB R16
011000CC G8 010800CD G10 01100122 G10_Deprecated 010A00CE G12 01100123 G12_Deprecated 010C00CF G16 011000D0
B8 010800D1 B10 01100124 B10_Deprecated 010A00D2 B12 01100125 B12_Deprecated 010C00D3 B16 011000D4
Coord3D_A8 010800AF Coord3D_A10p 010A00D5 Coord3D_A12p 010C00D8 Coord3D_A16 011000B6 Coord3D_A32f 012000BD
Coord3D_B8 010800B0 Coord3D_B10p 010A00D6 Coord3D_B12p 010C00D9 Coord3D_B16 011000B7 Coord3D_B32f 012000BE
Coord3D_C8 010800B1 Coord3D_C10p 010A00D7 Coord3D_C12p 010C00DA Coord3D_C16 011000B8 Coord3D_C32f 012000BF
Coord3D_AC8 021000B4 Coord3D_AC8_Planar 021000B5 Coord3D_AC10p 021400F0 Coord3D_AC10p_Planar 021400F1
Coord3D_AC12p 021800F2 Coord3D_AC12p_Planar 021800F3 Coord3D_AC16 022000BB Coord3D_AC16_Planar 022000BC
Coord3D_AC32f 024000C2 Coord3D_AC32f_Planar 024000C3
Coord3D_ABC8 021800B2 Coord3D_ABC8_Planar 021800B3 Coord3D_ABC10p 021E00DB Coord3D_ABC10p_Planar 021E00DC
Coord3D_ABC12p 022400DE Coord3D_ABC12p_Planar 022400DF Coord3D_ABC16 023000B9 Coord3D_ABC16_Planar 023000BA
Coord3D_ABC32f 026000C0 Coord3D_ABC32f_Planar 026000C1
Confidence1 010800C4 Confidence1p 010100C5 Confidence8 010800C6 Confidence16 011000C7 Confidence32f 012000C8
BiColorRGBG8 021000A5 BiColorRGBG10 022000A7 BiColorRGBG10p 021400A8 BiColorRGBG12 022000AB
BiColorRGBG12p 021800AC
BiColorBGRG8 021000A6 BiColorBGRG10 022000A9 BiColorBGRG10p 021400AA BiColorBGRG12 022000AD
BiColorBGRG12p 021800AE
Data8 01080116 Data8s 01080117 Data16 01100118 Data16s 01100119 Data32 0120011A Data32s 0120011B
Data32f 0120011C Data64 0140011D Data64s 0140011E Data64f 0140011F
SCF1WBWG8 01080067 SCF1WBWG10 01100068 SCF1WBWG10p 010A0069 SCF1WBWG12 0110006A SCF1WBWG12p 010C006B
SCF1WBWG14 0110006C SCF1WBWG16 0110006D
SCF1WGWB8 0108006E SCF1WGWB10 0110006F SCF1WGWB10p 010A0070 SCF1WGWB12 01100071 SCF1WGWB12p 010C0072
SCF1WGWB14 01100073 SCF1WGWB16 01100074
SCF1WGWR8 01080075 SCF1WGWR10 01100076 SCF1WGWR10p 010A0077 SCF1WGWR12 01100078 SCF1WGWR12p 010C0079
SCF1WGWR14 0110007A SCF1WGWR16 0110007B
SCF1WRWG8 0108007C SCF1WRWG10 0110007D SCF1WRWG10p 010A007E SCF1WRWG12 0110007F SCF1WRWG12p 010C0080
SCF1WRWG14 01100081 SCF1WRWG16 01100082
YUV411_8_UYYVYY 020C001E YUV422_8 02100032 YUV422_8_UYVY 0210001F YUV8_UYV 02180020
YCbCr8 0218005B YCbCr8_CbYCr 0218003A YCbCr10_CbYCr 02300083 YCbCr10p_CbYCr 021E0084 YCbCr12_CbYCr 02300085
YCbCr12p_CbYCr 02240086 YCbCr411_8 020C005A YCbCr411_8_CbYYCrYY 020C003C
YCbCr420_8_YY_CbCr_Semiplanar 020C0112 YCbCr420_8_YY_CrCb_Semiplanar 020C0114
YCbCr422_8 0210003B YCbCr422_8_CbYCrY 02100043 YCbCr422_8_YY_CbCr_Semiplanar 02100113
YCbCr422_8_YY_CrCb_Semiplanar 02100115 YCbCr422_10 02200065 YCbCr422_10_CbYCrY 02200099 YCbCr422_10p 02140087
YCbCr422_10p_CbYCrY 0214009A YCbCr422_12 02200066 YCbCr422_12_CbYCrY 0220009B YCbCr422_12p 02180088
YCbCr422_12p_CbYCrY 0218009C
YCbCr601_8_CbYCr 0218003D YCbCr601_10_CbYCr 02300089 YCbCr601_10p_CbYCr 021E008A YCbCr601_12_CbYCr 0230008B
YCbCr601_12p_CbYCr 0224008C YCbCr601_411_8_CbYYCrYY 020C003F YCbCr601_422_8 0210003E
YCbCr601_422_8_CbYCrY 02100044 YCbCr601_422_10 0220008D YCbCr601_422_10_CbYCrY 0220009D
YCbCr601_422_10p 0214008E YCbCr601_422_10p_CbYCrY 0214009E YCbCr601_422_12 0220008F
YCbCr601_422_12_CbYCrY 0220009F YCbCr601_422_12p 02180090 YCbCr601_422_12p_CbYCrY 021800A0
YCbCr709_8_CbYCr 02180040 YCbCr709_10_CbYCr 02300091 YCbCr709_10p_CbYCr 021E0092 YCbCr709_12_CbYCr 02300093
YCbCr709_12p_CbYCr 02240094 YCbCr709_411_8_CbYYCrYY 020C0042 YCbCr709_422_8 02100041
YCbCr709_422_8_CbYCrY 02100045 YCbCr709_422_10 02200095 YCbCr709_422_10_CbYCrY 022000A1
YCbCr709_422_10p 02140096 YCbCr709_422_10p_CbYCrY 021400A2 YCbCr709_422_12 02200097
YCbCr709_422_12_CbYCrY 022000A3 YCbCr709_422_12p 02180098 YCbCr709_422_12p_CbYCrY 021800A4
YCbCr2020_8_CbYCr 021800F4 YCbCr2020_10_CbYCr 023000F5 YCbCr2020_10p_CbYCr 021E00F6 YCbCr2020_12_CbYCr
023000F7 YCbCr2020_12p_CbYCr 022400F8 YCbCr2020_411_8_CbYYCrYY 020C00F9 YCbCr2020_422_8 021000FA
YCbCr2020_422_8_CbYCrY 021000FB YCbCr2020_422_10 022000FC YCbCr2020_422_10_CbYCrY 022000FD
YCbCr2020_422_10p 021400FE YCbCr2020_422_10p_CbYCrY 021400FF YCbCr2020_422_12 02200100
YCbCr2020_422_12_CbYCrY 02200101 YCbCr2020_422_12p 02180102 YCbCr2020_422_12p_CbYCrY 02180103
"""
"""PFNC's list of values, including GigE Vision's own `Packed` formats. `_Deprecated` names have 10 or 12 bits
per pixel in their code and are read as packed."""
_NAME = re.compile(
    r"(?P<components>Mono|Data|Confidence|Bayer|SCF1|BiColor|Coord3D_|YUV|YCbCr|RGBa|BGRa|RGB|BGR|R|G|B)"
    r"(?P<pattern>(?<=Bayer)[GRB]{2}|(?<=SCF1)W[GRB]W[GRB]|(?<=BiColor)(?:RGBG|BGRG)|(?<=Coord3D_)A?B?C?)?"
    r"(?P<standard>(?<=YCbCr)(?:601|709|2020)_)?"
    r"(?:(?P<subsampling>4\d\d)_)?"
    r"(?P<bits>\d+)(?P<packing>p32|p|s|f|V1Packed|Packed)?"
    r"(?:_(?P<special>\w+))?"
)
_CHROMA_ORDER = {"": "YUV", "422": "YUYV", "411": "YYUYYV", "420": "YUV"}
"The order of components if the name does not contain it."
_WORDS = _CODES.split()
_ONE_COMPONENT = {1: "p", 2: "p", 4: "p", 8: "", 10: "p", 12: "p", 14: "p", 16: "", 32: ""}
_SEVERAL = {24: "RGB8", 30: "RGB10p", 32: "RGBa8", 36: "RGB12p", 40: "RGBa10p", 48: "RGB16", 64: "RGBa16"}


class SampleLayout(Enum):
    """The layout of samples in memory."""

    WHOLE = "unpacked"
    "Each in whole bytes, its value in the low bits."
    PACKED_LSB = "p"
    "A continuous bit stream, the first sample in the least significant bits (`Mono10p`)."
    PACKED_GIGE = "Packed"
    "GigE Vision's own: two samples in three bytes, their high bits in whole bytes (`Mono12Packed`)."
    FIELDS = "fields"
    "Bit fields of one little-endian word per pixel (`RGB565p`, `RGB10p32`)."
    OTHER = "other"
    "Unknown except for its size."


class Family(Enum):
    """The meaning of the components."""

    MONO = "mono"
    "One value per pixel: brightness, one colour, one coordinate, confidence or data."
    BAYER = "bayer"
    SPARSE = "sparse colour"
    "A mosaic of 4×4 pixels, half of them without a colour filter (SCF1)."
    RGB = "rgb"
    BICOLOR = "bicolor"
    "Two colours per pixel: green, and alternately red or blue."
    YUV = "yuv"
    COORDINATES = "coordinates"
    "Two or three coordinates per pixel."
    OTHER = "other"


@dataclass(frozen=True)
class PixelFormat:
    """A pixel format."""

    name: str
    "PFNC's, e.g. `BayerRG12p`; `0x81080001` if it is unknown."
    code: int
    family: Family = Family.OTHER
    depth: int = 8
    "Significant bits of a sample; the largest if components differ (`RGB565p`)."
    components: int = 1
    "Size of the last axis of `Frame.raw`; with one component there is no such axis."
    layout: SampleLayout = SampleLayout.OTHER
    order: str = ""
    """Order of components in memory, e.g. `BGRa`, `YUYV` or `UYYVYY`; for Bayer the first two pixels (`RG`),
    for sparse colour the first four, for coordinates their names."""
    kind: Literal["u", "i", "f"] = "u"
    "Numpy's kind of the samples: unsigned, signed or floating-point."
    planar: bool = False
    "Whether each component fills a plane of its own."
    subsampling: Literal["", "411", "420", "422"] = ""
    "How pixels share chroma: four or two in a line, or two in each of two lines."
    semiplanar: bool = False
    "Whether a plane of luma precedes one of interleaved chroma (`YY_CbCr`)."
    standard: Literal["", "601", "709", "2020"] = ""
    "ITU-R BT recommendation with its matrix and limited range; without one, BT.601's matrix in full range."
    fields: tuple[int, ...] = ()
    "Bits of each component of `SampleLayout.FIELDS`, from the least significant."
    guessed: bool = False
    "Whether the code is none of PFNC's or a vendor's, and the layout was guessed from its bits per pixel."

    @property
    def bits_per_pixel(self) -> int:
        """Size of a pixel in the payload, in bits."""
        return self.code >> 16 & 0xFF

    @property
    def convertible(self) -> bool:
        """Whether `core.pixels` can convert it."""
        return self.layout is not SampleLayout.OTHER

    @property
    def is_distance(self) -> bool:
        """Whether a value is a distance instead of a brightness, and 0 if none was measured."""
        return self.name.startswith("Coord3D_C")

    @property
    def is_coordinate(self) -> bool:
        """Whether its values are coordinates of points (Coord3D)."""
        return self.name.startswith("Coord3D_")

    @property
    def packed(self) -> bool:
        """Whether samples are not aligned to bytes, so that reading them requires a copy."""
        return self.layout in (SampleLayout.PACKED_LSB, SampleLayout.PACKED_GIGE)

    @property
    def needs_range(self) -> bool:
        """Whether values have no defined white, so that a display must scale them from their range."""
        return self.kind == "f" or self.depth > 16 or self.family is Family.COORDINATES

    @property
    def sample_bytes(self) -> int:
        """Size of a sample of `Frame.raw` in bytes: 1, 2, 4 or 8."""
        return next(size for size in (1, 2, 4, 8) if self.depth <= 8 * size)

    @property
    def raw_order(self) -> str:
        """Names of the components on the last axis of `Frame.raw`; `YUYV` and `RGBG` cover a pair of pixels.

        This is the order in memory, or `YUV` if chroma is repeated for each pixel.
        """
        return "YUV" if self.expands_chroma else self.order

    @property
    def expands_chroma(self) -> bool:
        """Whether `Frame.raw` repeats chroma for each pixel, as the payload has it per group only."""
        return self.subsampling in ("411", "420") or self.semiplanar

    @property
    def cell(self) -> tuple[int, int]:
        """Width and height of the repeated pattern of pixels."""
        if self.family is Family.BAYER:
            return 2, 2
        if self.family is Family.SPARSE:
            return 4, 4
        if self.subsampling:
            return (4 if self.subsampling == "411" else 2), (2 if self.subsampling == "420" else 1)
        return (2, 1) if self.family is Family.BICOLOR else (1, 1)

    def line_bytes(self, width: int) -> int:
        """Return the size of a byte-aligned line without padding, or of a plane's line in planar formats."""
        bits = self.bits_per_pixel
        if self.planar:
            bits //= self.components
        elif self.semiplanar:
            bits = self.depth
        return (width * bits + 7) // 8

    def image_bytes(self, width: int, height: int) -> int:
        """Return the size of an image without padding; packed formats continue across line ends."""
        if self.semiplanar:
            lines = -(-height // 2) if self.subsampling == "420" else height
            return width * height + lines * 2 * -(-width // 2)
        if self.planar:
            return self.components * ((width * height * self.bits_per_pixel // self.components + 7) // 8)
        return (width * height * self.bits_per_pixel + 7) // 8

    def __str__(self) -> str:
        return self.name


_FAMILIES = {
    "Bayer": Family.BAYER,
    "SCF1": Family.SPARSE,
    "BiColor": Family.BICOLOR,
    "YUV": Family.YUV,
    "YCbCr": Family.YUV,
    "Mono": Family.MONO,
    "Data": Family.MONO,
    "Confidence": Family.MONO,
}


def _read(name: str, code: int) -> PixelFormat:
    """Parse a name. A test checks that its bits per pixel are those of its code."""
    match = _NAME.fullmatch(name)
    assert match is not None, name
    part = {key: value or "" for key, value in match.groupdict().items()}
    bits, packing, special, start = int(part["bits"]), part["packing"], part["special"], part["components"]
    layout = {"p": SampleLayout.PACKED_LSB, "Packed": SampleLayout.PACKED_GIGE}.get(
        packing, SampleLayout.WHOLE
    )
    if special == "Deprecated":
        layout = SampleLayout.PACKED_LSB
    kind: Literal["u", "i", "f"] = "i" if packing == "s" else "f" if packing == "f" else "u"
    simple = PixelFormat(name, code, Family.MONO, bits, 1, layout, part["pattern"], kind)
    if start in ("YUV", "YCbCr"):
        return _read_yuv(simple, part)
    if start == "Coord3D_":
        count = len(simple.order)
        family = Family.MONO if count == 1 else Family.COORDINATES
        order = simple.order if count > 1 else ""
        return replace(simple, family=family, components=count, order=order, planar=special == "Planar")
    if start.rstrip("a") in ("RGB", "BGR"):
        colour = replace(simple, family=Family.RGB, components=len(start), order=start)
        return _read_special_rgb(replace(colour, planar=special == "Planar"), packing)
    if start == "BiColor":
        return replace(simple, family=Family.BICOLOR, components=2)
    return replace(simple, family=_FAMILIES.get(start, Family.MONO))


def _read_yuv(simple: PixelFormat, part: dict[str, str]) -> PixelFormat:
    subsampling = cast(Literal["", "411", "420", "422"], part["subsampling"])
    special = part["special"]
    semiplanar = special.endswith("_Semiplanar")
    order = special.replace("Cb", "U").replace("Cr", "V")
    if semiplanar:
        order = "YUV" if order.startswith("YY_UV") else "YVU"
    components = 2 if subsampling == "422" and not semiplanar else 3
    return replace(
        simple,
        family=Family.YUV,
        components=components,
        order=order or _CHROMA_ORDER[subsampling],
        subsampling=subsampling,
        semiplanar=semiplanar,
        standard=cast(Literal["", "601", "709", "2020"], part["standard"].rstrip("_")),
    )


def _read_special_rgb(colour: PixelFormat, packing: str) -> PixelFormat:
    if colour.depth == 565:
        return replace(colour, depth=6, layout=SampleLayout.FIELDS, fields=(5, 6, 5))
    if packing == "p32":
        return replace(colour, layout=SampleLayout.FIELDS, fields=(10, 10, 10))
    if packing == "V1Packed" and colour.depth == 12:
        return replace(colour, layout=SampleLayout.PACKED_GIGE)
    if packing == "V1Packed":
        return replace(colour, layout=SampleLayout.OTHER)  # GigE Vision 1.x; its bytes are not in PFNC
    return colour


FORMATS = tuple(_read(name, int(code, 16)) for name, code in zip(_WORDS[::2], _WORDS[1::2], strict=True))
"All formats of the convention, in the order of its list."

_BY_CODE = {pixel_format.code: pixel_format for pixel_format in FORMATS}
_BY_NAME = {pixel_format.name: pixel_format for pixel_format in FORMATS}


def is_known(code: int) -> bool:
    """Return whether the convention has a format of this code."""
    return code in _BY_CODE


def by_code(code: int) -> PixelFormat:
    """Return the format of a PFNC code.

    An unknown one is named by its code. Its layout is guessed if there is a usual one for its bits per pixel.
    That of a vendor's own is `SampleLayout.OTHER`: `vendor_formats` may know more.
    """
    return _BY_CODE.get(code) or _guessed(code)


def _guessed(code: int) -> PixelFormat:
    if code & 0x80000000:
        return PixelFormat(f"0x{code:08X}", code)
    bits, components = code >> 16 & 0xFF, code >> 24
    name = ""
    if components == 1 and bits in _ONE_COMPONENT:
        name = f"Mono{bits}{_ONE_COMPONENT[bits]}"
    elif components == 2:
        name = _SEVERAL.get(bits, "")
    if not name:
        return PixelFormat(f"0x{code:08X}", code)
    return replace(_BY_NAME[name], name=f"0x{code:08X}", code=code, guessed=True)


def by_name(name: str) -> PixelFormat:
    """Return the format of a PFNC name. Raises KeyError."""
    return _BY_NAME[name]


def unpacked(pixel_format: PixelFormat) -> PixelFormat | None:
    """Return the format whose payload equals `Frame.raw`, or None if the convention has none.

    It is the format itself if its samples are unpacked and its components interleaved.
    """
    if pixel_format.guessed or pixel_format.expands_chroma or len(set(pixel_format.fields)) > 1:
        return None
    name = re.sub(r"(?<=\d)(p32|p|Packed|V1Packed)(?=_|$)|_Planar$|_Deprecated$", "", pixel_format.name)
    return _BY_NAME.get(name)
