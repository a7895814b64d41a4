import pytest

from grabbergui.core import pfnc
from grabbergui.core.pfnc import CONVERTIBLE, Family

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


@pytest.mark.parametrize(("name", "code"), TABLE.items())
def test_codes_are_the_standards(name, code):
    assert pfnc.by_name(name).code == code
    assert pfnc.by_code(code).name == name


def test_every_convertible_format_is_in_the_standards_table():
    assert {pixel_format.name for pixel_format in CONVERTIBLE} <= TABLE.keys()


def test_an_unknown_code_keeps_its_size():
    unknown = pfnc.by_code(0x810C0001)
    assert (unknown.name, unknown.convertible, unknown.bits_per_pixel) == ("0x810C0001", False, 12)
    assert unknown.image_bytes(10, 10) == 150


def test_an_unknown_name_is_a_key_error():
    with pytest.raises(KeyError):
        pfnc.by_name("Mono9")


@pytest.mark.parametrize(
    ("name", "line", "picture"),
    [("Mono8", 7, 21), ("Mono10", 14, 42), ("Mono10p", 9, 27), ("Mono12Packed", 11, 32), ("RGB8", 21, 63)],
)
def test_sizes_of_an_odd_picture(name, line, picture):
    assert pfnc.by_name(name).line_bytes(7) == line
    assert pfnc.by_name(name).image_bytes(7, 3) == picture


@pytest.mark.parametrize("pixel_format", CONVERTIBLE, ids=str)
def test_orders_name_their_components(pixel_format):
    letters = {Family.MONO: "", Family.BAYER: "RGB", Family.RGB: "RGBa", Family.YUV: "YUV"}
    assert set(pixel_format.order) <= set(letters[pixel_format.family])
    assert str(pixel_format) == pixel_format.name
