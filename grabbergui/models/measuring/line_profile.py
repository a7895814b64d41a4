"""The values along a line through a frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.colour import BAYER_SECOND_LINE
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import Family
from grabbergui.core.pixels import for_display
from grabbergui.core.region import Region


@dataclass(frozen=True)
class Line:
    """From one pixel to another, both included; in the frame's own pixels."""

    x0: int
    y0: int
    x1: int
    y1: int

    @property
    def samples(self) -> int:
        """Pixels along it: steps of the longer side."""
        return max(abs(self.x1 - self.x0), abs(self.y1 - self.y0)) + 1

    def clipped(self, width: int, height: int) -> Line:
        """Both ends moved into a frame of that size."""
        x0, x1 = (min(max(x, 0), width - 1) for x in (self.x0, self.x1))
        y0, y1 = (min(max(y, 0), height - 1) for y in (self.y0, self.y1))
        return Line(x0, y0, x1, y1)


def measure(frame: Frame, line: Line, *, raw: bool = False) -> dict[str, NDArray[Any]]:
    """Values along the line by channel: the sensor's own of mono, 8-bit `R`, `G`, `B` of all else.

    With `raw` they are the sensor's own of any format: components as they came, and of a Bayer pattern each
    pixel's under the colour of its filter, with NaN where a pixel has another. Nearest pixels, nothing is
    interpolated along the line. Raises PixelFormatError.
    """
    line = line.clipped(frame.width, frame.height)
    x = np.rint(np.linspace(line.x0, line.x1, line.samples)).astype(int)
    y = np.rint(np.linspace(line.y0, line.y1, line.samples)).astype(int)
    if frame.pixel_format.family is Family.MONO:
        return {"grey": frame.raw()[y, x]}
    if raw:
        return _raw(frame, x, y)
    box = Region(int(x.min()), int(y.min()), int(np.ptp(x)) + 1, int(np.ptp(y)) + 1)
    image = for_display(frame, box)
    pixels = image.pixels[y - image.region.y, x - image.region.x]
    return {name: pixels[:, index] for index, name in enumerate("RGB")}


def _raw(frame: Frame, x: NDArray[Any], y: NDArray[Any]) -> dict[str, NDArray[Any]]:
    values, order = frame.raw()[y, x], frame.pixel_format.order
    if frame.pixel_format.family is Family.RGB:
        return {name: values[:, order.index(name)] for name in "RGB"}
    if frame.pixel_format.family is Family.YUV:
        # The chroma of two neighbours: U beside the left one, V beside the right one.
        luma = order.index("Y")
        return {"Y": values[:, luma], **_parted(values[:, 1 - luma], x % 2, ("U", "V"))}
    second = BAYER_SECOND_LINE[order]
    return _parted(values, 2 * (y % 2) + x % 2, (*order, *second))


def _parted(values: NDArray[Any], place: NDArray[Any], names: Sequence[str]) -> dict[str, NDArray[Any]]:
    """Values by name: that of their place among `names`."""
    kinds = np.array(names)[place]
    return {name: np.where(kinds == name, values, np.nan) for name in sorted(set(names), key="RGBUV".find)}
