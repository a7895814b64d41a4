"""Pixel formats as ROS names them, without ROS."""

import re

import numpy as np
import pytest

from grabbergui.core import pfnc
from grabbergui.core.errors import PixelFormatError
from grabbergui.core.frame import Frame
from grabbergui.net.ros2.image_messages import encoding_of, format_of, pixels_of


@pytest.mark.parametrize(
    ("name", "encoding"),
    [
        ("Mono8", "mono8"),
        ("Mono10", "mono16"),
        ("Mono12p", "mono16"),
        ("BayerRG8", "bayer_rggb8"),
        ("BayerBG12Packed", "bayer_bggr16"),
        ("BayerGB16", "bayer_gbrg16"),
        ("BayerGR8", "bayer_grbg8"),
        ("RGB8", "rgb8"),
        ("BGRa8", "bgra8"),
        ("YUV422_8_UYVY", "yuv422"),
        ("YUV422_8", "yuv422_yuy2"),
    ],
)
def test_names(name, encoding):
    assert encoding_of(pfnc.by_name(name)) == encoding


WITHOUT = {"Mono32", "Data32", "Data64", "Data64s"}
"Formats that no encoding of ROS holds."
CHANNELS = {"mono": 1, "bayer": 1, "rgb": 3, "bgr": 3, "rgba": 4, "bgra": 4, "yuv": 2}


@pytest.mark.parametrize("pixel_format", [f for f in pfnc.CONVERTIBLE if f.name not in WITHOUT], ids=str)
def test_pixels_are_what_their_encoding_says(pixel_format):
    payload = np.zeros(pixel_format.image_bytes(8, 4), np.uint8)
    pixels, encoding = pixels_of(Frame(payload, 8, 4, pixel_format)), encoding_of(pixel_format)
    if generic := re.fullmatch(r"(\d+)([USF])C(\d)", encoding):
        bits, kind, channels = int(generic[1]), {"U": "u", "S": "i", "F": "f"}[generic[2]], int(generic[3])
    else:
        bits, kind = 16 if encoding.endswith("16") else 8, "u"
        channels = CHANNELS[re.match("[a-z]+", encoding)[0]]
    assert pixels.dtype == np.dtype(f"<{kind}{bits // 8}")
    assert pixels.shape == ((4, 8) if channels == 1 else (4, 8, channels))


def test_pixels_travel_without_a_copy_unless_packed():
    payload = np.arange(24, dtype=np.uint8)
    frame = Frame(payload, 4, 3, pfnc.by_name("Mono12"))

    assert np.shares_memory(pixels_of(frame), payload) and pixels_of(frame).dtype == "<u2"
    packed = Frame(payload[:18], 4, 3, pfnc.by_name("Mono12p"))
    assert pixels_of(packed).shape == (3, 4)


def test_what_has_no_encoding_is_named():
    for name in WITHOUT:
        with pytest.raises(PixelFormatError, match=name):
            encoding_of(pfnc.by_name(name))
    with pytest.raises(PixelFormatError, match="'64FC4' cannot be shown"):
        format_of("64FC4")


def test_encodings_come_back_as_the_formats_that_we_show():
    for name in ("Mono8", "Mono16", "BayerRG8", "RGB8", "RGB16", "YUV422_8", "Coord3D_C16", "Coord3D_ABC32f"):
        assert format_of(encoding_of(pfnc.by_name(name))).name == name
