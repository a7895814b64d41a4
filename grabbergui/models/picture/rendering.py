"""Frames as pixels for the screen: levels, clipping marks, values of single pixels."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.core import pfnc, unpacking
from grabbergui.core.calibration import Calibration
from grabbergui.core.colour import halved
from grabbergui.core.errors import PixelFormatError
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import Family, PixelFormat
from grabbergui.core.pixels import DisplayImage, for_display, value_at
from grabbergui.core.region import Region
from grabbergui.models.picture.geometry import Orientation, undistorted

Mask = NDArray[np.uint8]

SATURATED = (255, 60, 60)
"R G B of saturated pixels."
BLACK = (70, 110, 255)
"R G B of black pixels."


def clipping_masks(frame: Frame, region: Region) -> tuple[Mask, Mask]:
    """Where a region is black and where it is saturated, 255 there and 0 elsewhere.

    Shape (region.height, region.width). A coloured pixel counts as saturated where any component is, as
    black where all are; of YUV the luma counts, within its range. Signed values, coordinates, and others
    without a white of their own are never clipped. Raises PixelFormatError.
    """
    pixel_format = frame.pixel_format
    if pixel_format.needs_range or pixel_format.kind == "i":
        unpacking.check(frame)
        nothing = np.zeros((region.height, region.width), np.uint8)
        return nothing, nothing
    if pixel_format.fields:  # the components' depths differ
        largest = for_display(frame, region).pixels.max(axis=2)
        return _mask(largest, 0, 0), _mask(largest, 255, 255)
    lines = unpacking.lines(frame, region.y, region.bottom)[:, region.x : region.right]
    values = _largest(pixel_format, np.ascontiguousarray(lines))
    top = (1 << pixel_format.depth) - 1
    if pixel_format.standard:
        scale = 1 << pixel_format.depth - 8
        return _mask(values, 0, 16 * scale), _mask(values, 235 * scale, top)
    return _mask(values, 0, 0), _mask(values, top, top)


def with_clipping(pixels: NDArray[np.uint8], black: Mask, saturated: Mask) -> NDArray[np.uint8]:
    """A picture, (height, width[, 3]) and perhaps reduced, with both masks painted over it, in R G B.

    One pixel of the masks is enough to show, however much the picture is reduced.
    """
    rgb = cv2.cvtColor(pixels, cv2.COLOR_GRAY2RGB) if pixels.ndim == 2 else pixels.copy()
    size = (pixels.shape[1], pixels.shape[0])
    for mask, colour in ((black, BLACK), (saturated, SATURATED)):
        if cv2.hasNonZero(mask):
            rgb[_reduced(mask, size) > 0] = colour
    return np.asarray(rgb, np.uint8)


def _largest(pixel_format: PixelFormat, lines: NDArray[Any]) -> NDArray[Any]:
    """Of each pixel the largest component, which must be 0 for black; of YUV the luma."""
    family, order = pixel_format.family, pixel_format.raw_order
    if family is Family.YUV:
        return np.ascontiguousarray(lines[:, :, order.index("Y")])
    if family in (Family.RGB, Family.BICOLOR):
        colours = [index for index, name in enumerate(order[: lines.shape[2]]) if name in "RGB"]
        largest = np.ascontiguousarray(lines[:, :, colours[0]])
        for index in colours[1:]:
            largest = cv2.max(largest, np.ascontiguousarray(lines[:, :, index]))
        return largest
    return lines


def _mask(values: NDArray[Any], low: int, high: int) -> Mask:
    return np.asarray(cv2.inRange(values, low, high), np.uint8)


def _reduced(mask: Mask, size: tuple[int, int]) -> Mask:
    """A mask of (width, height), above zero wherever anything was.

    Halving is several times cheaper than an exact area average, but loses one pixel among very many:
    every step makes it whole again.
    """
    while mask.shape[1] >= 2 * size[0] and mask.shape[0] >= 2 * size[1]:
        mask = np.asarray(cv2.threshold(halved(mask), 0, 255, cv2.THRESH_BINARY)[1], np.uint8)
    if mask.shape[1::-1] != size:
        mask = np.asarray(cv2.resize(mask, size, interpolation=cv2.INTER_AREA), np.uint8)
    return mask


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
                texts[x, y] = "\n".join(map(value_text, value_at(frame, *pixel)))
    except (PixelFormatError, IndexError):
        return {}
    return texts


def value_text(value: float) -> str:
    """Return a component of a pixel as people read it: integers in full, others with six digits."""
    return f"{value:.6g}" if isinstance(value, float) else str(value)


COLOUR_MAPS = {
    "Inferno": cv2.COLORMAP_INFERNO,
    "Viridis": cv2.COLORMAP_VIRIDIS,
    "Turbo": cv2.COLORMAP_TURBO,
    "Jet": cv2.COLORMAP_JET,
    "Bone": cv2.COLORMAP_BONE,
}
"""For pictures in grey, by the names people know."""
_SAMPLES = 20_000
"""Pixels of a depth image that its range is estimated from."""
_WITHOUT_OUTLIERS = (0.5, 99.5)
"""Percentiles."""


@dataclass(frozen=True)
class Levels:
    """Which of the sensor's values are shown as black and as white, as fractions of its range."""

    black: float = 0.0
    white: float = 1.0

    @property
    def neutral(self) -> bool:
        """Whether the whole range is shown."""
        return self == Levels()


@dataclass(frozen=True)
class DisplaySettings:
    """Display settings of the image. None of them changes the camera or saved frames."""

    levels: Levels = Levels()
    colour_map: str = ""
    "One of COLOUR_MAPS; empty for grey."
    show_clipping: bool = False
    orientation: Orientation = field(default_factory=Orientation)
    calibration: Calibration | None = None
    "Without whose distortion the picture is shown; None shows it as it is. Only for frames of its size."

    def undistorts(self, frame: Frame) -> Calibration | None:
        """Return the calibration without whose distortion a frame is shown, if any."""
        known = self.calibration
        return known if known and (known.width, known.height) == (frame.width, frame.height) else None


def render(
    frame: Frame, region: Region | None, size: tuple[int, int] | None, settings: DisplaySettings
) -> DisplayImage:
    """The picture of a region of the view, in at most `size` screen pixels; see `pixels.for_display`.

    Region and size are the view's, and so is the region that comes back. Raises PixelFormatError.
    """
    orientation = settings.orientation
    if region is not None:
        region = orientation.to_frame(region, frame.width, frame.height)
    if size is not None:
        size = orientation.view_size(*size)
    calibration = settings.undistorts(frame)
    if calibration is not None:
        view = (region or Region(0, 0, frame.width, frame.height)).clipped(frame.width, frame.height)
        wanted = _fitting(view, size)
        # The whole frame, as fine as the view: distortion takes pixels from anywhere.
        region, size = (
            None,
            (
                max(1, round(frame.width * wanted[0] / view.width)),
                max(1, round(frame.height * wanted[1] / view.height)),
            ),
        )
    levels = settings.levels
    if levels.neutral and frame.pixel_format.is_distance and not frame.pixel_format.needs_range:
        levels = _measured(frame)
    image = for_display(_levelled(frame, levels), region, size)
    pixels = image.pixels
    if not levels.neutral and not _has_deep_levels(frame.pixel_format):
        pixels = np.asarray(cv2.LUT(pixels, _stretch(levels)), np.uint8)
    if settings.colour_map and pixels.ndim == 2:
        pixels = np.asarray(cv2.applyColorMap(pixels, _colours(settings.colour_map)), np.uint8)
    if settings.show_clipping:
        pixels = with_clipping(pixels, *clipping_masks(frame, image.region))
    shown = image.region
    if calibration is not None:
        pixels, shown = undistorted(pixels, calibration, view, wanted), view
    return DisplayImage(orientation.applied(pixels), orientation.to_view(shown, frame.width, frame.height))


def _fitting(region: Region, size: tuple[int, int] | None) -> tuple[int, int]:
    """Width and height of a region's picture: no more than `size`, nothing enlarged."""
    scale = min(1.0, size[0] / region.width, size[1] / region.height) if size else 1.0
    return max(1, round(region.width * scale)), max(1, round(region.height * scale))


def _measured(frame: Frame) -> Levels:
    """From the nearest to the farthest distance of a depth image, without a few outliers.

    A sample will do; 0 is where nothing was measured.
    """
    every = max(1, round((frame.width * frame.height / _SAMPLES) ** 0.5))
    sample = frame.raw()[::every, ::every]
    found = sample[sample > 0]
    if not found.size:
        return Levels()
    top = (1 << frame.pixel_format.depth) - 1
    near, far = np.percentile(found, _WITHOUT_OUTLIERS)
    # The nearest is not quite black, which is what was not measured.
    return Levels(max(0.0, near - 1 - (far - near) / 16) / top, max(far, near + 1) / top)


def _has_deep_levels(pixel_format: PixelFormat) -> bool:
    """Whether levels choose among the sensor's own values, and not among the 8 bits that are shown."""
    if pixel_format.needs_range or pixel_format.kind != "u" or pixel_format.depth <= 8:
        return False
    return pixel_format.family in (Family.MONO, Family.BAYER)


def _levelled(frame: Frame, levels: Levels) -> Frame:
    """A frame of 8 bits that shows the levels of a deeper one, with all its gradations between them."""
    pixel_format = frame.pixel_format
    if levels.neutral or not _has_deep_levels(pixel_format):
        return frame
    top = (1 << pixel_format.depth) - 1
    black, white = round(levels.black * top), round(levels.white * top)
    # Subtracting saturates at 0, scaling at 255.
    above = cv2.subtract(frame.raw(), black)  # type: ignore[call-overload]
    shown = cv2.convertScaleAbs(above, alpha=255 / max(1, white - black))
    order = pixel_format.order
    eight = pfnc.by_name(f"Bayer{order}8" if order else "Mono8")
    return Frame(np.asarray(shown, np.uint8).reshape(-1), frame.width, frame.height, eight, frame.frame_id)


def _stretch(levels: Levels) -> NDArray[np.uint8]:
    span = max(levels.white - levels.black, 1 / 255)
    values = (np.arange(256) / 255 - levels.black) / span
    return np.clip(np.round(values * 255), 0, 255).astype(np.uint8)


@cache
def _colours(name: str) -> NDArray[np.uint8]:
    """The map's 256 colours, R G B, as applyColorMap takes them."""
    ramp = np.arange(256, dtype=np.uint8).reshape(256, 1)
    return np.ascontiguousarray(cv2.applyColorMap(ramp, COLOUR_MAPS[name])[:, :, ::-1], np.uint8)


def with_levels(settings: DisplaySettings, black: float, white: float) -> DisplaySettings:
    """Other levels, kept within the range and apart from each other."""
    black = min(max(black, 0.0), 0.999)
    white = min(max(white, black + 0.001), 1.0)
    return replace(settings, levels=Levels(black, white))
