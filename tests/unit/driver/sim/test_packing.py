"""Packers against bytes worked out by hand from the layouts of the Pixel Format Naming Convention."""

import numpy as np
import pytest

from every_case import every_case
from grabbergui.core.pfnc import by_name
from grabbergui.driver.sim.packing import pack, pack_colour


@every_case(
    ("name", "values", "expected"),
    [
        ("Mono8", [0x12, 0xFF], "12ff"),
        ("Mono10", [0x3FF, 0x001], "ff030100"),
        ("Mono16", [0x1234, 0xABCD], "3412cdab"),
        # 10 bits each, lowest first: 1111111111 0000000000 1010101010 0101010101 from the right.
        ("Mono10p", [0x3FF, 0x000, 0x2AA, 0x155], "ff03a06a55"),
        ("Mono10p", [0x001, 0x002, 0x003, 0x004], "0108300001"),
        ("BayerRG12p", [0xABC, 0x123], "bc3a12"),
        ("Mono12p", [0x001, 0x800], "010080"),
        ("Mono12Packed", [0xABC, 0x123], "ab3c12"),
        ("BayerGB10Packed", [0x3FD, 0x002], "ff2100"),
        # An odd number of pixels: the last group is filled up with zeros and cut.
        ("Mono12p", [0xFFF, 0x001, 0x123], "ff1f002301"),
    ],
)
def test_pixels_lie_where_the_convention_puts_them(name, values, expected):
    pixel_format = by_name(name)
    dtype = np.uint8 if pixel_format.depth == 8 else np.uint16
    out = np.zeros(pixel_format.image_bytes(len(values), 1), np.uint8)
    pack(np.array([values], dtype), pixel_format, out)
    assert out.tobytes().hex() == expected


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("RGB8", "0a141e2800ff"),
        ("BGR8", "1e140aff0028"),
        ("RGBa8", "0a141eff2800ffff"),
        ("BGRa8", "1e140affff0028ff"),
    ],
)
def test_colours_keep_their_order_and_alpha_is_opaque(name, expected):
    rgb = np.array([[[10, 20, 30], [40, 0, 255]]], np.uint8)
    pixel_format = by_name(name)
    out = np.zeros(pixel_format.image_bytes(2, 1), np.uint8)
    pack_colour(rgb, pixel_format, out)
    assert out.tobytes().hex() == expected


@pytest.mark.parametrize(
    ("name", "luma", "blue", "red"),
    [
        ("YUV422_8", (0, 2), 1, 3),
        ("YCbCr422_8", (0, 2), 1, 3),
        ("YUV422_8_UYVY", (1, 3), 0, 2),
        ("YCbCr422_8_CbYCrY", (1, 3), 0, 2),
    ],
)
def test_luma_and_chroma_of_bt601_full_range(name, luma, blue, red):
    # Y = 0.299 R + 0.587 G + 0.114 B; Cb = 128 + (B - Y) / 1.772; Cr = 128 + (R - Y) / 1.402
    rgb = np.array([[[255, 0, 0], [255, 0, 0]]], np.uint8)
    out = np.zeros(4, np.uint8)
    pack_colour(rgb, by_name(name), out)
    values = out.astype(int)
    assert [values[at] for at in luma] == [76, 76]
    assert abs(values[blue] - 85) <= 1
    assert abs(values[red] - 255) <= 1
