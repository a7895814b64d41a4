"""What is written on single pixels: the sensor's own values."""

from __future__ import annotations

from grabbergui.core.errors import PixelFormatError
from grabbergui.core.frame import Frame
from grabbergui.core.pixels import value_at
from grabbergui.core.region import Region
from grabbergui.models.picture.orientation import Orientation

MOST = 2500
"Pixels of a region beyond which nothing is written; they would be too small to read."


def value_texts(frame: Frame, region: Region, orientation: Orientation) -> dict[tuple[int, int], str]:
    """The values of a region of the view, by its columns and lines; one line a component.

    Empty where the region is too large or the format cannot be read.
    """
    if region.width * region.height > MOST:
        return {}
    texts = {}
    try:
        for y in range(region.y, region.bottom):
            for x in range(region.x, region.right):
                pixel = orientation.pixel(x, y, frame.width, frame.height)
                texts[x, y] = "\n".join(map(str, value_at(frame, *pixel)))
    except (PixelFormatError, IndexError):
        return {}
    return texts
