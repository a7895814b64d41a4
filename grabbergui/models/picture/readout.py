"""The values of single pixels as text: under the cursor, and on pixels that have room for them."""

from __future__ import annotations

from grabbergui.core.errors import PixelFormatError
from grabbergui.core.frame import Frame
from grabbergui.core.pixels import value_at
from grabbergui.models.language import localized, translate
from grabbergui.models.picture.picture import Picture
from grabbergui.models.picture.quantities import Quantity
from grabbergui.models.picture.rendering import DisplaySettings, distorted_pixel

MOST = 2500
"Pixels of a region beyond which nothing is written; they would be too small to read."


def cursor_text(picture: Picture, pixel: tuple[int, int], settings: DisplaySettings) -> str:
    """Describe a pixel of the view: column and line in the frame, and the value there with its unit."""
    frame = picture.frame
    x, y = _pixel_of_frame(frame, pixel, settings)
    place = f"x {x}  y {y}"
    try:
        values = ", ".join(map(value_text, value_at(frame, x, y)))
        if picture.quantity is not None:
            return f"{place}   {_quantity_text(picture.quantity, x, y)}  ({values})"
    except (PixelFormatError, IndexError):
        return place
    return f"{place}   {frame.pixel_format.family.value} {values}"


def beside_text(main: Picture, other: Picture, pixel: tuple[int, int], settings: DisplaySettings) -> str:
    """Return the value of a component shown beside `main` at the place of one of main's pixels of the view.

    Empty where it cannot be read. `settings` are those of `main`.
    """
    x = pixel[0] * other.width // max(1, main.width)
    y = pixel[1] * other.height // max(1, main.height)
    return value_at_text(other, (x, y), settings.of_other(other.label))


def value_at_text(picture: Picture, pixel: tuple[int, int], settings: DisplaySettings) -> str:
    """Return the value at a pixel of the view, with its unit if it has one; empty if it cannot be read."""
    frame = picture.frame
    x, y = _pixel_of_frame(frame, pixel, settings)
    try:
        if picture.quantity is not None:
            return _quantity_text(picture.quantity, x, y)
        return ", ".join(map(value_text, value_at(frame, x, y)))
    except (PixelFormatError, IndexError):
        return ""


def value_texts(picture: Picture, settings: DisplaySettings) -> dict[tuple[int, int], str]:
    """Return the values of the region shown, by columns and lines of the view; one line a component.

    Empty where the region is too large, is shown without its distortion, or the format cannot be read.
    """
    frame, region = picture.frame, picture.image.region
    if region.width * region.height > MOST or settings.undistorts(frame) is not None:
        return {}
    texts = {}
    try:
        for y in range(region.y, region.bottom):
            for x in range(region.x, region.right):
                pixel = settings.orientation.pixel(x, y, frame.width, frame.height)
                texts[x, y] = _text(frame, picture.quantity, *pixel)
    except (PixelFormatError, IndexError):
        return {}
    return texts


def value_text(value: float) -> str:
    """Return a sample of a pixel as display text: integers in full, others with six digits."""
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _pixel_of_frame(frame: Frame, pixel: tuple[int, int], settings: DisplaySettings) -> tuple[int, int]:
    """Return column and line of the frame of which a pixel of the view shows the value."""
    x, y = settings.orientation.pixel(*pixel, frame.width, frame.height)
    calibration = settings.undistorts(frame)
    return (x, y) if calibration is None else distorted_pixel(calibration, x, y)


def _quantity_text(quantity: Quantity, x: int, y: int) -> str:
    return localized(quantity.text_at(x, y, translate("Picture", "no data")))


def _text(frame: Frame, quantity: Quantity | None, x: int, y: int) -> str:
    if quantity is not None:
        return localized(quantity.text_at(x, y, "–"))
    return "\n".join(map(value_text, value_at(frame, x, y)))
