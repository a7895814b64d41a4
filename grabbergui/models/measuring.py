"""Measurements of frames: histogram, profile, sharpness."""

from __future__ import annotations

import logging
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from psygnal import Signal

from grabbergui.core import unpacking
from grabbergui.core.colour import BAYER_SECOND_LINE
from grabbergui.core.errors import PixelFormatError
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import Family, PixelFormat, by_name
from grabbergui.core.pixels import Region, for_display

log = logging.getLogger(__name__)

LEFT_OUT = 0.005
"Fraction of the samples at either end that lie outside of levels fitted to an image."
HISTORY_SECONDS = 60.0
HISTORY_MOST = 1200
"Most scores kept."
PERIOD = 0.1
"Seconds between two measurements: faster figures cannot be read."
SAMPLED_PAIRS = 24
"Pairs of lines from which the share of saturated samples is estimated."


@dataclass(frozen=True, eq=False)
class Histogram:
    """Counts of the sensor's values in a whole frame, by channel."""

    channels: dict[str, NDArray[np.int64]]
    "`grey`, `Y`, or `R`, `G`, `B`: a count for each value 0 … 2^depth - 1."
    depth: int
    "Significant bits of a value."

    @property
    def black(self) -> float:
        """Fraction of the samples that are 0."""
        return self._fraction(0)

    @property
    def saturated(self) -> float:
        """Fraction of the samples at the highest value."""
        return self._fraction(-1)

    def mean(self, channel: str) -> float:
        """Return the mean value of a channel; 0 without samples."""
        counts = self.channels[channel]
        return float(counts @ np.arange(counts.size)) / max(1, int(counts.sum()))

    def binned(self, channel: str, most: int = 256) -> NDArray[np.int64]:
        """Return a channel's counts in bins of equal width (a power of two), at most the given number."""
        counts = self.channels[channel]
        sums: NDArray[np.int64] = counts.reshape(min(most, counts.size), -1).sum(axis=1)
        return sums

    def levels(self) -> tuple[float, float]:
        """Return black and white as fractions of the range; `LEFT_OUT` of the samples lies beyond each.

        They are the same for all channels, so that levels add no colour cast.
        """
        counts = sum(self.channels.values(), np.zeros(1 << self.depth, np.int64))
        sums = np.cumsum(counts)
        black = int(np.searchsorted(sums, LEFT_OUT * sums[-1], side="right"))
        white = int(np.searchsorted(sums, (1 - LEFT_OUT) * sums[-1], side="left"))
        top = (1 << self.depth) - 1
        return black / top, max(black + 1, white) / top

    def _fraction(self, index: int) -> float:
        total = sum(int(counts.sum()) for counts in self.channels.values())
        return sum(int(counts[index]) for counts in self.channels.values()) / max(1, total)


def measure_histogram(frame: Frame) -> Histogram:
    """Return the histogram of every pixel of a frame. Raises PixelFormatError."""
    raw, pixel_format = measurable(frame)
    depth = pixel_format.depth
    channels: dict[str, NDArray[np.int64]] = {}
    for name, values in planes(raw, pixel_format):
        counts = _counts(values, 1 << depth)
        channels[name] = channels[name] + counts if name in channels else counts
    return Histogram(dict(sorted(channels.items(), key=lambda item: "RGB".find(item[0]))), depth)


def measurable(frame: Frame, region: Region | None = None) -> tuple[NDArray[Any], PixelFormat]:
    """Return the values to measure in a region (None: the whole frame), and their pixel format.

    They are the sensor's own values if its channels share a depth and a white level; otherwise what the
    display shows, as Mono8 or RGB8. Raises PixelFormatError.
    """
    region = Region.of(frame, region)
    pixel_format = frame.pixel_format
    if _share_white(pixel_format):
        return unpacking.lines(frame, region.y, region.bottom)[:, region.x : region.right], pixel_format
    grey = pixel_format.family in (Family.MONO, Family.COORDINATES)
    shown = frame.mono() if grey else frame.rgb()
    return shown[region.y : region.bottom, region.x : region.right], by_name("Mono8" if grey else "RGB8")


def _share_white(pixel_format: PixelFormat) -> bool:
    """Return whether the channels share a depth and a white level."""
    shared = pixel_format.kind == "u" and not pixel_format.needs_range and not pixel_format.fields
    return shared and pixel_format.family not in (Family.SPARSE, Family.BICOLOR, Family.OTHER)


def estimate_saturated(frame: Frame) -> float | None:
    """Return the fraction of the samples at the highest value, estimated from a few of the frame's lines.

    Takes a fraction of a millisecond for any size. None for a format whose channels have no common white
    level. Raises PixelFormatError.
    """
    if not _share_white(frame.pixel_format):
        return None
    step = max(2, frame.height // SAMPLED_PAIRS & ~1)
    saturated = samples = 0
    for y in range(0, frame.height, step):
        raw, pixel_format = measurable(frame, Region(0, y, frame.width, min(2, frame.height - y)))
        for _, values in planes(raw, pixel_format):
            saturated += int(np.count_nonzero(values == (1 << pixel_format.depth) - 1))
            samples += values.size
    return saturated / max(1, samples)


def planes(raw: NDArray[Any], pixel_format: PixelFormat) -> Iterator[tuple[str, NDArray[Any]]]:
    """Yield each channel's samples (`grey`, `Y`, or `R`, `G`, `B`, green of Bayer twice), without a copy.

    `raw` is as `Frame.raw` gives it, or a part of it that begins on an even line and column.
    """
    order, family = pixel_format.order, pixel_format.family
    if family is Family.RGB:
        for index, name in enumerate(order):
            if name in "RGB":
                yield name, raw[:, :, index]
    elif family is Family.YUV:
        yield "Y", raw[:, :, pixel_format.raw_order.index("Y")]
    elif family is Family.BAYER:
        # The colours of even lines, then those of odd lines.
        for line, colours in enumerate((order, BAYER_SECOND_LINE[order])):
            for column, name in enumerate(colours):
                yield name, raw[line::2, column::2]
    else:
        yield "grey", raw


def _counts(values: NDArray[Any], size: int) -> NDArray[np.int64]:
    if not values.size:
        return np.zeros(size, np.int64)
    counts = cv2.calcHist([np.ascontiguousarray(values)], [0], None, [size], [0, size])
    return counts.reshape(-1).astype(np.int64)


@dataclass(frozen=True)
class Line:
    """A line from one pixel of the frame to another, both included."""

    x0: int
    y0: int
    x1: int
    y1: int

    @property
    def samples(self) -> int:
        """Number of pixels along the line: steps of its longer side."""
        return max(abs(self.x1 - self.x0), abs(self.y1 - self.y0)) + 1

    def clipped(self, width: int, height: int) -> Line:
        """Return the line with both ends moved into a frame of that size."""
        x0, x1 = (min(max(x, 0), width - 1) for x in (self.x0, self.x1))
        y0, y1 = (min(max(y, 0), height - 1) for y in (self.y0, self.y1))
        return Line(x0, y0, x1, y1)


def measure_profile(frame: Frame, line: Line, *, raw: bool = False) -> dict[str, NDArray[Any]]:
    """Return the values along a line by channel: the sensor's own for mono, 8-bit `R`, `G`, `B` otherwise.

    With `raw`, return the sensor's own values for any format: components unchanged; of a Bayer pattern each
    pixel's value under the colour of its filter, and NaN under the others. Takes the nearest pixels without
    interpolation. Raises PixelFormatError.
    """
    line = line.clipped(frame.width, frame.height)
    x = np.rint(np.linspace(line.x0, line.x1, line.samples)).astype(int)
    y = np.rint(np.linspace(line.y0, line.y1, line.samples)).astype(int)
    if frame.pixel_format.family in (Family.MONO, Family.COORDINATES):
        values = frame.raw()[y, x]
        # The last of several coordinates is the distance.
        return {"grey": values if values.ndim == 1 else values[:, -1]}
    if raw:
        return _raw(frame, x, y)
    box = Region(int(x.min()), int(y.min()), int(np.ptp(x)) + 1, int(np.ptp(y)) + 1)
    image = for_display(frame, box)
    pixels = image.pixels[y - image.region.y, x - image.region.x]
    return {name: pixels[:, index] for index, name in enumerate("RGB")}


def _raw(frame: Frame, x: NDArray[Any], y: NDArray[Any]) -> dict[str, NDArray[Any]]:
    values, order = frame.raw()[y, x], frame.pixel_format.raw_order
    if frame.pixel_format.family is Family.RGB:
        return {name: values[:, order.index(name)] for name in "RGB"}
    if frame.pixel_format.family is Family.YUV and len(order) == 3:
        return {name: values[:, order.index(name)] for name in "YUV"}
    if frame.pixel_format.family is Family.YUV:
        # Two neighbours share their chroma: U beside the left one, V beside the right one.
        luma = order.index("Y")
        return {"Y": values[:, luma], **_parted(values[:, 1 - luma], x % 2, ("U", "V"))}
    if frame.pixel_format.family is Family.BICOLOR:
        shared = _parted(values[:, 0], x % 2, (order[0], order[2]))
        return {"R": shared["R"], "G": values[:, 1], "B": shared["B"]}
    if frame.pixel_format.family is Family.SPARSE:
        return {"grey": values}
    second = BAYER_SECOND_LINE[order]
    return _parted(values, 2 * (y % 2) + x % 2, (*order, *second))


def _parted(values: NDArray[Any], place: NDArray[Any], names: Sequence[str]) -> dict[str, NDArray[Any]]:
    """Return the values by name; `place` is the index of each value's name in `names`."""
    kinds = np.array(names)[place]
    return {name: np.where(kinds == name, values, np.nan) for name in sorted(set(names), key="RGBUV".find)}


def sharpness(frame: Frame, region: Region | None = None) -> float:
    """Return a score that is highest when the lens is in focus, to compare images of one scene.

    It is the variance of the Laplacian over the square of the mean, in percent, so that brightness hardly
    matters. Raises PixelFormatError.
    """
    region = Region.of(frame, region)
    # A Bayer pattern itself would look like sharpness, so convert it to colour first.
    pixels = for_display(frame, region).pixels
    grey = cv2.cvtColor(pixels, cv2.COLOR_RGB2GRAY) if pixels.ndim == 3 else pixels
    if frame.pixel_format.family is Family.BAYER:
        grey = cv2.GaussianBlur(grey, (3, 3), 0)
    _, deviation = cv2.meanStdDev(cv2.Laplacian(grey, cv2.CV_16S))
    mean = float(grey.mean())
    return 100.0 * float(deviation[0][0]) ** 2 / mean**2 if mean >= 1 else 0.0


class FocusHistory:
    """Scores of the last minute, and the best one. Times are seconds of any one clock."""

    def __init__(self) -> None:
        self._scores: deque[tuple[float, float]] = deque(maxlen=HISTORY_MOST)
        self.best = 0.0
        "Highest score since `clear`."

    @property
    def scores(self) -> list[tuple[float, float]]:
        """Time and score, the oldest first."""
        return list(self._scores)

    def add(self, score: float, now: float | None = None) -> None:
        """Add a score."""
        now = time.monotonic() if now is None else now
        self._scores.append((now, score))
        while self._scores[0][0] < now - HISTORY_SECONDS:
            self._scores.popleft()
        self.best = max(self.best, score)

    def clear(self) -> None:
        """Forget all scores."""
        self._scores.clear()
        self.best = 0.0


@dataclass(frozen=True)
class Wanted:
    """The requested measurements."""

    histogram: bool = False
    focus: bool = False
    focus_region: Region | None = None
    "In the frame's pixels; None for the whole frame."
    line: Line | None = None
    raw_line: bool = False
    "Whether the line shows the sensor's own values instead of the displayed colours."

    @property
    def anything(self) -> bool:
        """Whether anything is requested."""
        return self.histogram or self.focus or self.line is not None


@dataclass(frozen=True, eq=False)
class Measurement:
    """The measurements of one frame; None for those not requested."""

    frame: Frame
    histogram: Histogram | None = None
    sharpness: float | None = None
    profile: dict[str, NDArray[Any]] | None = None


class MeasuringModel:
    """Measures each frame that `newest` returns, on a thread of its own while anything is wanted.

    No call but `close` waits; the thread emits the signal.
    """

    measured = Signal(Measurement)

    def __init__(self, newest: Callable[[], Frame | None], period: float = PERIOD) -> None:
        self._newest = newest
        self._period = period
        self._wanted = Wanted()
        self._changed = threading.Event()
        self._lock = threading.Lock()
        self._thread: threading.Thread | None = None

    @property
    def wanted(self) -> Wanted:
        """The current request."""
        return self._wanted

    def want(self, wanted: Wanted) -> None:
        """Set the request; with nothing wanted, the thread ends."""
        with self._lock:
            if wanted == self._wanted:
                return
            self._wanted = wanted
            self._changed.set()
            if wanted.anything and self._thread is None:
                self._thread = threading.Thread(target=self._measure_on, name="measuring", daemon=True)
                self._thread.start()

    def close(self, timeout: float = 1.0) -> bool:
        """Stop measuring; return whether the thread ended within `timeout` seconds."""
        thread = self._thread
        self.want(Wanted())
        if thread is None or thread is threading.current_thread():
            return True
        thread.join(timeout)
        return not thread.is_alive()

    def _measure_on(self) -> None:
        last: Frame | None = None
        while True:
            with self._lock:
                wanted = self._wanted
                if not wanted.anything:
                    self._thread = None
                    return
                again = self._changed.is_set()
                self._changed.clear()
            frame = self._newest()
            if frame is not None and (again or frame is not last):
                last = frame
                self._measure(frame, wanted)
            self._changed.wait(self._period)

    def _measure(self, frame: Frame, wanted: Wanted) -> None:
        try:
            line, raw = wanted.line, wanted.raw_line
            measurement = Measurement(
                frame,
                measure_histogram(frame) if wanted.histogram else None,
                sharpness(frame, wanted.focus_region) if wanted.focus else None,
                measure_profile(frame, line, raw=raw) if line is not None else None,
            )
        except PixelFormatError as error:
            log.debug("frame %d is not measured: %s", frame.frame_id, error)
        except Exception:
            # A damaged frame must not end the measurement of later ones.
            log.exception("frame %d could not be measured", frame.frame_id)
        else:
            self.measured.emit(measurement)
