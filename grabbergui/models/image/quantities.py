"""Display of sensor values: levels, and false colours with a scale for distances and polarisation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from functools import cache
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.core.coord3d import Scan3d
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import Family, PixelFormat, by_name
from grabbergui.core.pixels import DisplayImage, Region, polarisation

COLOUR_MAPS = {
    "Inferno": cv2.COLORMAP_INFERNO,
    "Viridis": cv2.COLORMAP_VIRIDIS,
    "Turbo": cv2.COLORMAP_TURBO,
    "Jet": cv2.COLORMAP_JET,
    "Bone": cv2.COLORMAP_BONE,
}
"""Colour maps for grey images, by their usual names."""
_CYCLE = {"Twilight": cv2.COLORMAP_TWILIGHT}
"""A cyclic colour map, for angles."""
NO_DATA = (72, 112)
"""The two greys of the hatching for pixels without a measurement; in no colour map they are neighbours."""
_HATCH = 4
"""Width of a stripe in screen pixels."""
_SAMPLES = 20_000
"""Number of pixels from which an image's range is estimated."""
_WITHOUT_OUTLIERS = (0.5, 99.5)
"""Percentiles."""
NOTHING_KNOWN = Scan3d()


@dataclass(frozen=True)
class Levels:
    """Sensor values shown as black and as white, as fractions of the sensor's range."""

    black: float = 0.0
    white: float = 1.0

    @property
    def neutral(self) -> bool:
        """Whether the whole range is shown."""
        return self == Levels()


ALL_LEVELS = Levels()


class PolarisedView(Enum):
    """The quantity shown for a polarised mosaic."""

    MOSAIC = ""
    INTENSITY = "intensity"
    DEGREE = "degree"
    ANGLE = "angle"


@dataclass(frozen=True)
class ColourScale:
    """The range of values that the colours of an image represent."""

    low: float
    "The value of the first colour, also used for smaller values; likewise `high` and the last colour."
    high: float
    unit: str
    "`mm`, `px`, `°`, or none."
    colour_map: str

    @property
    def colours(self) -> NDArray[np.uint8]:
        """256 colours from `low` to `high`, (256, 3) R G B, read-only."""
        return _colours(self.colour_map).reshape(256, 3)

    @property
    def ticks(self) -> tuple[float, ...]:
        """Three to six round values along the scale."""
        step = _round_step((self.high - self.low) / 5)
        first = np.ceil(self.low / step - 1e-6)
        last = np.floor(self.high / step + 1e-6)
        return tuple(float(step * count) for count in np.arange(first, last + 1))

    def text(self, value: float) -> str:
        """Return a value as a label of the scale, with enough digits to distinguish its ticks."""
        step = _round_step((self.high - self.low) / 5)
        digits = max(0, -int(np.floor(np.log10(step) + 1e-9)))
        return f"{value:.{digits}f}"


@dataclass(frozen=True, eq=False)
class Quantity:
    """A measured quantity at each pixel of a frame, and its colours."""

    samples: NDArray[Any]
    "(lines, columns[, coordinates]): the sensor's values, or computed from them."
    convert: Callable[[NDArray[Any]], NDArray[np.float32]]
    "Converts any part of `samples` to the scale's unit; NaN for pixels without a measurement."
    scale: ColourScale
    cell: int = 1
    "Number of columns and lines of the frame for one sample."

    def value_at(self, x: int, y: int) -> float:
        """Return the value at a pixel of the frame; NaN without a measurement. Raises IndexError."""
        if x < 0 or y < 0:
            raise IndexError(f"({x}, {y}) is outside the frame")
        return float(self.convert(self.samples[y // self.cell, x // self.cell][None])[0])

    def text_at(self, x: int, y: int, missing: str) -> str:
        """Return the value at a pixel with its unit, or `missing`. Raises IndexError."""
        value = self.value_at(x, y)
        if not np.isfinite(value):
            return missing
        digits = 3 if self.scale.high <= 1 else 1
        space = "" if self.scale.unit in ("", "°") else " "
        return f"{value:.{digits}f}{space}{self.scale.unit}"

    def paint(self, region: Region | None, size: tuple[int, int] | None) -> DisplayImage:
        """Colour a region of the frame (None: the whole frame), reduced to fit `size` (width, height).

        Drops samples instead of averaging them: the mean of two distances may be a place without any object.
        """
        cell, (lines, columns) = self.cell, self.samples.shape[:2]
        whole = Region(0, 0, columns * cell, lines * cell)
        region = (region or whole).clipped(whole.width, whole.height)
        left, top = region.x // cell, region.y // cell
        right, bottom = -(-region.right // cell), -(-region.bottom // cell)
        region = Region(left * cell, top * cell, (right - left) * cell, (bottom - top) * cell)
        scale = region.scale_within(size)
        width = min(right - left, max(1, round(region.width * scale)))
        height = min(bottom - top, max(1, round(region.height * scale)))
        part = self.samples[top:bottom, left:right]
        if (width, height) != (right - left, bottom - top):
            part = _decimated(part, width, height)
        indices, missing = self._colour_indices(part)
        rgb = coloured(indices, self.scale.colour_map)
        if missing.any():
            _hatch(rgb, missing)
        return DisplayImage(rgb, region)

    def _colour_indices(self, samples: NDArray[Any]) -> tuple[NDArray[np.uint8], NDArray[np.bool_]]:
        values = 1 << 8 * samples.itemsize
        if samples.dtype.kind != "u" or samples.ndim != 2 or samples.size < values:
            return _colour_indices(self.convert(samples), self.scale)
        # There are fewer possible values than pixels: convert each value once.
        table, missing = _colour_indices(self.convert(np.arange(values).astype(samples.dtype)), self.scale)
        return table.take(samples), missing.take(samples)


def quantity_of(
    frame: Frame,
    scan: Scan3d = NOTHING_KNOWN,
    view: PolarisedView = PolarisedView.MOSAIC,
    levels: Levels = ALL_LEVELS,
    colour_map: str = "",
) -> Quantity | None:
    """Return the quantity that a frame's pixels measure; None for light.

    Coordinates are coloured from the nearest to the farthest, rounded outwards so that the scale is steady,
    or between `levels`. Raises PixelFormatError.
    """
    pixel_format = frame.pixel_format
    if pixel_format.is_coordinate and pixel_format.convertible:
        raw = frame.raw()

        def to_unit(values: NDArray[Any]) -> NDArray[np.float32]:
            return scan.distances(values, pixel_format)

        low, high = _between_levels(raw, to_unit, pixel_format, levels)
        scale = ColourScale(low, high, scan.unit_of(pixel_format), colour_map or "Turbo")
        return Quantity(raw, to_unit, scale)
    if view in (PolarisedView.MOSAIC, PolarisedView.INTENSITY) or not is_mosaic(frame):
        return None
    found = polarisation(frame.raw())
    if view is PolarisedView.DEGREE:
        low, high = _levelled((0.0, 1.0), levels)
        return Quantity(found.degree, _same, ColourScale(low, high, "", colour_map or "Viridis"), cell=2)
    return Quantity(found.angle, _same, ColourScale(0.0, 180.0, "°", "Twilight"), cell=2)


def is_mosaic(frame: Frame) -> bool:
    """Return whether a frame of a polarised sensor may be its mosaic: unsigned brightness."""
    pixel_format = frame.pixel_format
    grey = pixel_format.family is Family.MONO and pixel_format.kind == "u"
    bright = pixel_format.name.startswith("Mono") or pixel_format.guessed
    return grey and bright and 8 <= pixel_format.depth <= 16 and frame.width >= 2 and frame.height >= 2


def intensity_of(frame: Frame) -> Frame:
    """Return a polarised mosaic as grey of the same size and depth, each cell with the mean of its pixels."""
    raw = frame.raw()
    cells = np.rint(polarisation(raw).intensity).astype(raw.dtype)
    edges = ((0, frame.height % 2), (0, frame.width % 2))
    grey = np.pad(cells.repeat(2, axis=0).repeat(2, axis=1), edges, mode="edge")
    pixel_format = by_name(f"Mono{frame.pixel_format.depth}")
    return Frame(grey.view(np.uint8).reshape(-1), frame.width, frame.height, pixel_format, frame.frame_id)


def coloured(pixels: NDArray[np.uint8], colour_map: str) -> NDArray[np.uint8]:
    """Colour a grey image, (height, width) uint8, by one of `COLOUR_MAPS`: (height, width, 3) R G B."""
    return np.asarray(cv2.applyColorMap(pixels, _colours(colour_map)), np.uint8)


def _same(values: NDArray[Any]) -> NDArray[np.float32]:
    return np.asarray(values, np.float32)


def _measured_range(
    raw: NDArray[Any], convert: Callable[[NDArray[Any]], NDArray[np.float32]]
) -> tuple[float, float]:
    """Return the range of a subset of the values without outliers, rounded outwards."""
    every = max(1, round((raw.shape[0] * raw.shape[1] / _SAMPLES) ** 0.5))
    sample = convert(raw[::every, ::every])
    found = sample[np.isfinite(sample)]
    if not found.size:
        return 0.0, 1.0
    near, far = (float(end) for end in np.percentile(found, _WITHOUT_OUTLIERS))
    step = _round_step(max(far - near, abs(far) * 1e-6, 1e-6) / 10)
    low = float(np.floor(near / step) * step)
    return low, max(float(np.ceil(far / step) * step), low + step)


def _between_levels(
    raw: NDArray[Any],
    convert: Callable[[NDArray[Any]], NDArray[np.float32]],
    pixel_format: PixelFormat,
    levels: Levels,
) -> tuple[float, float]:
    """Return the range of the colours; levels are fractions of the sensor's range, if it has one."""
    measured = _measured_range(raw, convert)
    if levels.neutral or pixel_format.needs_range:
        return _levelled(measured, levels)
    top = (1 << pixel_format.depth) - 1
    ends = [max(1, round(end * top)) for end in (levels.black, levels.white)]
    low, high = sorted(convert(np.array(ends, raw.dtype)).tolist())
    return (low, high) if np.isfinite([low, high]).all() and high > low else measured


def _levelled(bounds: tuple[float, float], levels: Levels) -> tuple[float, float]:
    """Return the part of a range between levels, which are fractions of it."""
    low, high = bounds
    return low + levels.black * (high - low), low + levels.white * (high - low)


def _round_step(least: float) -> float:
    """Return the smallest of 1, 2, 5 × 10ⁿ that is at least `least`."""
    power = 10.0 ** np.floor(np.log10(max(least, 1e-12)))
    return float(next(step * power for step in (1, 2, 5, 10) if step * power >= least * (1 - 1e-9)))


def _decimated(samples: NDArray[Any], width: int, height: int) -> NDArray[Any]:
    """Reduce samples to a number of columns and lines by dropping the others."""
    if samples.dtype in (np.uint8, np.uint16, np.float32):
        return np.asarray(cv2.resize(samples, (width, height), interpolation=cv2.INTER_NEAREST))
    lines, columns = samples.shape[:2]
    down, across = np.arange(height)[:, None] * lines // height, np.arange(width) * columns // width
    return np.asarray(samples[down, across])


def _colour_indices(
    values: NDArray[np.float32], scale: ColourScale
) -> tuple[NDArray[np.uint8], NDArray[np.bool_]]:
    """Return the index of each value's colour, and a mask of missing values."""
    missing = ~np.isfinite(values)
    fraction = (values - np.float32(scale.low)) * np.float32(255 / (scale.high - scale.low))
    fraction[missing] = 0
    return np.clip(fraction, 0, 255).astype(np.uint8), missing


def _hatch(rgb: NDArray[np.uint8], missing: NDArray[np.bool_]) -> None:
    """Hatch the pixels without a measurement."""
    lines, columns = np.nonzero(missing)
    dark = (lines + columns) // _HATCH % 2 == 0
    rgb[lines, columns] = np.where(dark, NO_DATA[0], NO_DATA[1]).astype(np.uint8).reshape(-1, 1)


@cache
def _colours(name: str) -> NDArray[np.uint8]:
    """Return the map's 256 colours, R G B, in the shape for applyColorMap."""
    ramp = np.arange(256, dtype=np.uint8).reshape(256, 1)
    found = cv2.applyColorMap(ramp, (COLOUR_MAPS | _CYCLE)[name])
    return np.ascontiguousarray(found[:, :, ::-1], np.uint8)
