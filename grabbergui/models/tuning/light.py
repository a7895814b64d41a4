"""How bright a region of a frame is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grabbergui.core import unpacking
from grabbergui.core.frame import Frame
from grabbergui.core.region import Region
from grabbergui.models.measuring.histogram import planes

NEARLY_WHITE = 0.98
"Part of the highest value from which on a pixel counts as saturated: not every sensor reaches the top."


@dataclass(frozen=True)
class Light:
    """What was measured, all as parts of white."""

    mean: float
    saturated: float
    "Fraction of the samples that are white, or nearly."
    channels: dict[str, float]
    "Mean of `R`, `G` and `B`; of `grey` or `Y` alone where there is no colour."

    @property
    def coloured(self) -> bool:
        """Whether red, green and blue were measured."""
        return self.channels.keys() >= {"R", "G", "B"}


def measure(frame: Frame, region: Region | None = None) -> Light:
    """Measure the sensor's own values in a region of the frame, or in all of it. Raises PixelFormatError."""
    region = region or Region(0, 0, frame.width, frame.height)
    region = _whole_cells(region.clipped(frame.width, frame.height), frame)
    raw = unpacking.lines(frame, region.y, region.bottom)[:, region.x : region.right]
    white = (1 << frame.pixel_format.depth) - 1
    sums: dict[str, float] = {}
    counts: dict[str, int] = {}
    saturated = 0
    for name, values in planes(raw, frame.pixel_format):
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
    """Begin on an even line and column and hold each colour of a Bayer pattern at least once."""
    x, y = region.x & ~1, region.y & ~1
    right, bottom = min(max(region.right, x + 2), frame.width), min(max(region.bottom, y + 2), frame.height)
    return Region(x, y, right - x, bottom - y)
