"""Names of ROS's image encodings, into pixel formats and back."""

import pytest

from every_case import every_case
from grabbergui.core import pfnc
from grabbergui.core.ros_encodings import FORMATS, encoding_of, format_of

NAMES = [
    ("Mono8", "mono8"),
    ("Mono10", "mono16"),
    ("Mono12p", "mono16"),
    ("Confidence8", "mono8"),
    ("BayerRG8", "bayer_rggb8"),
    ("BayerBG12Packed", "bayer_bggr16"),
    ("BayerGB16", "bayer_gbrg16"),
    ("BayerGR8", "bayer_grbg8"),
    ("RGB8", "rgb8"),
    ("RGB12", "rgb16"),
    ("BGRa8", "bgra8"),
    ("YUV422_8_UYVY", "yuv422"),
    ("YCbCr422_8", "yuv422_yuy2"),
    ("Coord3D_C16", "16UC1"),
    ("Coord3D_ABC32f", "32FC3"),
    ("Data8s", "8SC1"),
    ("Data64f", "64FC1"),
]
WITHOUT = ["Mono4p", "RGB565p", "Mono32", "Data64s", "YUV411_8_UYYVYY", "YCbCr709_422_8", "SCF1WBWG8"]


@every_case(("name", "encoding"), NAMES)
def test_a_pixel_format_has_the_encoding_that_ros_has_for_it(name, encoding):
    assert encoding_of(pfnc.by_name(name)) == encoding


@pytest.mark.parametrize("name", WITHOUT)
def test_some_formats_have_no_encoding(name):
    assert encoding_of(pfnc.by_name(name)) == ""


def test_a_format_of_unknown_layout_has_no_encoding():
    assert encoding_of(pfnc.by_code(0x81090001)) == ""


@every_case("encoding", FORMATS)
def test_a_known_encoding_is_that_of_its_format(encoding):
    same = {"8UC1": "mono8", "8UC3": "bgr8", "8UC4": "bgra8", "uyvy": "yuv422", "yuyv": "yuv422_yuy2"}
    pixel_format = format_of(encoding)
    assert encoding_of(pixel_format) == same.get(encoding, encoding)


def test_unknown_encodings_have_no_format():
    assert format_of("64FC4") is None
