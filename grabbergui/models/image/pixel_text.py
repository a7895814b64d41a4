"""Values of a frame's components as text, for the cursor."""

from __future__ import annotations

from grabbergui.core.errors import PixelFormatError
from grabbergui.core.frame import Frame
from grabbergui.core.pixels import value_at
from grabbergui.models.image.components import ShownImage
from grabbergui.models.image.display_settings import DisplaySettings
from grabbergui.models.image.quantities import Quantity
from grabbergui.models.image.undistortion import distorted_pixel
from grabbergui.models.language import localized, translate

MOST_VALUES = 2500
"Largest number of pixels whose values are written; more would be too small to read."


def cursor_text(shown: ShownImage, pixel: tuple[int, int], settings: DisplaySettings) -> str:
    """Describe a pixel of the view: its column and line in the frame, and the value with its unit."""
    frame = shown.frame
    x, y = _pixel_of_frame(shown, pixel, settings)
    place = f"x {x}  y {y}"
    try:
        values = ", ".join(map(_sample_text, value_at(frame, x, y)))
        if shown.quantity is not None:
            return f"{place}   {_quantity_text(shown.quantity, x, y)}  ({values})"
    except (PixelFormatError, IndexError):
        return place
    return f"{place}   {frame.pixel_format.family.value} {values}"


def beside_text(
    main: ShownImage, other: ShownImage, pixel: tuple[int, int], settings: DisplaySettings
) -> str:
    """Return the value of a component beside `main` at a pixel of main's view; empty if it cannot be read.

    `settings` are those of `main`.
    """
    x = pixel[0] * other.width // max(1, main.width)
    y = pixel[1] * other.height // max(1, main.height)
    return value_at_text(other, (x, y), settings.of_other(other.label))


def value_at_text(shown: ShownImage, pixel: tuple[int, int], settings: DisplaySettings) -> str:
    """Return the value at a pixel of the view, with its unit if it has one; empty if it cannot be read."""
    x, y = _pixel_of_frame(shown, pixel, settings)
    try:
        if shown.quantity is not None:
            return _quantity_text(shown.quantity, x, y)
        return ", ".join(map(_sample_text, value_at(shown.frame, x, y)))
    except (PixelFormatError, IndexError):
        return ""


def value_texts(shown: ShownImage, settings: DisplaySettings) -> dict[tuple[int, int], str]:
    """Return the values of the visible region by column and line of the view, one line for each sample.

    Empty if the region is too large or undistorted, or if the format cannot be read.
    """
    frame, region = shown.frame, shown.image.region
    if region.width * region.height > MOST_VALUES or shown.calibration is not None:
        return {}
    texts = {}
    try:
        for y in range(region.y, region.bottom):
            for x in range(region.x, region.right):
                pixel = settings.orientation.pixel(x, y, frame.width, frame.height)
                texts[x, y] = _pixel_text(frame, shown.quantity, *pixel)
    except (PixelFormatError, IndexError):
        return {}
    return texts


def _sample_text(value: float) -> str:
    """Return a sample of a pixel as display text: integers in full, others with six digits."""
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _pixel_of_frame(shown: ShownImage, pixel: tuple[int, int], settings: DisplaySettings) -> tuple[int, int]:
    """Return the column and line in the frame of a pixel of the view."""
    x, y = settings.orientation.pixel(*pixel, shown.frame.width, shown.frame.height)
    return (x, y) if shown.calibration is None else distorted_pixel(shown.calibration, x, y)


def _quantity_text(quantity: Quantity, x: int, y: int) -> str:
    return localized(quantity.text_at(x, y, translate("Image", "no data")))


def _pixel_text(frame: Frame, quantity: Quantity | None, x: int, y: int) -> str:
    if quantity is not None:  # the unit below the number
        return localized(quantity.text_at(x, y, "–")).replace(" ", "\n")
    return "\n".join(map(_sample_text, value_at(frame, x, y)))
