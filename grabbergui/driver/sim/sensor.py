"""Light to pixels: exposure, gain, noise, black level and gamma, as fast as the memory allows.

The order on the chip is: radiance × exposure × gain, balanced, clipped at white, to the power of gamma,
plus black level and noise. A power of a product is the product of powers, so everything that does not
change from frame to frame (binning, mirroring, balance, gamma, Bayer pattern) goes into a prepared image,
and a frame is one multiplication of a window of it. Work goes in strips that stay in the processor's cache.

Test patterns are made digitally behind the sensor: neither exposure nor gain changes them. A ramp rises by
one 8-bit value a pixel and begins again at 0 after 255; deeper pixels have zeros in their low bits. Moving
ramps move one pixel a frame. Colour bars are seen through the Bayer pattern.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.core.pfnc import Family, PixelFormat
from grabbergui.driver.sim.enumerations import TestPattern
from grabbergui.driver.sim.lookup_table import look_up
from grabbergui.driver.sim.packing import COLOURED, pack, pack_colour, sensor_depth
from grabbergui.driver.sim.registers import SENSOR_HEIGHT, SENSOR_WIDTH
from grabbergui.driver.sim.scene import LUMINANCE, UNIT, UNIT_EXPOSURE_US, Scene, SceneView, StudioScene
from grabbergui.driver.sim.settings import FrameSettings, Optics

_STRIP_VALUES = 128 * 1024
_NOISE_VALUES = 1 << 20
_READ_NOISE = 0.3
"Standard deviation of the noise at 0 dB, in values of an 8-bit pixel."
MOVING = frozenset((TestPattern.GREY_HORIZONTAL_RAMP_MOVING, TestPattern.GREY_VERTICAL_RAMP_MOVING))
"Patterns that differ from frame to frame."
_BARS = np.array(
    [(1, 1, 1), (1, 1, 0), (0, 1, 1), (0, 1, 0), (1, 0, 1), (1, 0, 0), (0, 0, 1), (0, 0, 0)], np.uint8
)
"White, yellow, cyan, green, magenta, red, blue, black."
_CHANNEL_AT = {
    "RG": ((0, 1), (1, 2)),
    "GR": ((1, 0), (2, 1)),
    "GB": ((1, 2), (0, 1)),
    "BG": ((2, 1), (1, 0)),
}
"Bayer order to the channel (R 0, G 1, B 2) of each pixel of the 2×2 pattern, row by row."


class Sensor:
    """Renders frames of a scene. Use from one thread."""

    def __init__(self, scene: Scene | None = None, seed: int = 1) -> None:
        self.scene: Scene = scene or StudioScene()
        self._prepared = _Prepared()
        self._noise = _Noise(seed)
        self._still_key: tuple[Any, ...] | None = None
        self._still = np.empty(0, np.uint8)

    def prepare(self, settings: FrameSettings) -> None:
        """Do what takes long at the first frame with these settings, which would be late, and so the next."""
        self.scene.prepare()
        if settings.test_pattern in (TestPattern.OFF, TestPattern.FRAME_COUNTER):
            self._window(settings, 0)
            self._noise.at(settings.amplification, settings.pixel_format.depth > 8, 0)

    def render(
        self, settings: FrameSettings, frame_id: int, time_ns: int, out: NDArray[np.uint8]
    ) -> NDArray[Any]:
        """Fill `out` (at least the image's bytes) and return the image's values before packing.

        The values are (height, width) for mono and Bayer, (height, width, 3) R G B for colour formats, uint8
        or uint16; valid until the next call.
        """
        out = out[: settings.image_bytes]
        pattern = settings.test_pattern
        if pattern not in (TestPattern.OFF, TestPattern.FRAME_COUNTER):
            return self._render_pattern(settings, frame_id, out)
        pixel_format = settings.pixel_format
        direct = out.reshape(settings.height, settings.width) if _is_plain(pixel_format) else None
        values = self._expose(settings, frame_id, time_ns, direct)
        if pattern is TestPattern.FRAME_COUNTER:
            stamp(values, frame_id, (1 << sensor_depth(pixel_format)) - 1)
        if direct is None:
            _pack(values, pixel_format, out)
        return values

    def _render_pattern(self, settings: FrameSettings, frame_id: int, out: NDArray[np.uint8]) -> NDArray[Any]:
        """Draw a static pattern only once, so that a benchmark's source costs one copy per frame."""
        pattern, pixel_format = settings.test_pattern, settings.pixel_format
        key = (pattern, pixel_format.code, settings.width, settings.height)
        if pattern in MOVING or key != self._still_key:
            values = draw_pattern(pattern, settings.width, settings.height, frame_id, pixel_format)
            self._still = np.empty(settings.image_bytes, np.uint8)
            self._still_values = values
            self._still_key = key
            _pack(values, pixel_format, self._still)
        out[:] = self._still
        return self._still_values

    def _expose(
        self, settings: FrameSettings, frame_id: int, time_ns: int, direct: NDArray[np.uint8] | None
    ) -> NDArray[Any]:
        pixel_format, optics = settings.pixel_format, settings.optics
        window = self._window(settings, time_ns)
        light = settings.exposure_us / UNIT_EXPOSURE_US * settings.amplification
        # The prepared image holds (radiance / UNIT) ** gamma * UNIT.
        factor = light**optics.gamma / UNIT
        deep = pixel_format.depth > 8
        values = direct
        if values is None:
            values = np.empty(window.shape, np.uint16 if deep else np.uint8)
        noise = self._noise.at(settings.amplification, deep, frame_id)
        lines = max(_STRIP_VALUES // (window.shape[1] * (window.shape[2] if window.ndim == 3 else 1)), 1)
        for top in range(0, settings.height, lines):
            source, target = window[top : top + lines], values[top : top + lines]
            if deep:
                cv2.addWeighted(source, factor * 65535, source, 0, settings.black_level * 257, dst=target)
            else:
                cv2.convertScaleAbs(source, dst=target, alpha=factor * 255, beta=settings.black_level)
            bright, dark = noise.next(target.shape)
            cv2.add(target, bright, dst=target)
            cv2.subtract(target, dark, dst=target)
            if deep and pixel_format.depth < 16:
                np.right_shift(target, 16 - sensor_depth(pixel_format), out=target)
            if settings.lut is not None:
                look_up(target, sensor_depth(pixel_format) if deep else 8, settings.lut)
        return values

    def _window(self, settings: FrameSettings, time_ns: int) -> NDArray[np.uint16]:
        kind = _kind(settings.pixel_format)
        image = self.scene.rendered(time_ns, settings, grey=kind == Family.MONO.value)
        if image is None:
            return self._prepared.window(self.scene.view(time_ns), settings)
        optics = Optics(gamma=settings.optics.gamma, ratios=settings.optics.ratios)
        return _prepare(image, optics, kind)


def _kind(pixel_format: PixelFormat) -> str:
    """Return the preparation that an image needs: the mosaic's order, or the family."""
    if pixel_format.family is Family.BAYER:
        return pixel_format.order
    return Family.RGB.value if pixel_format.family in COLOURED else Family.MONO.value


def _is_plain(pixel_format: PixelFormat) -> bool:
    """Return whether values are the payload's bytes as they are."""
    plain = pixel_format.family in (Family.MONO, Family.BAYER) and pixel_format.kind == "u"
    return plain and pixel_format.bits_per_pixel == pixel_format.depth == 8


def _pack(values: NDArray[Any], pixel_format: PixelFormat, out: NDArray[np.uint8]) -> None:
    if pixel_format.family in COLOURED:
        pack_colour(values, pixel_format, out)
    else:
        pack(values, pixel_format, out)


@dataclass(frozen=True, eq=False)
class _Preparation:
    """A scene's image with everything applied that does not change from frame to frame."""

    scene_image: NDArray[np.uint16]
    optics: Optics
    kind: str
    image: NDArray[np.uint16]

    def serves(self, scene_image: NDArray[np.uint16], optics: Optics, kind: str) -> bool:
        return (scene_image is self.scene_image) and (optics, kind) == (self.optics, self.kind)


class _Prepared:
    """Prepares the scene's image when the optics change. Cameras that see the same share the latest two."""

    _latest: ClassVar[tuple[_Preparation, ...]] = ()
    "For a colour camera and a grey one, say. Replaced as a whole, so that any thread may read it."

    def __init__(self) -> None:
        self._held: _Preparation | None = None

    def window(self, view: SceneView, settings: FrameSettings) -> NDArray[np.uint16]:
        """Return the view of the frame's region of the sensor."""
        optics, kind = settings.optics, _kind(settings.pixel_format)
        wanted = (view.image, optics, kind)
        held = self._held
        if held is None or not held.serves(*wanted):
            held = next((shared for shared in _Prepared._latest if shared.serves(*wanted)), None)
            if held is None:
                held = _Preparation(*wanted, _prepare(*wanted))
                _Prepared._latest = held, *_Prepared._latest[:1]
            self._held = held
        rows, columns = view.image.shape[:2]
        x = (
            _start(view.x, columns, SENSOR_WIDTH, optics.binning_horizontal, optics.reverse_x)
            + settings.offset_x
        )
        y = _start(view.y, rows, SENSOR_HEIGHT, optics.binning_vertical, optics.reverse_y) + settings.offset_y
        return held.image[y : y + settings.height, x : x + settings.width]


def _start(position: int, size: int, sensor: int, binning: int, reverse: bool) -> int:
    """Return the sensor's first pixel along one axis of the prepared image; even, for the mosaic."""
    if reverse:
        position = size - sensor - position
    return position // binning & ~1


def _prepare(image: NDArray[np.uint16], optics: Optics, kind: str) -> NDArray[np.uint16]:
    if optics.reverse_x:
        image = image[:, ::-1]
    if optics.reverse_y:
        image = image[::-1]
    horizontal, vertical = optics.binning_horizontal, optics.binning_vertical
    if horizontal > 1 or vertical > 1:
        rows, columns = image.shape[0] // vertical, image.shape[1] // horizontal
        image = np.ascontiguousarray(image[: rows * vertical, : columns * horizontal])
        image = np.asarray(cv2.resize(image, (columns, rows), interpolation=cv2.INTER_AREA), np.uint16)
    prepared: NDArray[Any] = image
    if image.ndim == 3 and kind == Family.MONO.value:
        prepared = cv2.transform(np.ascontiguousarray(image), LUMINANCE)
    elif image.ndim == 3:  # in a seventh of the time that `transform` takes
        ratios: Any = (*optics.ratios, 0.0)
        prepared = np.asarray(cv2.multiply(np.ascontiguousarray(image), ratios), np.uint16)
    if prepared.ndim == 3 and kind != Family.RGB.value:
        prepared = mosaic(prepared, kind)
    if optics.gamma == 1.0:
        return prepared
    curve = (np.arange(65536) / UNIT) ** optics.gamma * UNIT
    shaped: NDArray[np.uint16] = np.clip(curve + 0.5, 0, 65535).astype(np.uint16)[prepared]
    return shaped


@lru_cache(maxsize=1)
def _normal(seed: int) -> NDArray[np.float32]:
    return np.random.default_rng(seed).standard_normal(_NOISE_VALUES, np.float32)


@lru_cache(maxsize=2)
def _noise(seed: int, step: int, deep: bool) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return noise at `step` tenths of an amplification: to add, to take away. Cameras share it."""
    scaled = np.rint(_normal(seed) * (_READ_NOISE * step / 10 * (257 if deep else 1)))
    kind = np.uint16 if deep else np.uint8
    top = np.iinfo(kind).max
    return np.clip(scaled, 0, top).astype(kind), np.clip(-scaled, 0, top).astype(kind)


class _Noise:
    """Read noise from a store of random numbers, entered at a place that depends on the frame.

    Stored as an addend and a subtrahend, both unsigned, so that saturating 8-bit arithmetic can be used.
    """

    def __init__(self, seed: int) -> None:
        self._seed = seed
        self._key: tuple[int, bool] | None = None
        self._bright: NDArray[Any] = np.empty(0)
        self._dark: NDArray[Any] = np.empty(0)
        self._position = 0

    def at(self, amplification: float, deep: bool, frame_id: int) -> _Noise:
        """Prepare the noise of one frame."""
        # In steps of a tenth, so that auto gain does not scale a million numbers for every frame.
        step = round(amplification * 10)
        if (step, deep) != self._key:
            self._bright, self._dark = _noise(self._seed, step, deep)
            self._key = (step, deep)
        self._position = frame_id * 7919 * 64
        return self

    def next(self, shape: tuple[int, ...]) -> tuple[NDArray[Any], NDArray[Any]]:
        """Return the noise of the next strip: values to add and to subtract."""
        count = math.prod(shape)
        start = self._position % (_NOISE_VALUES - count)
        self._position += 982_451_653 % _NOISE_VALUES
        part = slice(start, start + count)
        return self._bright[part].reshape(shape), self._dark[part].reshape(shape)


def draw_pattern(
    pattern: TestPattern, width: int, height: int, frame_id: int, pixel_format: PixelFormat
) -> NDArray[Any]:
    """Return values of the format's depth, (height, width) for mono and Bayer, else (height, width, 3)."""
    colour, depth = pixel_format.family in COLOURED, sensor_depth(pixel_format)
    if pattern is TestPattern.COLOR_BAR:
        rgb = _bars(width, height)
        if colour:
            values = rgb
        elif pixel_format.family is Family.BAYER:
            values = mosaic(rgb, pixel_format.order)
        else:
            values = np.asarray(cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY), np.uint8)
    else:
        values = _grey(pattern, width, height, frame_id)
        if colour:
            values = np.repeat(values[:, :, None], 3, axis=2)
    if depth == 8:
        return values
    deep = values.astype(np.uint16) << (depth - 8)
    if pattern is TestPattern.WHITE:
        deep |= (1 << (depth - 8)) - 1
    return deep


def _grey(pattern: TestPattern, width: int, height: int, frame_id: int) -> NDArray[np.uint8]:
    if pattern is TestPattern.BLACK:
        return np.zeros((height, width), np.uint8)
    if pattern is TestPattern.WHITE:
        return np.full((height, width), 255, np.uint8)
    shift = frame_id if pattern in MOVING else 0
    if pattern in (TestPattern.GREY_HORIZONTAL_RAMP, TestPattern.GREY_HORIZONTAL_RAMP_MOVING):
        line = ((np.arange(width) + shift) & 0xFF).astype(np.uint8)
        return np.tile(line, (height, 1))
    column = ((np.arange(height) + shift) & 0xFF).astype(np.uint8)
    return np.repeat(column[:, None], width, axis=1)


def _bars(width: int, height: int) -> NDArray[np.uint8]:
    line = _BARS[np.arange(width) * len(_BARS) // width] * np.uint8(255)
    return np.tile(line, (height, 1, 1))


def mosaic(rgb: NDArray[Any], order: str) -> NDArray[Any]:
    """Return the mosaic (rows, columns) that a Bayer sensor sees of an image (rows, columns, 3)."""
    raw = np.empty(rgb.shape[:2], rgb.dtype)
    for row, channels in enumerate(_CHANNEL_AT[order]):
        for column, channel in enumerate(channels):
            raw[row::2, column::2] = rgb[row::2, column::2, channel]
    return raw


def stamp(values: NDArray[Any], frame_id: int, white: int) -> None:
    """Draw a frame's number into the lower left corner, white on black, a twelfth of the height high."""
    height, width = values.shape[:2]
    text = f"{frame_id:08d}"
    scale = max(min(height / 360, width / 180), 0.2)
    (text_width, text_height), baseline = cv2.getTextSize(text, cv2.FONT_HERSHEY_SIMPLEX, scale, 1)
    margin = max(int(4 * scale), 1)
    box = values[max(height - text_height - baseline - 2 * margin, 0) :, : text_width + 2 * margin]
    box[...] = 0
    thickness = max(round(scale * 1.5), 1)
    plain = np.zeros(box.shape[:2], np.uint8)
    place = (margin, box.shape[0] - baseline - margin)
    cv2.putText(plain, text, place, cv2.FONT_HERSHEY_SIMPLEX, scale, 255, thickness)
    box[plain > 127] = white
