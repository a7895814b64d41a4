"""Values of a frame's components as text, for the cursor."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from grabbergui.core.errors import PixelFormatError
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import Family
from grabbergui.core.pixels import filter_at, interpolated_at, value_at
from grabbergui.models.image.components import ShownImage
from grabbergui.models.image.display_settings import DisplaySettings
from grabbergui.models.image.quantities import Quantity
from grabbergui.models.image.undistortion import distorted_pixel
from grabbergui.models.language import localized, translate

MOST_VALUES = 2500
"Largest number of pixels whose values are written; more would be too small to read."


class TintedPart(NamedTuple):
    """A part of a text."""

    text: str
    channel: str = ""
    "R, G or B if it is a value of this colour."


def plain_text(parts: Iterable[TintedPart], between: str = "") -> str:
    """Return the parts as one text."""
    return between.join(part.text for part in parts)


def cursor_text(
    shown: ShownImage, pixel: tuple[int, int], settings: DisplaySettings
) -> tuple[TintedPart, ...]:
    """Describe a pixel of the view: its column and line in the frame, and the value with its unit.

    Of a Bayer pattern, the value has the colour of its filter, and the interpolated colour follows.
    """
    frame = shown.frame
    x, y = _pixel_of_frame(shown, pixel, settings)
    place = f"x {x}  y {y}"
    try:
        parts = _value_parts(frame, x, y)
        if shown.quantity is not None:
            text = f"{place}   {_quantity_text(shown.quantity, x, y)}  ("
            return TintedPart(text), *_listed(parts), TintedPart(")")
        if channel := filter_at(frame, x, y):
            parts, colour = _named(parts, channel), _named(_interpolated(frame, x, y), "RGB")
            family = frame.pixel_format.family.value
            between = TintedPart("   (")
            return (
                TintedPart(f"{place}   {family} "),
                *_listed(parts),
                between,
                *_listed(colour),
                TintedPart(")"),
            )
    except (PixelFormatError, IndexError):
        return (TintedPart(place),)
    return TintedPart(f"{place}   {frame.pixel_format.family.value} "), *_listed(parts)


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


def value_texts(
    shown: ShownImage, settings: DisplaySettings
) -> dict[tuple[int, int], tuple[TintedPart, ...]]:
    """Return the values of the visible region by column and line of the view, one part for each line of text.

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


def _value_parts(frame: Frame, x: int, y: int) -> tuple[TintedPart, ...]:
    """Return the samples of a pixel. Raises PixelFormatError, IndexError."""
    texts = map(_sample_text, value_at(frame, x, y))
    if frame.pixel_format.family is Family.RGB:
        return tuple(
            TintedPart(text, channel) for text, channel in zip(texts, ("R", "G", "B", ""), strict=False)
        )
    channel = filter_at(frame, x, y)
    return tuple(TintedPart(text, channel) for text in texts)


def _interpolated(frame: Frame, x: int, y: int) -> tuple[TintedPart, ...]:
    """Return the colour that is shown for a pixel of a Bayer pattern. Raises PixelFormatError, IndexError."""
    return tuple(TintedPart(str(round(value))) for value in interpolated_at(frame, x, y))


def _named(parts: tuple[TintedPart, ...], channels: str) -> tuple[TintedPart, ...]:
    """Put the channel before each value."""
    named = zip(parts, channels, strict=True)
    return tuple(TintedPart(f"{channel} {part.text}", channel) for part, channel in named)


def _listed(parts: tuple[TintedPart, ...]) -> tuple[TintedPart, ...]:
    """Put commas between the parts."""
    first, *others = parts
    return first, *(each for part in others for each in (TintedPart(", "), part))


def _pixel_of_frame(shown: ShownImage, pixel: tuple[int, int], settings: DisplaySettings) -> tuple[int, int]:
    """Return the column and line in the frame of a pixel of the view."""
    x, y = settings.orientation.pixel(*pixel, shown.frame.width, shown.frame.height)
    return (x, y) if shown.calibration is None else distorted_pixel(shown.calibration, x, y)


def _quantity_text(quantity: Quantity, x: int, y: int) -> str:
    return localized(quantity.text_at(x, y, translate("Image", "no data")))


def _pixel_text(frame: Frame, quantity: Quantity | None, x: int, y: int) -> tuple[TintedPart, ...]:
    if quantity is not None:  # the unit below the number
        return tuple(map(TintedPart, localized(quantity.text_at(x, y, "–")).split(" ")))
    return _value_parts(frame, x, y)
