"""How light an image is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grabbergui.core.frame import Frame
from grabbergui.core.pixels import Region
from grabbergui.models.measuring import measurable, planes

NEARLY_WHITE = 0.98
"Fraction of the highest value from which a pixel counts as saturated: some sensors do not reach the top."


@dataclass(frozen=True)
class Light:
    """A measurement of brightness; all values are fractions of white."""

    mean: float
    saturated: float
    "Fraction of the samples that are white or nearly white."
    channels: dict[str, float]
    "Mean of `R`, `G` and `B`; of `grey` or `Y` without colour."

    @property
    def coloured(self) -> bool:
        """Whether red, green and blue were measured."""
        return self.channels.keys() >= {"R", "G", "B"}


def measure_light(frame: Frame, region: Region | None = None) -> Light:
    """Measure the sensor's values in a region of the frame, by default all of it. Raises PixelFormatError."""
    region = _whole_cells(Region.of(frame, region), frame)
    raw, pixel_format = measurable(frame, region)
    white = (1 << pixel_format.depth) - 1
    sums: dict[str, float] = {}
    counts: dict[str, int] = {}
    saturated = 0
    for name, values in planes(raw, pixel_format):
        sums[name] = sums.get(name, 0.0) + float(values.sum(dtype=np.float64))
        counts[name] = counts.get(name, 0) + values.size
        saturated += int(np.count_nonzero(values >= NEARLY_WHITE * white))
    samples = max(1, sum(counts.values()))
    return Light(
        sum(sums.values()) / samples / white,
        saturated / samples,
        {name: sums[name] / max(1, counts[name]) / white for name in sums},
    )


def _whole_cells(region: Region, frame: Frame) -> Region:
    """Return a region that begins on an even line and column and has every colour of a Bayer pattern."""
    x, y = region.x & ~1, region.y & ~1
    right, bottom = min(max(region.right, x + 2), frame.width), min(max(region.bottom, y + 2), frame.height)
    return Region(x, y, right - x, bottom - y)
