"""The report of a run: report.json, plots.png and a video with the overlays.

OpenCV draws the curves, so no window and no plotting library is needed.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.core.calibration import Calibration
from grabbergui.core.environment import write_whole
from grabbergui.core.errors import GrabberError, UsageError
from grabbergui.core.frame import Frame
from grabbergui.core.json_text import to_json
from grabbergui.recording.kinds import RecordingKind
from grabbergui.servo import overlay
from grabbergui.servo.detection import Sighting
from grabbergui.servo.loop import ControlCycle
from grabbergui.servo.state_machine import State

if TYPE_CHECKING:
    from grabbergui.recording.movie_writer import MovieFile

log = logging.getLogger(__name__)

VIDEO_FPS = 15.0
VIDEO_NAME = "video.mp4"
_LONGEST = 100_000
"Number of control cycles that are kept: more than half an hour's."


class RunRecorder:
    """Records a run. Use `add` on the loop's thread, `finish` afterwards."""

    def __init__(self, folder: Path, calibration: Callable[[int, int], Calibration]) -> None:
        """Create the folder. Raises UsageError if that fails."""
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise UsageError(f"the report cannot go to {folder}: {error.strerror or error}") from error
        self.cycles: list[ControlCycle] = []
        self._folder = folder
        self._calibration = calibration
        self._video: MovieFile | None = None
        self._video_start = 0.0
        self._next_image = -math.inf
        self._images = 0

    def add(self, cycle: ControlCycle, frame: Frame | None, sighting: Sighting | None) -> None:
        """Record a cycle, and its image at the video's rate."""
        if len(self.cycles) < _LONGEST:
            self.cycles.append(cycle)
        if frame is not None and cycle.time >= self._next_image:
            self._next_image = max(self._next_image + 1 / VIDEO_FPS, cycle.time - 1 / VIDEO_FPS)
            try:
                calibration = self._calibration(frame.width, frame.height)
                self._write(overlay.draw(frame.rgb(), cycle, sighting, calibration), cycle.time)
            except (GrabberError, OSError) as error:
                # A full disk, for instance, must not end the run.
                log.warning("the report's video ends here: %s", error)
                self._next_image = math.inf

    def finish(self, facts: dict[str, Any]) -> dict[str, Any]:
        """Write the report with `facts` in it, and return it. Raises OSError if report.json fails."""
        self._finish_video()
        report = summary(self.cycles) | facts
        report["video"] = f"{self._images} images at {VIDEO_FPS:g} per second"
        write_whole(self._folder / "report.json", to_json(_plain(report), indent=2) + "\n")
        if len(self.cycles) > 1:
            plots = cv2.cvtColor(plot(self.cycles), cv2.COLOR_RGB2BGR)
            try:
                # OpenCV's own writer would not say why it fails.
                write_whole(self._folder / "plots.png", cv2.imencode(".png", plots)[1].tobytes())
            except OSError as error:
                log.warning("the report has no plots: %s", error)
        return report

    def _finish_video(self) -> None:
        video, self._video = self._video, None
        if video is None:
            return
        try:
            video.finish()
        except (GrabberError, OSError) as error:
            log.warning("the report's video is not complete: %s", error)
        finally:
            video.abandon()

    def _write(self, image: np.ndarray, time: float) -> None:
        if self._video is None:
            # On demand, as it loads FFmpeg's libraries.
            from grabbergui.recording.movie_writer import MovieFile

            path = self._folder / VIDEO_NAME
            path.unlink(missing_ok=True)  # of an earlier run
            self._video = MovieFile(path, RecordingKind.H264, image.shape, image.dtype, VIDEO_FPS)
            self._video_start = time
        self._video.add(image, round(1e6 * (time - self._video_start)))
        self._images += 1


def summary(cycles: list[ControlCycle]) -> dict[str, Any]:
    """States, times and errors of a run."""
    if not cycles:
        return {"reached": False, "seconds": 0.0, "states": []}
    start = cycles[0].time
    states = [
        {"time": round(cycle.time - start, 3), "state": cycle.state.value, "reason": cycle.reason}
        for cycle in _changes(cycles)
    ]
    first: dict[State, float] = {}
    for cycle in cycles:
        first.setdefault(cycle.state, cycle.time - start)
    last = next((cycle for cycle in reversed(cycles) if math.isfinite(cycle.error[0])), None)
    return {
        "reached": State.REACHED in first,
        "seconds": cycles[-1].time - start,
        "control_cycles": len(cycles),
        "states": states,
        "seconds_to_approach": first.get(State.APPROACHING),
        "seconds_to_reach": first.get(State.REACHED),
        "measured_error_mm": 1e3 * last.error[0] if last else None,
        "measured_error_degrees": math.degrees(last.error[1]) if last else None,
    }


def plot(cycles: list[ControlCycle]) -> np.ndarray:
    """Plot error, offset, twist and head speed over time, on the states' colours."""
    start = cycles[0].time
    plots = [
        Plot(title, unit, tuple(Curve(name, [float(read(one)) for one in cycles]) for name, read in curves))
        for title, unit, curves in _PLOTS
    ]
    bands = [
        Band(one.time - start, one.state.value, overlay.colour_of(one.state)) for one in _changes(cycles)
    ]
    return sheet(plots, [cycle.time - start for cycle in cycles], bands)


def _changes(cycles: list[ControlCycle]) -> list[ControlCycle]:
    """Return the first cycle, and each one whose state differs from the previous one's."""
    return [
        cycle
        for before, cycle in zip([None, *cycles], cycles, strict=False)
        if before is None or cycle.state is not before.state
    ]


def _hand_velocity(axis: int, cycle: ControlCycle) -> float:
    return 1e3 * float(cycle.command.hand[axis])


def _head_velocity(axis: int, cycle: ControlCycle) -> float:
    return math.degrees(cycle.command.head[axis])


_Curves = tuple[tuple[str, Callable[[ControlCycle], float]], ...]

_PLOTS: tuple[tuple[str, str, _Curves], ...] = (
    (
        "hand to goal",
        "mm, degrees",
        (
            ("distance", lambda cycle: 1e3 * cycle.error[0]),
            ("angle", lambda cycle: math.degrees(cycle.error[1])),
        ),
    ),
    (
        "target off centre",
        "degrees",
        (
            ("right", lambda cycle: math.degrees(cycle.off_centre[0])),
            ("down", lambda cycle: math.degrees(cycle.off_centre[1])),
        ),
    ),
    (
        "hand velocity",
        "mm/s",
        tuple((name, partial(_hand_velocity, axis)) for axis, name in enumerate("xyz")),
    ),
    (
        "head velocity",
        "degrees/s",
        tuple((name, partial(_head_velocity, axis)) for axis, name in enumerate(("pan", "tilt"))),
    ),
)
"""Title, unit, and each curve's name and value in a cycle."""


def _plain(value: Any) -> Any:
    """Return a value without NaN, which JSON does not have, and with rounded numbers."""
    if isinstance(value, dict):
        return {key: _plain(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(inner) for inner in value]
    if isinstance(value, float):
        return round(value, 4) if math.isfinite(value) else None
    return value


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
