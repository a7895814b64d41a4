"""Frames as pixels for the screen. The frame itself stays unchanged."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.core import pfnc
from grabbergui.core.calibration import Calibration
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import Family, PixelFormat
from grabbergui.core.pixels import DisplayImage, Region, for_display
from grabbergui.models.image.clipping import _with_clipping, clipping_masks
from grabbergui.models.image.display_settings import DisplaySettings
from grabbergui.models.image.quantities import (
    Levels,
    PolarisedView,
    Quantity,
    coloured,
    intensity_of,
    is_mosaic,
)
from grabbergui.models.image.undistortion import undistorted


def render(
    frame: Frame,
    region: Region | None,
    size: tuple[int, int] | None,
    settings: DisplaySettings,
    quantity: Quantity | None = None,
    calibration: Calibration | None = None,
) -> DisplayImage:
    """Return the image of a region of the view, in at most `size` screen pixels; see `pixels.for_display`.

    Region and size are the view's, and so is the returned region. `quantity` is the result of
    `settings.quantity` for the frame, if the caller has it already; `calibration` is the frame's, to show it
    undistorted. Raises PixelFormatError.
    """
    orientation = settings.orientation
    if region is not None:
        region = orientation.to_frame(region, frame.width, frame.height)
    if size is not None:
        size = orientation.view_size(*size)
    if calibration is not None:
        view = Region.of(frame, region)
        wanted = _fitting(view, size)
        # The whole frame in the view's resolution: distortion takes pixels from anywhere.
        region = None
        size = (
            max(1, round(frame.width * wanted[0] / view.width)),
            max(1, round(frame.height * wanted[1] / view.height)),
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
    """Return the image of a frame that measures light, with levels, colour map and clipping marks."""
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
        pixels = _with_clipping(pixels, *clipping_masks(frame, image.region))
    return DisplayImage(pixels, image.region)


def _fitting(region: Region, size: tuple[int, int] | None) -> tuple[int, int]:
    """Return width and height of a region's image within `size`, never enlarged."""
    scale = region.scale_within(size)
    return max(1, round(region.width * scale)), max(1, round(region.height * scale))


def _has_deep_levels(pixel_format: PixelFormat) -> bool:
    """Return whether levels apply to the sensor's own values instead of the 8 bits that are shown."""
    if pixel_format.needs_range or pixel_format.kind != "u" or pixel_format.depth <= 8:
        return False
    return pixel_format.family in (Family.MONO, Family.BAYER)


def _levelled(frame: Frame, levels: Levels) -> Frame:
    """Return a deep frame as one of 8 bits that spans the levels; others unchanged."""
    pixel_format = frame.pixel_format
    if levels.neutral or not _has_deep_levels(pixel_format):
        return frame
    top = (1 << pixel_format.depth) - 1
    black, white = round(levels.black * top), round(levels.white * top)
    # Subtraction saturates at 0, scaling at 255.
    above = cv2.subtract(frame.raw(), black)  # type: ignore[call-overload]
    shown = cv2.convertScaleAbs(above, alpha=255 / max(1, white - black))
    order = pixel_format.order
    eight = pfnc.by_name(f"Bayer{order}8" if order else "Mono8")
    return Frame(np.asarray(shown, np.uint8).reshape(-1), frame.width, frame.height, eight, frame.frame_id)


def _stretch(levels: Levels) -> NDArray[np.uint8]:
    span = max(levels.white - levels.black, 1 / 255)
    values = (np.arange(256) / 255 - levels.black) / span
    return np.clip(np.round(values * 255), 0, 255).astype(np.uint8)
