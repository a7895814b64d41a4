"""From a frame to the picture that is painted: levels, colours, clipping marks, orientation."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.core import pfnc
from grabbergui.core.calibration import Calibration
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import Family
from grabbergui.core.pixels import DisplayImage, for_display
from grabbergui.core.region import Region
from grabbergui.models.picture import clipping
from grabbergui.models.picture.orientation import Orientation
from grabbergui.models.picture.undistortion import undistorted

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
    """How a picture is looked at; nothing of it changes the camera or what is saved."""

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
    if levels.neutral and frame.pixel_format.is_distance:
        levels = _measured(frame)
    image = for_display(_levelled(frame, levels), region, size)
    pixels = image.pixels
    if not levels.neutral and frame.pixel_format.depth <= 8:
        pixels = np.asarray(cv2.LUT(pixels, _stretch(levels)), np.uint8)
    if settings.colour_map and pixels.ndim == 2:
        pixels = np.asarray(cv2.applyColorMap(pixels, _colours(settings.colour_map)), np.uint8)
    if settings.show_clipping:
        pixels = clipping.painted(pixels, *clipping.masks(frame, image.region))
    shown = image.region
    if calibration is not None:
        pixels, shown = undistorted(pixels, calibration, view, wanted), view
    return DisplayImage(orientation.applied(pixels), orientation.to_view(shown, frame.width, frame.height))


def _fitting(region: Region, size: tuple[int, int] | None) -> tuple[int, int]:
    """Width and height of a region's picture: no more than `size`, nothing enlarged."""
    scale = min(1.0, size[0] / region.width, size[1] / region.height) if size else 1.0
    return max(1, round(region.width * scale)), max(1, round(region.height * scale))


def _measured(frame: Frame) -> Levels:
    """From the nearest to the farthest distance of a depth image, a few outliers aside.

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


def _levelled(frame: Frame, levels: Levels) -> Frame:
    """A frame of 8 bits that shows the levels of a deeper one, with all its gradations between them."""
    pixel_format = frame.pixel_format
    if levels.neutral or pixel_format.depth <= 8 or pixel_format.family not in (Family.MONO, Family.BAYER):
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
