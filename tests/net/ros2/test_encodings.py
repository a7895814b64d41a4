"""Pixel formats as ROS names them, without ROS."""

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


@pytest.mark.parametrize("pixel_format", pfnc.CONVERTIBLE, ids=str)
def test_every_format_we_show_has_an_encoding_that_we_can_show(pixel_format):
    back = format_of(encoding_of(pixel_format))

    assert (back.family, back.components) == (pixel_format.family, pixel_format.components)


def test_pixels_travel_without_a_copy_unless_packed():
    payload = np.arange(24, dtype=np.uint8)
    frame = Frame(payload, 4, 3, pfnc.by_name("Mono12"))

    assert np.shares_memory(pixels_of(frame), payload) and pixels_of(frame).dtype == "<u2"
    packed = Frame(payload[:18], 4, 3, pfnc.by_name("Mono12p"))
    assert pixels_of(packed).shape == (3, 4)


def test_what_has_no_encoding_is_named():
    with pytest.raises(PixelFormatError, match="Confidence8"):
        encoding_of(pfnc.by_name("Confidence8"))
    with pytest.raises(PixelFormatError, match="'32FC1' cannot be shown"):
        format_of("32FC1")
