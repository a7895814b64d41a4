import pytest
from hypothesis import given
from hypothesis import strategies as st

from every_case import every_case
from grabbergui.core import pfnc
from grabbergui.core.pfnc import FORMATS, Family, SampleLayout
from pixel_formats import CONVERTIBLE

# The standard's list of values: name, code. Written out by hand, so that a slip in the table shows.
CODES = """
Mono8 01080001  BayerGR8 01080008  BayerRG8 01080009  BayerGB8 0108000A  BayerBG8 0108000B
Mono10 01100003 BayerGR10 0110000C BayerRG10 0110000D BayerGB10 0110000E BayerBG10 0110000F
Mono12 01100005 BayerGR12 01100010 BayerRG12 01100011 BayerGB12 01100012 BayerBG12 01100013
Mono14 01100025 BayerGR14 01100109 BayerRG14 0110010A BayerGB14 0110010B BayerBG14 0110010C
Mono16 01100007 BayerGR16 0110002E BayerRG16 0110002F BayerGB16 01100030 BayerBG16 01100031
Mono10p 010A0046 BayerGR10p 010A0056 BayerRG10p 010A0058 BayerGB10p 010A0054 BayerBG10p 010A0052
Mono12p 010C0047 BayerGR12p 010C0057 BayerRG12p 010C0059 BayerGB12p 010C0055 BayerBG12p 010C0053
Mono10Packed 010C0004 BayerGR10Packed 010C0026 BayerRG10Packed 010C0027
BayerGB10Packed 010C0028 BayerBG10Packed 010C0029
Mono12Packed 010C0006 BayerGR12Packed 010C002A BayerRG12Packed 010C002B
BayerGB12Packed 010C002C BayerBG12Packed 010C002D
RGB8 02180014 BGR8 02180015 RGBa8 02200016 BGRa8 02200017
YUV422_8 02100032 YUV422_8_UYVY 0210001F YCbCr422_8 0210003B YCbCr422_8_CbYCrY 02100043
Mono8s 01080002 Mono1p 01010037 Mono2p 01020038 Mono4p 01040039
RGB10 02300018 RGB12 0230001A RGB16 02300033 RGB10p 021E005C RGB12p 0224005D RGB565p 02100035
RGB8_Planar 02180021 YUV411_8_UYYVYY 020C001E YUV8_UYV 02180020 YCbCr8 0218005B YCbCr8_CbYCr 0218003A
YCbCr601_422_8 0210003E YCbCr709_422_8 02100041
Coord3D_C16 011000B8 Coord3D_ABC32f 026000C0 Confidence8 010800C6
"""
WORDS = CODES.split()
TABLE = dict(zip(WORDS[::2], (int(code, 16) for code in WORDS[1::2]), strict=True))


@every_case(("name", "code"), TABLE.items())
def test_codes_are_the_standards(name, code):
    assert pfnc.by_name(name).code == code
    assert pfnc.by_code(code).name == name


@every_case("pixel_format", CONVERTIBLE, ids=str)
def test_a_name_says_the_bits_of_its_code(pixel_format):
    """A slip in the table or in reading a name shows, as both say how many bits a pixel has."""
    shared = {"411": 1.5, "420": 1.5, "422": 2}.get(pixel_format.subsampling, pixel_format.components)
    if pixel_format.layout is SampleLayout.WHOLE:
        bits = 8 * pixel_format.sample_bytes * shared
    elif pixel_format.layout is SampleLayout.FIELDS:
        bits = {"p32": 32}.get(pixel_format.name[-3:], sum(pixel_format.fields))
    else:
        bits = shared * (12 if pixel_format.layout is SampleLayout.PACKED_GIGE else pixel_format.depth)
    assert pixel_format.bits_per_pixel == bits
    assert pixel_format.code >> 24 == (2 if pixel_format.components > 1 or shared > 1 else 1)


def test_codes_and_names_are_unique():
    assert len({known.code for known in FORMATS}) == len({known.name for known in FORMATS}) == len(FORMATS)


@pytest.mark.parametrize(
    ("code", "family", "depth", "components"),
    [
        (0x01080FFF, Family.MONO, 8, 1),
        (0x010C0FFF, Family.MONO, 12, 1),
        (0x01100FFF, Family.MONO, 16, 1),
        (0x02180FFF, Family.RGB, 8, 3),
        (0x02300FFF, Family.RGB, 16, 3),
    ],
)
def test_an_unknown_code_is_read_from_its_bits(code, family, depth, components):
    unknown = pfnc.by_code(code)
    assert (unknown.name, unknown.code, unknown.guessed) == (f"0x{code:08X}", code, True)
    assert (unknown.family, unknown.depth, unknown.components) == (family, depth, components)
    assert unknown.convertible and unknown.bits_per_pixel == code >> 16 & 0xFF


@given(code=st.integers(0, 2**32 - 1))
def test_any_code_has_a_format(code):
    known = pfnc.by_code(code)
    assert known.code == code and known.bits_per_pixel == code >> 16 & 0xFF
    assert pfnc.unpacked(known) is None or pfnc.unpacked(known).convertible


@pytest.mark.parametrize("code", [0x010900AA, 0x810900AA, 0x81080001])
def test_unusual_bits_and_vendors_codes_are_not_guessed(code):
    unknown = pfnc.by_code(code)
    assert (unknown.name, unknown.convertible) == (f"0x{code:08X}", False)
    assert unknown.image_bytes(10, 10) == (100 * unknown.bits_per_pixel + 7) // 8


def test_an_unknown_name_is_a_key_error():
    with pytest.raises(KeyError):
        pfnc.by_name("Mono9")


@pytest.mark.parametrize(
    ("name", "line", "image"),
    [("Mono8", 7, 21), ("Mono10", 14, 42), ("Mono10p", 9, 27), ("Mono12Packed", 11, 32), ("RGB8", 21, 63)],
)
def test_sizes_of_an_odd_image(name, line, image):
    assert pfnc.by_name(name).line_bytes(7) == line
    assert pfnc.by_name(name).image_bytes(7, 3) == image


@every_case(
    ("name", "unpacked"),
    [
        ("Mono12p", "Mono12"),
        ("BayerRG10Packed", "BayerRG10"),
        ("RGB10p32", "RGB10"),
        ("RGB8_Planar", "RGB8"),
        ("YCbCr709_422_12p_CbYCrY", "YCbCr709_422_12_CbYCrY"),
        ("Mono8", "Mono8"),
        ("Mono1p", None),
        ("RGB565p", None),
        ("YUV411_8_UYYVYY", None),
        ("Coord3D_C10p", None),
    ],
)
def test_the_format_of_what_raw_gives(name, unpacked):
    assert pfnc.unpacked(pfnc.by_name(name)) == (unpacked and pfnc.by_name(unpacked))
