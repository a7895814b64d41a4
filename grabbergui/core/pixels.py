"""Payload bytes to arrays, and to pictures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.core.region import Region

if TYPE_CHECKING:
    from grabbergui.core.frame import Frame


@dataclass(frozen=True, eq=False)
class DisplayImage:
    """A frame, or a part of it, made ready to be painted."""

    pixels: NDArray[np.uint8]
    "(height, width) uint8 for mono formats, (height, width, 3) uint8 R G B for colour; C-contiguous."
    region: Region
    "The part of the frame that `pixels` covers, edge to edge, in the frame's pixels."


def to_raw(frame: Frame) -> NDArray[Any]:
    """Interim."""
    n = frame.width * frame.height
    return frame.payload[:n].reshape(frame.height, frame.width)


def to_mono(frame: Frame) -> NDArray[np.uint8]:
    """Interim."""
    return to_raw(frame)


def to_rgb(frame: Frame) -> NDArray[np.uint8]:
    """Interim."""
    return np.repeat(to_raw(frame)[:, :, None], 3, axis=2)


def for_display(
    frame: Frame, region: Region | None = None, size: tuple[int, int] | None = None
) -> DisplayImage:
    """An 8-bit picture of a region (the whole frame if None), never larger than `size`.

    `size` is (width, height) in screen pixels; a larger region is reduced to fit, its proportions kept,
    before any colour is computed; nothing is ever enlarged. None reduces nothing. The region is clipped to
    the frame and may grow by a pixel to where a Bayer pattern starts: `DisplayImage.region` tells. Deeper
    formats keep their eight highest bits. Any thread. Raises PixelFormatError.
    """
    region = (region or Region(0, 0, frame.width, frame.height)).clipped(frame.width, frame.height)
    part = to_raw(frame)[region.y : region.bottom, region.x : region.right]
    scale = min(1.0, size[0] / region.width, size[1] / region.height) if size else 1.0
    if scale < 1:
        part = cv2.resize(part, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    return DisplayImage(np.ascontiguousarray(part), region)


def value_at(frame: Frame, x: int, y: int) -> tuple[int, ...]:
    """The sensor's values of one pixel: one of mono and Bayer, (R, G, B), (Y, U, V) … of colour.

    Components stand in the order of their names (R, G, B, alpha), whatever their order in memory. Reads a
    few bytes only. Raises PixelFormatError, IndexError outside the frame.
    """
    return (int(to_raw(frame)[y, x]),)
