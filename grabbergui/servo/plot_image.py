"""Curves drawn into an image by OpenCV, for a report without a display."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.uint8]
Colour = tuple[int, int, int]
WIDTH, HEIGHT = 960, 220
"Size of one plot, pixels."
_LEFT, _RIGHT, _TOP, _BOTTOM = 70, 16, 26, 28
LEGEND = 30
"Height of the bands' legend, pixels."
_FONT, _SIZE = cv2.FONT_HERSHEY_SIMPLEX, 0.42
PALETTE: tuple[Colour, ...] = ((200, 60, 50), (40, 140, 60), (50, 90, 210), (160, 110, 20))
"Red, green, blue of the curves in turn."


@dataclass(frozen=True)
class Curve:
    """One line of a plot, with gaps at values that are not finite."""

    name: str
    values: Sequence[float]


@dataclass(frozen=True)
class Plot:
    """Curves over the same moments."""

    title: str
    unit: str
    curves: tuple[Curve, ...]


@dataclass(frozen=True)
class Band:
    """A state that begins at a moment, shown by the background."""

    time: float
    name: str
    colour: Colour


def sheet(plots: Sequence[Plot], times: Sequence[float], bands: Sequence[Band]) -> Image:
    """Draw plots one below the other, RGB, and below them the legend of the bands."""
    drawn = [_draw(plot, np.asarray(times, np.float64), bands) for plot in plots]
    return np.vstack([*drawn, _legend(bands)])


def ticks(low: float, high: float, count: int = 5) -> list[float]:
    """Return about `count` round numbers within a range."""
    if not high > low:
        return [low]
    step = 10.0 ** math.floor(math.log10((high - low) / count))
    step *= next(factor for factor in (1, 2, 5, 10) if (high - low) / (step * factor) <= count)
    first = math.ceil(low / step)
    return [index * step for index in range(first, math.floor(high / step + 1e-9) + 1)]


def _legend(bands: Sequence[Band]) -> Image:
    out = np.full((LEGEND, WIDTH, 3), 255, np.uint8)
    place = _LEFT
    for name, colour in {band.name: band.colour for band in bands}.items():
        out[8:20, place : place + 18] = _pale(colour)
        _text(out, name, (place + 24, 18), (60, 60, 60))
        (width, _), _ = cv2.getTextSize(name, _FONT, _SIZE, 1)
        place += 24 + width + 20
    return out


def _pale(colour: Colour) -> NDArray[np.int64]:
    return 255 - (255 - np.array(colour)) // 6


def _draw(plot: Plot, times: NDArray[np.float64], bands: Sequence[Band]) -> Image:
    out = np.full((HEIGHT, WIDTH, 3), 255, np.uint8)
    start, end = (float(times[0]), float(times[-1])) if times.size > 1 else (0.0, 1.0)
    values = np.array([curve.values for curve in plot.curves], np.float64)
    finite = values[np.isfinite(values)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
    low, high = min(low, 0.0), max(high, 0.0)
    margin = 0.05 * (high - low) or 1.0
    low, high = low - margin, high + margin

    def x(time: float) -> int:
        return round(_LEFT + (time - start) / max(end - start, 1e-9) * (WIDTH - _LEFT - _RIGHT))

    def y(value: float) -> int:
        return round(HEIGHT - _BOTTOM - (value - low) / (high - low) * (HEIGHT - _TOP - _BOTTOM))

    for index, band in enumerate(bands):
        until = bands[index + 1].time if index + 1 < len(bands) else end
        left, right = x(max(band.time, start)), x(min(until, end))
        out[_TOP : HEIGHT - _BOTTOM, left:right] = _pale(band.colour)
    for value in ticks(low, high):
        cv2.line(out, (_LEFT, y(value)), (WIDTH - _RIGHT, y(value)), (215, 215, 215), 1)
        _text(out, f"{value:g}", (8, y(value) + 4))
    for time in ticks(start, end, 10):
        cv2.line(out, (x(time), HEIGHT - _BOTTOM), (x(time), HEIGHT - _BOTTOM + 4), (90, 90, 90), 1)
        _text(out, f"{time:g} s", (x(time) - 10, HEIGHT - 8))
    place = _LEFT
    _text(out, f"{plot.title} ({plot.unit})", (place, 17), (20, 20, 20))
    place += 260
    for curve, colour in zip(plot.curves, PALETTE, strict=False):
        _line(
            out,
            [(x(t), y(v)) if math.isfinite(v) else None for t, v in zip(times, curve.values, strict=True)],
            colour,
        )
        cv2.line(out, (place, 13), (place + 18, 13), colour, 2)
        _text(out, curve.name, (place + 24, 17), (60, 60, 60))
        place += 120
    return out


def _line(out: Image, points: Sequence[tuple[int, int] | None], colour: Colour) -> None:
    run: list[tuple[int, int]] = []
    for point in (*points, None):
        if point is not None:
            run.append(point)
        elif run:
            cv2.polylines(out, [np.array(run, np.int32)], False, colour, 1, cv2.LINE_AA)
            run = []


def _text(out: Image, text: str, place: tuple[int, int], colour: Colour = (110, 110, 110)) -> None:
    cv2.putText(out, text, place, _FONT, _SIZE, colour, 1, cv2.LINE_AA)
