"""The clock of a camera fitted to the host's, with a bound on the error. No I/O, no clock.

Two kinds of observations limit the line *host = device + offset + drift · device*:

- A *reading*: the host read the camera's clock between two moments of its own. The line passes between them.
- An *arrival*: a message that was stamped by the camera arrived. Its delay is never negative, so the line
  lies below all arrivals; and the fastest of many arrivals have nearly the least delay, so it does not lie
  far below. How far is taken from the spread of the fastest ones.

All lines that satisfy every limit form a polygon in offset and drift. The estimate at a time is the middle of
what they allow there, and its uncertainty half of that range: it grows by itself where nothing was observed,
and the drift is followed as old observations leave the window. Limits that no line satisfies mean that the
clock was set or has changed its pace: then the older half of them is dropped.

The uncertainty holds for readings whatever the network does. For arrivals it holds if the delays come close
to the least delay often enough, and if that is known (`least_delay_ns`); a constant delay cannot be seen.

Times are integers in nanoseconds.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

WINDOW_NS = 60_000_000_000
"How far back observations count."
MOST_DRIFT = 300e-6
"Largest part by which a camera's clock is fast or slow; crystals keep 100 ppm."
WANDER = 3e-7
"Part by which the pace of a clock may change within the window, as while a camera warms up."
MOST_ARRIVALS, MOST_READINGS = 2048, 256
FASTEST = 20
"""The spread of so many fastest arrivals bounds the delay of the fastest one.

For delays whose density does not vanish at the least delay, the fastest is that late with a probability of
about 2 to the power of -FASTEST.
"""
FEWEST = 2 * FASTEST
"Arrivals from which a bound is taken."
BLOCKS = 4
"Parts of the window, each of which gives a bound of its own, so that the drift is bounded too."


class HostTime(NamedTuple):
    """A moment on the host's clock."""

    time_ns: int
    uncertainty_ns: int
    "The true moment is within this of `time_ns`."


class Limits(NamedTuple):
    """Points that a line must not pass above, or below: times relative to the first, and offsets."""

    times: Floats
    offsets: Floats


@dataclass(frozen=True)
class ClockEstimate:
    """All lines that the observations allow."""

    origin_ns: int
    "Device time that the line's times are relative to."
    offset_ns: int
    "Host minus device, which the line's offsets are relative to."
    newest_ns: int
    "Device time of the last observation."
    slopes: Floats
    "Slopes of the polygon's corners and edges, in rising order; host seconds more per device second."
    highest: Floats
    "The largest offset at the origin for each slope."
    lowest: Floats
    "The smallest."

    @property
    def drift(self) -> float:
        """The middle of the allowed drifts; 1e-6 means that the host's clock gains 1 µs a second."""
        return float(self.slopes[0] + self.slopes[-1]) / 2

    @property
    def drift_uncertainty(self) -> float:
        """Half of the range of allowed drifts."""
        return float(self.slopes[-1] - self.slopes[0]) / 2

    def host_time(self, device_ns: int) -> HostTime:
        """Return the host's time at a time of the device."""
        time = float(device_ns - self.origin_ns)
        high = float(np.max(self.slopes * time + self.highest))
        low = float(np.min(self.slopes * time + self.lowest))
        beyond = WANDER * max(0, device_ns - self.newest_ns)
        return HostTime(
            device_ns + self.offset_ns + round((high + low) / 2), int(np.ceil((high - low) / 2 + beyond)) + 1
        )

    def device_time(self, host_ns: int) -> int:
        """Return the device's time at a time of the host."""
        device = host_ns - self.offset_ns
        for _ in range(3):
            device -= self.host_time(device).time_ns - host_ns
        return device


class ClockFit:
    """Collects observations of one camera's clock. One thread."""

    def __init__(self, *, least_delay_ns: tuple[int, int] = (0, 0), window_ns: int = WINDOW_NS) -> None:
        """`least_delay_ns`: the shortest and longest that the delay of the fastest arrivals may be."""
        self._least_delay_ns = least_delay_ns
        self._window_ns = window_ns
        self._arrivals: deque[tuple[int, int]] = deque(maxlen=MOST_ARRIVALS)
        self._readings: deque[tuple[int, int, int]] = deque(maxlen=MOST_READINGS)
        self._newest: int | None = None

    def forget(self) -> None:
        """Drop all observations, as when the camera's clock was reset."""
        self._arrivals.clear()
        self._readings.clear()
        self._newest = None

    def add_arrival(self, device_ns: int, arrival_ns: int) -> None:
        """Add a message that was stamped at `device_ns` and arrived at `arrival_ns`."""
        self._advance(device_ns)
        self._arrivals.append((device_ns, arrival_ns))

    def add_reading(self, device_ns: int, before_ns: int, after_ns: int) -> None:
        """Add that the device's clock showed `device_ns` at some moment between two of the host."""
        self._advance(device_ns)
        self._readings.append((device_ns, before_ns, after_ns))

    def estimate(self) -> ClockEstimate | None:
        """Return what the observations allow; None if they do not bound the clock."""
        while self._newest is not None and (self._arrivals or self._readings):
            if (limits := self._limits(self._newest)) is None:
                return None
            if (found := _allowed(*limits)) is not None:
                return ClockEstimate(*self._origin(), self._newest, *found)
            self._drop_older_half()
        return None

    def _advance(self, device_ns: int) -> None:
        if self._newest is not None and device_ns < self._newest - self._window_ns // 2:
            self.forget()  # the clock was set back
        self._newest = device_ns if self._newest is None else max(self._newest, device_ns)
        oldest = self._newest - self._window_ns
        while self._arrivals and self._arrivals[0][0] < oldest:
            self._arrivals.popleft()
        while self._readings and self._readings[0][0] < oldest:
            self._readings.popleft()

    def _drop_older_half(self) -> None:
        times = sorted([each[0] for each in self._arrivals] + [each[0] for each in self._readings])
        middle = times[len(times) // 2]
        kept = [each for each in self._arrivals if each[0] > middle]
        self._arrivals = deque(kept, MOST_ARRIVALS)
        self._readings = deque((each for each in self._readings if each[0] > middle), MOST_READINGS)

    def _origin(self) -> tuple[int, int]:
        device, host, *_ = self._readings[0] if self._readings else self._arrivals[0]
        return device, host - device

    def _limits(self, newest: int) -> tuple[Limits, Limits] | None:
        """Return the upper and the lower limits; None without either."""
        origin, offset = self._origin()
        shortest, longest = self._least_delay_ns
        arrivals = np.array(
            [(device - origin, host - device - offset) for device, host in self._arrivals], np.float64
        ).reshape(-1, 2)
        readings = np.array(
            [
                (device - origin, before - device - offset, after - device - offset)
                for device, before, after in self._readings
            ],
            np.float64,
        ).reshape(-1, 3)
        upper = Limits(
            np.concatenate([readings[:, 0], arrivals[:, 0]]),
            np.concatenate([readings[:, 2], arrivals[:, 1] - shortest]),
        )
        lower = Limits(readings[:, 0], readings[:, 1]) if len(readings) else _below(arrivals, longest)
        if not len(upper.times) or not len(lower.times):
            return None
        ages = WANDER * (newest - origin)
        loosened = Limits(upper.times, upper.offsets + ages - WANDER * upper.times)
        return loosened, Limits(lower.times, lower.offsets - ages + WANDER * lower.times)


def _below(arrivals: Floats, longest_delay: float) -> Limits:
    """Return limits from the fastest arrivals of each part of the window."""
    times: list[float] = []
    offsets: list[float] = []
    blocks = max(1, min(BLOCKS, len(arrivals) // FEWEST))
    for block in np.array_split(_in_order(arrivals), blocks):
        if len(block) < FEWEST or block[0, 0] == block[-1, 0]:
            continue
        # The edge of the hull below the block's middle: no line below all arrivals passes higher there.
        hull, middle = _lower_hull(block), block[:, 0].mean()
        at = min(max(1, int(np.searchsorted(hull[:, 0], middle))), len(hull) - 1)
        (x0, y0), (x1, y1) = hull[at - 1], hull[at]
        slope = (y1 - y0) / (x1 - x0)
        above = block[:, 1] - (y0 + slope * (block[:, 0] - x0))
        times.append(float(middle))
        offsets.append(
            float(y0 + slope * (middle - x0) - longest_delay - np.partition(above, FASTEST)[FASTEST])
        )
    return Limits(np.array(times), np.array(offsets))


def _in_order(points: Floats) -> Floats:
    return points[np.argsort(points[:, 0], kind="stable")]


def _lower_hull(points: Floats) -> Floats:
    """Return the corners of the convex hull below points in the order of their times."""
    hull: list[tuple[float, float]] = []
    for x, y in points.tolist():
        if hull and hull[-1][0] == x:
            if hull[-1][1] <= y:
                continue
            hull.pop()
        while len(hull) > 1:
            (x0, y0), (x1, y1) = hull[-2:]
            if (y1 - y0) * (x - x0) < (y - y0) * (x1 - x0):
                break
            hull.pop()
        hull.append((x, y))
    return np.array(hull)


def _allowed(upper: Limits, lower: Limits) -> tuple[Floats, Floats, Floats] | None:
    """Return slopes with the largest and smallest offset for each; None if no line satisfies all limits.

    For a slope, the offset may be at most the smallest of `offset - slope * time` over the upper limits, and
    at least the largest over the lower ones. Both are piecewise linear in the slope and bend only at the
    slopes of the hulls' edges, so those are looked at, and the ends of the allowed range between them.
    """
    above = _lower_hull(np.column_stack(upper)[np.argsort(upper.times, kind="stable")])
    below = _lower_hull(
        np.column_stack([lower.times, -lower.offsets])[np.argsort(lower.times, kind="stable")]
    )
    bends = [np.array([-MOST_DRIFT, MOST_DRIFT])]
    for hull, sign in ((above, 1), (below, -1)):
        if len(hull) > 1:
            bends.append(sign * np.diff(hull[:, 1]) / np.diff(hull[:, 0]))
    slopes = np.unique(np.clip(np.concatenate(bends), -MOST_DRIFT, MOST_DRIFT))

    def ends(at: Floats) -> tuple[Floats, Floats]:
        highest = (above[:, 1] - at[:, None] * above[:, 0]).min(axis=1)
        lowest = (-below[:, 1] - at[:, None] * below[:, 0]).max(axis=1)
        return highest, lowest

    highest, lowest = ends(slopes)
    room = highest - lowest
    inside = room >= 0
    crossings = np.flatnonzero(inside[1:] != inside[:-1])
    left, right = slopes[crossings], slopes[crossings + 1]
    part = room[crossings] / (room[crossings] - room[crossings + 1])
    allowed = np.unique(np.concatenate([slopes[inside], left + part * (right - left)]))
    if not len(allowed):
        return None
    highest, lowest = ends(allowed)
    return allowed, np.maximum(highest, lowest), np.minimum(highest, lowest)
