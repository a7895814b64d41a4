"""The components of a frame: their labels, their images, and their values as text.

Also the images of several stream channels as components of one frame, and facts about the current camera that
the values need: whether its sensor is polarised, its Scan3d features.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, replace

from psygnal import Signal

from grabbergui.core.component import Component, ComponentKind, own_component
from grabbergui.core.errors import GrabberError, PixelFormatError
from grabbergui.core.frame import EncodedFrame, Frame
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.pixels import DisplayImage, value_at
from grabbergui.models.connection import Connection
from grabbergui.models.image.quantities import Quantity
from grabbergui.models.image.rendering import DisplaySettings, distorted_pixel
from grabbergui.models.language import localized, translate
from grabbergui.models.open_source import OpenSource


# -- labels --------------------------------------------------------------------------------------
def labels(frame: Frame) -> tuple[str, ...]:
    """Return unique labels of a frame's components in the user's language; empty if it has only one."""
    if len(frame.parts) < 2:
        return ()
    seen: Counter[str] = Counter()
    found = []
    several = len({part.source for part in frame.parts}) > 1
    for part in frame.parts:
        name = _name(part)
        if several:
            name = translate("Components", "{0}, source {1}").format(name, part.source)
        seen[name] += 1
        found.append(f"{name} {seen[name]}" if seen[name] > 1 else name)
    return tuple(found)


def _name(part: Component) -> str:
    return {
        ComponentKind.INTENSITY: translate("Components", "Intensity"),
        ComponentKind.INFRARED: translate("Components", "Infrared"),
        ComponentKind.ULTRAVIOLET: translate("Components", "Ultraviolet"),
        ComponentKind.RANGE: translate("Components", "Range"),
        ComponentKind.REFLECTANCE: translate("Components", "Reflectance"),
        ComponentKind.CONFIDENCE: translate("Components", "Confidence"),
        ComponentKind.SCATTER: translate("Components", "Scatter"),
        ComponentKind.DISPARITY: translate("Components", "Disparity"),
        ComponentKind.MULTISPECTRAL: translate("Components", "Multispectral"),
    }.get(part.kind, translate("Components", "Component"))


def own_label(frame: Frame) -> str:
    """Return the label of the frame's own image; empty if the frame has only one component."""
    own = own_component(frame.parts)
    return next((label for label, part in zip(labels(frame), frame.parts, strict=False) if part is own), "")


def chosen(frame: Frame, label: str) -> Frame:
    """Return the component with this label as a frame; the frame itself for its own image."""
    known = labels(frame)
    if label not in known or label == own_label(frame):
        return frame
    return frame.of_component(frame.parts[known.index(label)])


MOST_BESIDE = 9
"""Most components side by side; more would be too small to see."""


def beside(labels: tuple[str, ...], label: str) -> tuple[str, ...]:
    """Return the labels of the components to show beside `label`, at most `MOST_BESIDE` in all."""
    return tuple(other for other in labels if other != label)[: MOST_BESIDE - 1]


@dataclass(frozen=True, eq=False)
class ShownImage:
    """A frame and its visible part, ready to be painted."""

    frame: Frame
    "The component that is shown, as a frame of its own."
    image: DisplayImage
    width: int
    height: int
    "Width and height of the whole view, exchanged if it is turned on its side."
    labels: tuple[str, ...] = ()
    "The components to choose from; empty if there is only one."
    label: str = ""
    "The component that is shown, one of `labels`."
    quantity: Quantity | None = None
    "The quantity that the colours represent; None for light."
    others: tuple[ShownImage, ...] = ()
    "The same part of the other components; empty unless all are shown side by side."


# -- values as text ------------------------------------------------------------------------------
MOST_VALUES = 2500
"Largest number of pixels whose values are written; more would be too small to read."


def cursor_text(shown: ShownImage, pixel: tuple[int, int], settings: DisplaySettings) -> str:
    """Describe a pixel of the view: its column and line in the frame, and the value with its unit."""
    frame = shown.frame
    x, y = _pixel_of_frame(frame, pixel, settings)
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
    frame = shown.frame
    x, y = _pixel_of_frame(frame, pixel, settings)
    try:
        if shown.quantity is not None:
            return _quantity_text(shown.quantity, x, y)
        return ", ".join(map(_sample_text, value_at(frame, x, y)))
    except (PixelFormatError, IndexError):
        return ""


def value_texts(shown: ShownImage, settings: DisplaySettings) -> dict[tuple[int, int], str]:
    """Return the values of the visible region by column and line of the view, one line for each sample.

    Empty if the region is too large or undistorted, or if the format cannot be read.
    """
    frame, region = shown.frame, shown.image.region
    if region.width * region.height > MOST_VALUES or settings.undistorts(frame) is not None:
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


def _pixel_of_frame(frame: Frame, pixel: tuple[int, int], settings: DisplaySettings) -> tuple[int, int]:
    """Return the column and line in the frame of a pixel of the view."""
    x, y = settings.orientation.pixel(*pixel, frame.width, frame.height)
    calibration = settings.undistorts(frame)
    return (x, y) if calibration is None else distorted_pixel(calibration, x, y)


def _quantity_text(quantity: Quantity, x: int, y: int) -> str:
    return localized(quantity.text_at(x, y, translate("Image", "no data")))


def _pixel_text(frame: Frame, quantity: Quantity | None, x: int, y: int) -> str:
    if quantity is not None:  # the unit below the number
        return localized(quantity.text_at(x, y, "–")).replace(" ", "\n")
    return "\n".join(map(_sample_text, value_at(frame, x, y)))


# -- stream channels -----------------------------------------------------------------------------
CHANNEL_SILENCE = 2.0
"Seconds without a frame after which a channel is no longer shown."
MOST_CHANNELS = 16


class StreamChannels:
    """Merges the frames of several stream channels for display; with one channel, frames pass unchanged.

    Channels may have different rates: the newest frame of each is shown. One thread at a time.
    """

    def __init__(self) -> None:
        self._latest: dict[int, tuple[Frame, float]] = {}

    def clear(self) -> None:
        """Forget all frames, because another stream begins."""
        self._latest.clear()

    def merged(self, frame: Frame, now: float) -> Frame:
        """Add a frame that arrived at `now` (seconds), and return it with the other channels' images.

        The result is the frame of the lowest channel; each component's `source` is its channel.
        """
        self._latest[frame.stream_channel] = (frame, now)
        latest = {
            channel: kept
            for channel, (kept, seen) in sorted(self._latest.items())
            if now - seen < CHANNEL_SILENCE
        }
        if len(latest) != len(self._latest):
            self._latest = {channel: self._latest[channel] for channel in latest}
        if len(latest) < 2 or any(isinstance(kept, EncodedFrame) for kept in latest.values()):
            return frame
        parts = tuple(
            replace(part, source=channel)
            for channel, kept in list(latest.items())[:MOST_CHANNELS]
            for part in kept.components
        )
        return replace(next(iter(latest.values())), parts=parts)


# -- facts about the camera ----------------------------------------------------------------------
_POLARISED = re.compile(r"Polar(i[sz]|Mono|Angle)", re.IGNORECASE)
"""Vendors' names: `PolarizedAngles_0d_45d_90d_135d_Mono8`, `PolarizeMono12p`, `PolarizationMode`."""


def is_polarised(grabber: FrameGrabber) -> bool:
    """Return whether a camera has polarised pixel formats or features of polarisation.

    Waits for the camera. PFNC 2.4 does not mark a polarised mosaic, so a camera may send it as plain Mono.
    """
    try:
        if any(_POLARISED.match(feature.name) for feature in grabber.feature_tree().descriptions()):
            return True
        if not grabber.has_feature("PixelFormat"):
            return False
        return any(_POLARISED.match(entry.name) for entry in grabber.feature("PixelFormat").entries)
    except GrabberError:
        return False


class CameraWatch:
    """Reads a fact about each camera that becomes current, and again after changes that may affect it.

    No call waits. `changed` is emitted with the fact, on the source's thread.
    """

    changed = Signal(object)

    def __init__(
        self,
        connection: Connection,
        read: Callable[[FrameGrabber], object],
        depends_on: Callable[[frozenset[str]], bool] = lambda _: False,
    ) -> None:
        """`depends_on` returns whether a change of these features may change the fact."""
        self._read_fact = read
        self._depends_on = depends_on
        self._source: OpenSource | None = None
        connection.opened.connect(self._on_opened)
        connection.closing.connect(self._on_closing)

    def _on_opened(self, source: OpenSource) -> None:
        self._leave()
        if source.grabber is None:
            return
        self._source = source
        source.grabber.features_changed.connect(self._on_features_changed)
        self._read(source)

    def _on_closing(self, _: OpenSource) -> None:
        self._leave()

    def _leave(self) -> None:
        source, self._source = self._source, None
        if source is not None and source.grabber is not None:
            source.grabber.features_changed.disconnect(self._on_features_changed, missing_ok=True)

    def _on_features_changed(self, names: frozenset[str]) -> None:
        if (source := self._source) is not None and self._depends_on(names):
            self._read(source)

    def _read(self, source: OpenSource) -> None:
        grabber = source.grabber
        assert grabber is not None

        def publish(fact: object) -> None:
            if source is self._source:
                self.changed.emit(fact)

        key = self._read_fact.__qualname__
        source.worker.submit(lambda: self._read_fact(grabber), key=key, done=publish)
