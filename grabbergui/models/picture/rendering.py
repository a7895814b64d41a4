"""Frames as pixels for the screen: levels, clipping marks, values of single pixels."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.core import pfnc, unpacking
from grabbergui.core.calibration import Calibration
from grabbergui.core.colour import halved
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import Family, PixelFormat
from grabbergui.core.pixels import DisplayImage, Region, for_display
from grabbergui.core.scan3d import Scan3d
from grabbergui.models.picture.geometry import Orientation, undistorted
from grabbergui.models.picture.quantities import (
    Levels,
    PolarisedView,
    Quantity,
    coloured,
    intensity_of,
    is_mosaic,
    quantity_of,
)

Mask = NDArray[np.uint8]

SATURATED = (255, 60, 60)
"R G B of saturated pixels."
BLACK = (70, 110, 255)
"R G B of black pixels."


def clipping_masks(frame: Frame, region: Region) -> tuple[Mask, Mask]:
    """Return masks of a region's black and saturated pixels, 255 there and 0 elsewhere.

    Shape (region.height, region.width). A coloured pixel is saturated if any component is, black if all are;
    for YUV the luma counts, within its range. Signed values, coordinates and other values without a white
    level are never clipped. Raises PixelFormatError.
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
    """Return a picture, (height, width[, 3]) and perhaps reduced, with both masks painted over it, in R G B.

    One pixel of the masks is enough to show, however much the picture is reduced.
    """
    rgb = cv2.cvtColor(pixels, cv2.COLOR_GRAY2RGB) if pixels.ndim == 2 else pixels.copy()
    size = (pixels.shape[1], pixels.shape[0])
    for mask, colour in ((black, BLACK), (saturated, SATURATED)):
        if cv2.hasNonZero(mask):
            rgb[_reduced(mask, size) > 0] = colour
    return np.asarray(rgb, np.uint8)


def _largest(pixel_format: PixelFormat, lines: NDArray[Any]) -> NDArray[Any]:
    """Return each pixel's largest component, which must be 0 for black; for YUV the luma."""
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
    """Return a mask of (width, height), above zero wherever anything was.

    Halving is several times cheaper than an exact area average, but loses one pixel among very many:
    every step makes it whole again.
    """
    while mask.shape[1] >= 2 * size[0] and mask.shape[0] >= 2 * size[1]:
        mask = np.asarray(cv2.threshold(halved(mask), 0, 255, cv2.THRESH_BINARY)[1], np.uint8)
    if mask.shape[1::-1] != size:
        mask = np.asarray(cv2.resize(mask, size, interpolation=cv2.INTER_AREA), np.uint8)
    return mask


@dataclass(frozen=True)
class Appearance:
    """Levels and colours of one component."""

    levels: Levels = field(default_factory=Levels)
    colour_map: str = ""
    "One of COLOUR_MAPS; empty for grey."
    polarised: PolarisedView = PolarisedView.MOSAIC


@dataclass(frozen=True)
class DisplaySettings:
    """Display settings of the image. None of them changes the camera or saved frames."""

    levels: Levels = field(default_factory=Levels)
    colour_map: str = ""
    "One of COLOUR_MAPS; empty for grey."
    show_clipping: bool = False
    orientation: Orientation = field(default_factory=Orientation)
    component: str = ""
    "The label of the component that is shown; empty for the frame's own image."
    appearances: Mapping[str, Appearance] = field(default_factory=dict)
    "Of the components other than `component`, by their labels."
    side_by_side: bool = False
    "Whether all components of a frame are shown at once."
    scan: Scan3d = field(default_factory=Scan3d)
    "The camera's description of its coordinates."
    polarised: PolarisedView = PolarisedView.MOSAIC
    calibration: Calibration | None = None
    "Without whose distortion the picture is shown; None shows it as it is. Only for frames of its size."

    def quantity(self, frame: Frame) -> Quantity | None:
        """Return what a frame measures other than light, if anything. Raises PixelFormatError."""
        return quantity_of(frame, self.scan, self.polarised, self.levels, self.colour_map)

    def choosing(self, label: str, before: str) -> DisplaySettings:
        """Return the settings that show another component, as it was shown last.

        `before` is the label of the component shown so far.
        """
        own = Appearance(self.levels, self.colour_map, self.polarised)
        appearances = {**self.appearances, before: own}
        appearances.pop(label, None)
        return replace(self.of_other(label), appearances=appearances)

    def of_other(self, label: str) -> DisplaySettings:
        """Return the settings of a component that is shown beside the chosen one."""
        appearance = self.appearances.get(label, Appearance())
        return replace(
            self,
            component=label,
            levels=appearance.levels,
            colour_map=appearance.colour_map,
            polarised=appearance.polarised,
        )

    def undistorts(self, frame: Frame) -> Calibration | None:
        """Return the calibration without whose distortion a frame is shown, if any."""
        known = self.calibration
        return known if known and (known.width, known.height) == (frame.width, frame.height) else None


def render(
    frame: Frame,
    region: Region | None,
    size: tuple[int, int] | None,
    settings: DisplaySettings,
    quantity: Quantity | None = None,
) -> DisplayImage:
    """Return the picture of a region of the view, in at most `size` screen pixels; see `pixels.for_display`.

    Region and size are the view's, and so is the region that comes back. `quantity` is what
    `settings.quantity` gives for the frame, if the caller has it already. Raises PixelFormatError.
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
    quantity = quantity or settings.quantity(frame)
    image = _light(frame, region, size, settings) if quantity is None else quantity.paint(region, size)
    pixels = image.pixels
    shown = image.region
    if calibration is not None:
        pixels, shown = undistorted(pixels, calibration, view, wanted), view
    return DisplayImage(orientation.applied(pixels), orientation.to_view(shown, frame.width, frame.height))


def _light(
    frame: Frame, region: Region | None, size: tuple[int, int] | None, settings: DisplaySettings
) -> DisplayImage:
    """Return pixels that measure light: with levels, in a colour map, with clipping marks."""
    levels = settings.levels
    if settings.polarised is PolarisedView.INTENSITY and is_mosaic(frame):
        frame = intensity_of(frame)
    image = for_display(_levelled(frame, levels), region, size)
    pixels = image.pixels
    if not levels.neutral and not _has_deep_levels(frame.pixel_format):
        pixels = np.asarray(cv2.LUT(pixels, _stretch(levels)), np.uint8)
    if settings.colour_map and pixels.ndim == 2:
        pixels = coloured(pixels, settings.colour_map)
    if settings.show_clipping:
        pixels = with_clipping(pixels, *clipping_masks(frame, image.region))
    return DisplayImage(pixels, image.region)


def _fitting(region: Region, size: tuple[int, int] | None) -> tuple[int, int]:
    """Return width and height of a region's image: at most `size`, never enlarged."""
    scale = min(1.0, size[0] / region.width, size[1] / region.height) if size else 1.0
    return max(1, round(region.width * scale)), max(1, round(region.height * scale))


def _has_deep_levels(pixel_format: PixelFormat) -> bool:
    """Return whether levels choose among the sensor's own values, and not among the 8 bits that are shown."""
    if pixel_format.needs_range or pixel_format.kind != "u" or pixel_format.depth <= 8:
        return False
    return pixel_format.family in (Family.MONO, Family.BAYER)


def _levelled(frame: Frame, levels: Levels) -> Frame:
    """Return a frame of 8 bits that shows the levels of a deeper one, with full gradation between them."""
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


def with_levels(settings: DisplaySettings, black: float, white: float) -> DisplaySettings:
    """Return the settings with other levels, kept within the range and apart from each other."""
    black = min(max(black, 0.0), 0.999)
    white = min(max(white, black + 0.001), 1.0)
    return replace(settings, levels=Levels(black, white))
