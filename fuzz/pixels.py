"""Pixels: any payload with any format's code and any size."""

from __future__ import annotations

import contextlib

import numpy as np

from fuzz._input import Input
from grabbergui.core import pfnc
from grabbergui.core.errors import PixelFormatError
from grabbergui.core.frame import Frame

CODES = (
    0x01080001, 0x01100003, 0x010A0046, 0x010C0047, 0x010C0004, 0x010C0006, 0x01080009, 0x010C002B,
    0x010C0057, 0x010A0058, 0x02180014, 0x02180015, 0x02200016, 0x0210001F, 0x02100032, 0x020C001E,
    0x0224005D, 0x0220001D, 0x02100035, 0x010100C5, 0x82FF1234,
    *(known.code for known in pfnc.FORMATS if known.convertible),
)  # fmt: skip
"The first ones by hand, as saved findings name them by their place; then all others."


def seeds() -> list[bytes]:
    """Return a small image of each format."""
    return [bytes((index, 0, 4, 0, 2, 0)) + bytes(range(64)) for index in range(min(len(CODES), 0xFF))]


def one_input(data: bytes) -> None:
    """Make every view of one frame."""
    source = Input(data)
    code = CODES[choice % len(CODES)] if (choice := source.number(1)) < 0xFF else source.number(4)
    width, height, flags = source.number(2), source.number(2), source.number(1)
    frame = Frame(
        payload=np.frombuffer(source.rest(), np.uint8),
        width=width,
        height=height,
        pixel_format=pfnc.by_code(code),
        padding_x=flags >> 4,
        big_endian=bool(flags & 1),
    )
    with contextlib.suppress(PixelFormatError):
        raw = frame.raw()
        if raw.shape[:2] != (height, width):
            raise AssertionError(f"{frame.pixel_format} of {width}x{height} became {raw.shape}")
    with contextlib.suppress(PixelFormatError):
        colours = frame.rgb()
        if colours.shape != (height, width, 3) or colours.dtype != np.uint8:
            raise AssertionError(f"{frame.pixel_format} of {width}x{height} became {colours.shape}")
    with contextlib.suppress(PixelFormatError):
        frame.mono()
