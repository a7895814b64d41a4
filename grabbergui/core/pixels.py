"""Converts payload bytes to arrays and images; the interface of `unpacking` and `colour`.

Also computes quantities other than brightness: millimetres from 3D coordinates, polarisation from mosaics.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple, cast

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.core import colour, unpacking
from grabbergui.core.pfnc import Family
from grabbergui.core.unpacking import SensorImage

_RANGE_SAMPLES = 256
"Lines and columns, at least, on which the range of a frame is measured."


@dataclass(frozen=True)
class Region:
    """A rectangle in a frame's own pixels: (0, 0) is the first pixel of its payload."""

    x: int
    y: int
    width: int
    height: int

    @property
    def right(self) -> int:
        """The first column to its right."""
        return self.x + self.width

    @property
    def bottom(self) -> int:
        """The first line below it."""
        return self.y + self.height

    def clipped(self, width: int, height: int) -> Region:
        """Return the part inside an image of this size, at least one pixel.

        A region entirely outside becomes the nearest pixel of the image.
        """
        left, top = min(max(self.x, 0), width - 1), min(max(self.y, 0), height - 1)
        right, bottom = min(max(self.right, left + 1), width), min(max(self.bottom, top + 1), height)
        return Region(left, top, right - left, bottom - top)

    @classmethod
    def of(cls, frame: SensorImage, region: Region | None = None) -> Region:
        """Return the part of a region inside a frame, at least one pixel; the whole frame if None."""
        whole = cls(0, 0, frame.width, frame.height)
        return whole if region is None else region.clipped(whole.width, whole.height)

    def scale_within(self, size: tuple[int, int] | None) -> float:
        """Return the factor that reduces it to (width, height); 1 if it fits, or without a size."""
        return min(1.0, size[0] / self.width, size[1] / self.height) if size else 1.0


@dataclass(frozen=True, eq=False)
class DisplayImage:
    """A frame, or a part of it, ready for painting."""

    pixels: NDArray[np.uint8]
    "(height, width) uint8 of mono and 3D formats, (height, width, 3) uint8 R G B of colour; C-contiguous."
    region: Region
    "The part of the frame that `pixels` covers, edge to edge, in the frame's pixels."


def to_raw(frame: SensorImage) -> NDArray[Any]:
    """Return the values of `Frame.raw`. Raises PixelFormatError."""
    return unpacking.lines(frame)


def to_bgr(rgb: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return an image with its channels in the order of OpenCV."""
    return cast(NDArray[np.uint8], cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR))


def to_mono(frame: SensorImage) -> NDArray[np.uint8]:
    """Return the image of `Frame.mono`: luma of colour, the eight highest bits of deeper formats."""
    return colour.to_grey(_eight_bit_lines(frame), frame.pixel_format)


def to_rgb(frame: SensorImage) -> NDArray[np.uint8]:
    """Return the image of `Frame.rgb`; `core.colour` describes how each family becomes RGB."""
    return colour.to_rgb(_eight_bit_lines(frame), frame.pixel_format)


def for_display(
    frame: SensorImage, region: Region | None = None, size: tuple[int, int] | None = None
) -> DisplayImage:
    """Return an 8-bit image of a region (the whole frame if None), never larger than `size`.

    `size` is (width, height) in screen pixels. A larger region is reduced to fit, with its aspect ratio kept,
    and before colour is computed if that saves work; a smaller one is not enlarged; None reduces nothing. The
    region is clipped to the frame, and grows to whole cells of a mosaic or of subsampled colour;
    `DisplayImage.region` is the actual region. Deeper formats keep their eight highest bits; values without a
    defined white (32 bits, floating-point, coordinates) are scaled from the smallest of the frame to the
    largest. Pixels may be a read-only view of the payload. Any thread. Raises PixelFormatError.
    """
    unpacking.check(frame)
    family = frame.pixel_format.family
    region = _whole_cells(Region.of(frame, region), frame)
    if family is Family.BAYER and region.scale_within(size) <= 0.5 and min(region.width, region.height) > 1:
        # At half the size or less, each cell of four pixels becomes one, without interpolation. A last line
        # or column that is not a whole cell is omitted.
        region = Region(region.x, region.y, region.width & ~1, region.height & ~1)
        image = _reduced(colour.bayer_cells(_part(frame, region), frame.pixel_format.order), region, size)
    elif family in (Family.BAYER, Family.SPARSE):
        image = _reduced(_demosaiced_part(frame, region), region, size)
    elif family in (Family.YUV, Family.BICOLOR):
        image = _reduced(colour.to_rgb(_part(frame, region), frame.pixel_format), region, size)
    elif family is Family.COORDINATES:
        image = _reduced(colour.to_grey(_part(frame, region), frame.pixel_format), region, size)
    else:
        image = _reduced(_part(frame, region), region, size)
    if family is Family.RGB:
        image = colour.to_rgb(image, frame.pixel_format)
    return DisplayImage(image, region)


def value_at(frame: SensorImage, x: int, y: int) -> tuple[float, ...]:
    """Return the sensor's values of a pixel: one for mono and mosaics, (R, G, B[, alpha]) or (Y, U, V).

    The order does not depend on the one in memory, except for BiColor and coordinates. Values are integers
    unless the format is floating-point. Reads one line only. Raises PixelFormatError, and IndexError outside
    the frame.
    """
    if not (0 <= x < frame.width and 0 <= y < frame.height):
        raise IndexError(f"({x}, {y}) is outside the image of {frame.width}×{frame.height} pixels")
    family, order = frame.pixel_format.family, frame.pixel_format.raw_order
    values = unpacking.value_at(frame, x, y)
    if family is Family.RGB:
        return tuple(values[order.index(component)] for component in "RGBa" if component in order)
    if family is not Family.YUV:
        return values
    if len(values) == 3:
        return tuple(values[order.index(component)] for component in "YUV")
    luma = order.index("Y")
    other = unpacking.value_at(frame, x ^ 1, y) if x ^ 1 < frame.width else values
    chroma = values[1 - luma], other[1 - luma]
    return (values[luma], *(chroma if x % 2 == 0 else reversed(chroma)))


def filter_at(frame: SensorImage, x: int, y: int) -> str:
    """Return the colour of the filter on a pixel of a Bayer pattern: R, G or B; empty for other formats."""
    order = frame.pixel_format.order
    if frame.pixel_format.family is not Family.BAYER:
        return ""
    return (order + colour.BAYER_SECOND_LINE[order])[2 * (y % 2) + x % 2]


def interpolated_at(frame: SensorImage, x: int, y: int) -> tuple[float, float, float]:
    """Return red, green and blue at a pixel of a Bayer pattern, in the sensor's own values.

    Each is the pixel's value, or the mean of the nearest pixels with its filter, as in bilinear demosaicing.
    Raises PixelFormatError, and IndexError outside the frame.
    """
    found: dict[str, list[float]] = {"R": [], "G": [], "B": []}
    own = filter_at(frame, x, y)
    for row in range(max(0, y - 1), min(frame.height, y + 2)):
        for column in range(max(0, x - 1), min(frame.width, x + 2)):
            kind, corner = filter_at(frame, column, row), row != y and column != x
            here = (column, row) == (x, y)
            if here or (kind != own and not (kind == "G" and corner)):
                found[kind].append(value_at(frame, column, row)[0])
    red, green, blue = (float(np.mean(found[kind])) if found[kind] else 0.0 for kind in "RGB")
    return red, green, blue


def _bounds(frame: SensorImage) -> tuple[float, float] | None:
    """Return the range of a frame for display, the same for all its regions; None if the format has its own.

    For coordinates it is the range of the last one. It is measured on a sample of lines and columns.
    """
    if not frame.pixel_format.needs_range:
        return None
    every = max(1, frame.height // _RANGE_SAMPLES), max(1, frame.width // _RANGE_SAMPLES)
    sample = unpacking.lines(frame)[:: every[0], :: every[1]]
    return colour.measured_bounds(sample if sample.ndim == 2 else sample[..., -1])


def _eight_bit_lines(frame: SensorImage, first: int = 0, last: int | None = None) -> NDArray[np.uint8]:
    last = frame.height if last is None else last
    if not frame.pixel_format.needs_range and (high := unpacking.high_lines(frame, first, last)) is not None:
        return high
    return colour.eight_bits(unpacking.lines(frame, first, last), frame.pixel_format, _bounds(frame))


def _whole_cells(region: Region, frame: SensorImage) -> Region:
    across, down = frame.pixel_format.cell
    left, top = region.x - region.x % across, region.y - region.y % down
    right = min(-(-region.right // across) * across, frame.width)
    bottom = min(-(-region.bottom // down) * down, frame.height)
    return Region(left, top, right - left, bottom - top)


def _part(frame: SensorImage, region: Region) -> NDArray[np.uint8]:
    return _eight_bit_lines(frame, region.y, region.bottom)[:, region.x : region.right]


def _demosaiced_part(frame: SensorImage, region: Region) -> NDArray[np.uint8]:
    """Return a region in RGB as it is in the whole image, interpolated with the pixels around it."""
    margin = 2 if frame.pixel_format.family is Family.BAYER else 12
    left, top = max(0, region.x - margin), max(0, region.y - margin)
    right, bottom = min(region.right + margin, frame.width), min(region.bottom + margin, frame.height)
    around = Region(left, top, right - left, bottom - top)
    rgb = colour.to_rgb(_part(frame, around), frame.pixel_format)
    left, top = region.x - around.x, region.y - around.y
    return rgb[top : top + region.height, left : left + region.width]


def _reduced(image: NDArray[np.uint8], region: Region, size: tuple[int, int] | None) -> NDArray[np.uint8]:
    """Reduce the image of a region to at most `size`: halve it as often as possible, then interpolate.

    Halving averages four pixels in one vectorised pass, many times cheaper than an exact area average. The
    remaining factor is less than two, so linear interpolation skips no pixel.
    """
    scale = region.scale_within(size)
    # The caller may have rounded `size`, so that its aspect ratio differs from the region's; never exceed it.
    width, height = (max(1, round(side * scale)) for side in (region.width, region.height))
    if size:
        width, height = min(width, max(1, size[0])), min(height, max(1, size[1]))
    while image.shape[1] >= 2 * width and image.shape[0] >= 2 * height:
        image = colour.halved(image)
    if image.shape[1] > width or image.shape[0] > height:
        image = cast(NDArray[np.uint8], cv2.resize(image, (width, height), interpolation=cv2.INTER_LINEAR))
    return np.ascontiguousarray(image)


def millimetres(
    raw: NDArray[Any], scale: float, offset: float = 0.0, invalid: float | None = None
) -> NDArray[np.float32]:
    """Return coordinates in millimetres: raw × scale + offset, NaN where nothing was measured.

    `raw` is an array of `Frame.raw`, or one of its components. Scale, offset and invalid value are the
    features Scan3dCoordinateScale, Scan3dCoordinateOffset and Scan3dInvalidDataValue (SFNC, 3D Scan Control).
    """
    values = np.asarray(raw, np.float64) * scale + offset
    if invalid is not None:
        values[raw == invalid] = np.nan
    return values.astype(np.float32)


class Polarisation(NamedTuple):
    """Linear polarisation, each (height // 2, width // 2) float32."""

    intensity: NDArray[np.float32]
    "The mean of the values at the four angles, in the sensor's units."
    degree: NDArray[np.float32]
    "0 (none) to 1; noise can make it larger."
    angle: NDArray[np.float32]
    "Degrees from 0 to 180; undefined where the degree is 0."


def polarisation(mosaic: NDArray[Any]) -> Polarisation:
    """Compute linear polarisation from the mosaic of Sony's polarised sensors: 90°, 45° over 135°, 0°.

    `mosaic` is (height, width) of at least 2×2; a last line or column that is not a whole cell is omitted.
    """
    height, width = mosaic.shape[0] & ~1, mosaic.shape[1] & ~1
    values = mosaic[:height, :width].astype(np.float32)
    at_90, at_45 = values[0::2, 0::2], values[0::2, 1::2]
    at_135, at_0 = values[1::2, 0::2], values[1::2, 1::2]
    total = (at_0 + at_45 + at_90 + at_135) / 2  # Stokes' S0, S1, S2
    across, diagonal = at_0 - at_90, at_45 - at_135
    degree = np.hypot(across, diagonal) / np.maximum(total, np.finfo(np.float32).tiny)
    angle = np.degrees(np.arctan2(diagonal, across)) / 2 % 180
    return Polarisation(*(np.asarray(found, np.float32) for found in (total / 2, degree, angle)))
