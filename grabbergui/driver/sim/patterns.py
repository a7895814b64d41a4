"""Test patterns, made digitally behind the sensor: neither exposure nor gain changes them.

A ramp rises by one 8-bit value a pixel and begins again at 0 after 255; deeper pixels have zeros in their
low bits. Moving ramps move one pixel a frame. Colour bars are seen through the Bayer pattern.
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.core.pfnc import Family, PixelFormat
from grabbergui.driver.sim.registers import TestPattern

MOVING = frozenset((TestPattern.GREY_HORIZONTAL_RAMP_MOVING, TestPattern.GREY_VERTICAL_RAMP_MOVING))
"Patterns that differ from frame to frame."

_BARS = np.array(
    [(1, 1, 1), (1, 1, 0), (0, 1, 1), (0, 1, 0), (1, 0, 1), (1, 0, 0), (0, 0, 1), (0, 0, 0)], np.uint8
)
"White, yellow, cyan, green, magenta, red, blue, black."


def draw(
    pattern: TestPattern, width: int, height: int, frame_id: int, pixel_format: PixelFormat
) -> NDArray[Any]:
    """Values of the format's depth: (height, width) for mono and Bayer, (height, width, 3) for colour."""
    colour = pixel_format.family in (Family.RGB, Family.YUV)
    if pattern is TestPattern.COLOR_BAR:
        rgb = _bars(width, height)
        if colour:
            return rgb
        values = (
            mosaic(rgb, pixel_format.order) if pixel_format.order else cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY)
        )
    else:
        values = _grey(pattern, width, height, frame_id)
        if colour:
            return np.repeat(values[:, :, None], 3, axis=2)
    if pixel_format.depth == 8:
        return values
    deep = values.astype(np.uint16) << (pixel_format.depth - 8)
    if pattern is TestPattern.WHITE:
        deep |= (1 << (pixel_format.depth - 8)) - 1
    return deep


def _grey(pattern: TestPattern, width: int, height: int, frame_id: int) -> NDArray[np.uint8]:
    if pattern is TestPattern.BLACK:
        return np.zeros((height, width), np.uint8)
    if pattern is TestPattern.WHITE:
        return np.full((height, width), 255, np.uint8)
    shift = frame_id if pattern in MOVING else 0
    if pattern in (TestPattern.GREY_HORIZONTAL_RAMP, TestPattern.GREY_HORIZONTAL_RAMP_MOVING):
        line = ((np.arange(width) + shift) & 0xFF).astype(np.uint8)
        return np.tile(line, (height, 1))
    column = ((np.arange(height) + shift) & 0xFF).astype(np.uint8)
    return np.repeat(column[:, None], width, axis=1)


def _bars(width: int, height: int) -> NDArray[np.uint8]:
    line = _BARS[np.arange(width) * len(_BARS) // width] * np.uint8(255)
    return np.tile(line, (height, 1, 1))


_CHANNEL_AT = {
    "RG": ((0, 1), (1, 2)),
    "GR": ((1, 0), (2, 1)),
    "GB": ((1, 2), (0, 1)),
    "BG": ((2, 1), (1, 0)),
}
"Bayer order to the channel (R 0, G 1, B 2) of each pixel of the 2×2 pattern, row by row."


def mosaic(rgb: NDArray[Any], order: str) -> NDArray[Any]:
    """What a sensor behind a Bayer filter sees of a picture (rows, columns, 3): (rows, columns)."""
    raw = np.empty(rgb.shape[:2], rgb.dtype)
    for row, channels in enumerate(_CHANNEL_AT[order]):
        for column, channel in enumerate(channels):
            raw[row::2, column::2] = rgb[row::2, column::2, channel]
    return raw


def stamp(values: NDArray[Any], frame_id: int, white: int) -> None:
    """Draw a frame's number into the lower left corner, white on black, a twelfth of the height high."""
    height, width = values.shape[:2]
    text = f"{frame_id:08d}"
    scale = max(min(height / 360, width / 180), 0.2)
    (text_width, text_height), baseline = cv2.getTextSize(text, cv2.FONT_HERSHEY_SIMPLEX, scale, 1)
    margin = max(int(4 * scale), 1)
    box = values[max(height - text_height - baseline - 2 * margin, 0) :, : text_width + 2 * margin]
    box[...] = 0
    thickness = max(round(scale * 1.5), 1)
    plain = np.zeros(box.shape[:2], np.uint8)
    place = (margin, box.shape[0] - baseline - margin)
    cv2.putText(plain, text, place, cv2.FONT_HERSHEY_SIMPLEX, scale, 255, thickness)
    box[plain > 127] = white
