"""Frames as pixels for the screen: levels, clipping marks, and the geometry of the view.

The view may be rotated, mirrored and undistorted; the frame itself stays unchanged.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.core import pfnc, unpacking
from grabbergui.core.calibration import Calibration, Scan3d
from grabbergui.core.colour import halved
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import Family, PixelFormat
from grabbergui.core.pixels import DisplayImage, Region, for_display
from grabbergui.models.image.quantities import (
    Levels,
    PolarisedView,
    Quantity,
    coloured,
    intensity_of,
    is_mosaic,
    quantity_of,
)

# -- orientation ---------------------------------------------------------------------------------
_ROTATIONS = {1: cv2.ROTATE_90_CLOCKWISE, 2: cv2.ROTATE_180, 3: cv2.ROTATE_90_COUNTERCLOCKWISE}


@dataclass(frozen=True)
class Orientation:
    """Mirroring, then rotation of a frame into the *view*; both have their origin at the top left."""

    quarter_turns: int = 0
    "Clockwise, 0 … 3."
    mirrored_x: bool = False
    "Whether left and right of the frame are exchanged."
    mirrored_y: bool = False

    @property
    def neutral(self) -> bool:
        """Whether the view equals the frame."""
        return self == Orientation()

    def turned(self, quarters: int) -> Orientation:
        """Return the orientation rotated clockwise."""
        return replace(self, quarter_turns=(self.quarter_turns + quarters) % 4)

    def mirrored(self, *, x: bool = False, y: bool = False) -> Orientation:
        """Return the current view with left and right (`x`) or top and bottom (`y`) exchanged."""
        if self.quarter_turns % 2:
            x, y = y, x  # the view's columns are the frame's lines
        return replace(self, mirrored_x=self.mirrored_x ^ x, mirrored_y=self.mirrored_y ^ y)

    def view_size(self, width: int, height: int) -> tuple[int, int]:
        """Return the view's size for a frame of that size, and vice versa."""
        return (height, width) if self.quarter_turns % 2 else (width, height)

    def to_view(self, region: Region, width: int, height: int) -> Region:
        """Return the region of the view that shows a region of a frame of that size."""
        region = self._mirrored(region, width, height)
        return _rotated(region, width, height, self.quarter_turns)

    def to_frame(self, region: Region, width: int, height: int) -> Region:
        """Return the region of a frame that a region of the view shows. Width and height are the frame's."""
        view_width, view_height = self.view_size(width, height)
        region = _rotated(region, view_width, view_height, -self.quarter_turns % 4)
        return self._mirrored(region, width, height)

    def pixel(self, x: int, y: int, width: int, height: int) -> tuple[int, int]:
        """Return the column and line in the frame of a pixel of the view."""
        region = self.to_frame(Region(x, y, 1, 1), width, height)
        return region.x, region.y

    def place_in(self, other: Orientation, x: float, y: float) -> tuple[float, float]:
        """Return where `other` shows what this orientation shows at `x`, `y`, in fractions of the view."""
        fine = 1 << 20
        region = self.to_frame(Region(round(x * fine), round(y * fine), 1, 1), fine, fine)
        region = other.to_view(region, fine, fine)
        return region.x / fine, region.y / fine

    def applied(self, pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Return the frame's pixels, (height, width[, 3]), in this orientation; contiguous, maybe no copy."""
        if self.mirrored_x or self.mirrored_y:
            code = -1 if self.mirrored_x and self.mirrored_y else int(self.mirrored_x)
            pixels = np.asarray(cv2.flip(pixels, code), np.uint8)
        if self.quarter_turns:
            pixels = np.asarray(cv2.rotate(pixels, _ROTATIONS[self.quarter_turns]), np.uint8)
        return pixels

    def _mirrored(self, region: Region, width: int, height: int) -> Region:
        x = width - region.right if self.mirrored_x else region.x
        y = height - region.bottom if self.mirrored_y else region.y
        return Region(x, y, region.width, region.height)


def _rotated(region: Region, width: int, height: int, quarters: int) -> Region:
    for _ in range(quarters):
        region = Region(height - region.bottom, region.x, region.height, region.width)
        width, height = height, width
    return region


def scaled_region(region: Region, size: tuple[int, int], other: tuple[int, int]) -> Region:
    """Return a region of an image of `size` as the same region of an image of the size `other`.

    Rounds outwards; sizes are (width, height).
    """
    if size == other:
        return region
    left, right = region.x * other[0] // size[0], -(-region.right * other[0] // size[0])
    top, bottom = region.y * other[1] // size[1], -(-region.bottom * other[1] // size[1])
    return Region(left, top, right - left, bottom - top)


# -- undistortion --------------------------------------------------------------------------------
Map = NDArray[np.float32]


def undistorted(
    pixels: NDArray[np.uint8], calibration: Calibration, region: Region, size: tuple[int, int]
) -> NDArray[np.uint8]:
    """Return a region of the undistorted view in `size` pixels (width, height).

    `pixels` is the whole frame, (height, width) or (height, width, 3), possibly reduced; `region` is in
    pixels of the unreduced frame, as the calibration. Pixels outside of the frame are black.
    """
    columns, lines = _maps(calibration, region, size, (pixels.shape[1], pixels.shape[0]))
    return np.asarray(cv2.remap(pixels, columns, lines, cv2.INTER_LINEAR), np.uint8)


def distorted_pixel(calibration: Calibration, x: int, y: int) -> tuple[int, int]:
    """Return the pixel of the frame that is seen at a pixel of the undistorted view; it may be outside."""
    (focal_x, _, centre_x), (_, focal_y, centre_y), _ = calibration.matrix.tolist()
    ray = np.array([[[(x - centre_x) / focal_x, (y - centre_y) / focal_y, 1.0]]])
    still = np.zeros(3)
    if calibration.fisheye:
        seen, _ = cv2.fisheye.projectPoints(ray, still, still, calibration.matrix, calibration.distortion)
    else:
        seen, _ = cv2.projectPoints(ray, still, still, calibration.matrix, calibration.distortion)
    column, line = seen.reshape(2).tolist()
    if not (math.isfinite(column) and math.isfinite(line)):  # the calibration is absurd here
        return -1, -1
    return round(column), round(line)


@lru_cache(maxsize=2)
def _maps(
    calibration: Calibration, region: Region, size: tuple[int, int], whole: tuple[int, int]
) -> tuple[Map, Map]:
    """Return each view pixel's position in the reduced frame; cached until the view moves."""
    part = calibration.cut_out(region.x, region.y, region.width, region.height)
    seen = part.resampled(*size, (size[0] / region.width, size[1] / region.height))
    mapped = cv2.fisheye.initUndistortRectifyMap if calibration.fisheye else cv2.initUndistortRectifyMap
    columns, lines = mapped(
        calibration.matrix, calibration.distortion, np.eye(3), seen.matrix, size, cv2.CV_32FC1
    )
    along_x, along_y = whole[0] / calibration.width, whole[1] / calibration.height
    return (
        np.asarray((columns + 0.5) * along_x - 0.5, np.float32),
        np.asarray((lines + 0.5) * along_y - 0.5, np.float32),
    )


# -- clipping marks ------------------------------------------------------------------------------
Mask = NDArray[np.uint8]

SATURATED_COLOUR = (255, 60, 60)
"R G B of saturated pixels."
BLACK_COLOUR = (70, 110, 255)
"R G B of black pixels."


def clipping_masks(frame: Frame, region: Region) -> tuple[Mask, Mask]:
    """Return masks of a region's black and saturated pixels, 255 for those and 0 for others.

    Shape (region.height, region.width). A coloured pixel is saturated if any component is, black if all are;
    for YUV the luma decides, within its range. Signed values, coordinates and other values without a white
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


def _with_clipping(pixels: NDArray[np.uint8], black: Mask, saturated: Mask) -> NDArray[np.uint8]:
    """Return an image, (height, width[, 3]) and possibly reduced, with both masks painted over it, in R G B.

    Even a single pixel of a mask shows, however much the image is reduced.
    """
    rgb = cv2.cvtColor(pixels, cv2.COLOR_GRAY2RGB) if pixels.ndim == 2 else pixels.copy()
    size = (pixels.shape[1], pixels.shape[0])
    for mask, colour in ((black, BLACK_COLOUR), (saturated, SATURATED_COLOUR)):
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
    """Return a mask reduced to (width, height), above zero wherever any pixel was.

    Repeated halving is several times cheaper than an exact area average, but would average a single pixel
    away; so every step restores full values.
    """
    while mask.shape[1] >= 2 * size[0] and mask.shape[0] >= 2 * size[1]:
        mask = np.asarray(cv2.threshold(halved(mask), 0, 255, cv2.THRESH_BINARY)[1], np.uint8)
    if mask.shape[1::-1] != size:
        mask = np.asarray(cv2.resize(mask, size, interpolation=cv2.INTER_AREA), np.uint8)
    return mask


# -- display settings ----------------------------------------------------------------------------
@dataclass(frozen=True)
class Appearance:
    """Levels and colours of one component."""

    levels: Levels = field(default_factory=Levels)
    colour_map: str = ""
    "One of COLOUR_MAPS; empty for grey."
    polarised: PolarisedView = PolarisedView.MOSAIC


@dataclass(frozen=True)
class DisplaySettings:
    """Display settings of the image, which change neither the camera nor saved frames."""

    levels: Levels = field(default_factory=Levels)
    colour_map: str = ""
    "One of COLOUR_MAPS; empty for grey."
    show_clipping: bool = False
    orientation: Orientation = field(default_factory=Orientation)
    component: str = ""
    "The label of the shown component; empty for the frame's own image."
    appearances: Mapping[str, Appearance] = field(default_factory=dict)
    "Appearances of the other components, by label."
    side_by_side: bool = False
    "Whether all components of a frame are shown at once."
    scan: Scan3d = field(default_factory=Scan3d)
    "The camera's description of its coordinates."
    polarised: PolarisedView = PolarisedView.MOSAIC
    calibration: Calibration | None = None
    "The calibration that undistorts frames of its size; None shows frames with their distortion."

    def quantity(self, frame: Frame) -> Quantity | None:
        """Return the quantity that a frame measures; None for light. Raises PixelFormatError."""
        return quantity_of(frame, self.scan, self.polarised, self.levels, self.colour_map)

    def choosing(self, label: str, before: str) -> DisplaySettings:
        """Return the settings that show another component with its last appearance.

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
        """Return the calibration that undistorts a frame, if any."""
        known = self.calibration
        return known if known and (known.width, known.height) == (frame.width, frame.height) else None


def with_levels(settings: DisplaySettings, black: float, white: float) -> DisplaySettings:
    """Return the settings with other levels, limited to the range and kept apart."""
    black = min(max(black, 0.0), 0.999)
    white = min(max(white, black + 0.001), 1.0)
    return replace(settings, levels=Levels(black, white))


# -- rendering -----------------------------------------------------------------------------------
def render(
    frame: Frame,
    region: Region | None,
    size: tuple[int, int] | None,
    settings: DisplaySettings,
    quantity: Quantity | None = None,
) -> DisplayImage:
    """Return the image of a region of the view, in at most `size` screen pixels; see `pixels.for_display`.

    Region and size are the view's, and so is the returned region. `quantity` is the result of
    `settings.quantity` for the frame, if the caller has it already. Raises PixelFormatError.
    """
    orientation = settings.orientation
    if region is not None:
        region = orientation.to_frame(region, frame.width, frame.height)
    if size is not None:
        size = orientation.view_size(*size)
    calibration = settings.undistorts(frame)
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
