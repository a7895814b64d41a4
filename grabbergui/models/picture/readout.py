"""The values of single pixels as text: under the cursor, and on pixels that have room for them."""

from __future__ import annotations

from grabbergui.core.errors import PixelFormatError
from grabbergui.core.frame import Frame
from grabbergui.core.pixels import value_at
from grabbergui.models.language import localized, translate
from grabbergui.models.picture.geometry import distorted_pixel
from grabbergui.models.picture.picture import Picture
from grabbergui.models.picture.quantities import Quantity
from grabbergui.models.picture.rendering import DisplaySettings

MOST = 2500
"Pixels of a region beyond which nothing is written; they would be too small to read."


def cursor_text(picture: Picture, pixel: tuple[int, int], settings: DisplaySettings) -> str:
    """Describe a pixel of the view: column and line in the frame, and the value there with its unit."""
    frame = picture.frame
    x, y = settings.orientation.pixel(*pixel, frame.width, frame.height)
    if (calibration := settings.undistorts(frame)) is not None:
        x, y = distorted_pixel(calibration, x, y)
    place = f"x {x}  y {y}"
    try:
        values = value_at(frame, x, y)
        if picture.quantity is not None:
            text = picture.quantity.text_at(x, y, translate("Picture", "no data"))
            raw = ", ".join(map(value_text, values))
            return f"{place}   {localized(text)}  ({raw})"
    except (PixelFormatError, IndexError):
        return place
    return f"{place}   {frame.pixel_format.family.value} {', '.join(map(value_text, values))}"


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
    """Return a component of a pixel as people read it: integers in full, others with six digits."""
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _text(frame: Frame, quantity: Quantity | None, x: int, y: int) -> str:
    if quantity is not None:
        return localized(quantity.text_at(x, y, "–"))
    return "\n".join(map(value_text, value_at(frame, x, y)))
