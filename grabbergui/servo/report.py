"""The report of a run: report.json, plots.png and a video with the overlays.

OpenCV draws the curves, so no window and no plotting library is needed.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np

from grabbergui.core.calibration import Calibration
from grabbergui.core.environment import write_whole
from grabbergui.core.errors import GrabberError, UsageError
from grabbergui.core.frame import Frame
from grabbergui.core.json_text import to_json
from grabbergui.recording.kinds import RecordingKind
from grabbergui.servo import overlay
from grabbergui.servo.detection import Sighting
from grabbergui.servo.loop import ControlCycle
from grabbergui.servo.plot_image import Band, Curve, Plot, sheet
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
