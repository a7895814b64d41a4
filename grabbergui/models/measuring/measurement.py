"""Measures frames in full, on a thread of its own and only while a result is wanted."""

from __future__ import annotations

import logging
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import cv2
from numpy.typing import NDArray
from psygnal import Signal

from grabbergui.core.errors import PixelFormatError
from grabbergui.core.frame import Frame
from grabbergui.core.pfnc import Family
from grabbergui.core.pixels import Region, for_display
from grabbergui.models.measuring.channels import Histogram, Line, measure_histogram, measure_profile

HISTORY_SECONDS = 60.0
HISTORY_MOST = 1200
"Scores kept at most."


def sharpness(frame: Frame, region: Region | None = None) -> float:
    """Return a score that is highest where the lens is in focus; for comparing pictures of one scene.

    The variance of the Laplacian, over the square of the mean, in percent: a brighter picture of the same
    scene has about the same score. Raises PixelFormatError.
    """
    region = (region or Region(0, 0, frame.width, frame.height)).clipped(frame.width, frame.height)
    # A mosaic's own pattern would pass for sharpness, so Bayer is taken in colour first.
    pixels = for_display(frame, region).pixels
    grey = cv2.cvtColor(pixels, cv2.COLOR_RGB2GRAY) if pixels.ndim == 3 else pixels
    if frame.pixel_format.family is Family.BAYER:
        grey = cv2.GaussianBlur(grey, (3, 3), 0)
    _, deviation = cv2.meanStdDev(cv2.Laplacian(grey, cv2.CV_16S))
    mean = float(grey.mean())
    return 100.0 * float(deviation[0][0]) ** 2 / mean**2 if mean >= 1 else 0.0


class FocusHistory:
    """Scores over the last minute, and the best one. Times are seconds of any one clock."""

    def __init__(self) -> None:
        self._scores: deque[tuple[float, float]] = deque(maxlen=HISTORY_MOST)
        self.best = 0.0
        "Highest score since `clear`."

    @property
    def scores(self) -> list[tuple[float, float]]:
        """Time and score, the oldest first."""
        return list(self._scores)

    def add(self, score: float, now: float | None = None) -> None:
        """Note a score."""
        now = time.monotonic() if now is None else now
        self._scores.append((now, score))
        while self._scores[0][0] < now - HISTORY_SECONDS:
            self._scores.popleft()
        self.best = max(self.best, score)

    def clear(self) -> None:
        """Forget all scores."""
        self._scores.clear()
        self.best = 0.0


log = logging.getLogger(__name__)

PERIOD = 0.1
"Seconds between two measurements: as fast as a figure can be read."


@dataclass(frozen=True)
class Wanted:
    """The requested measurements."""

    histogram: bool = False
    focus: bool = False
    focus_region: Region | None = None
    "In the frame's pixels; None for all of it."
    line: Line | None = None
    raw_line: bool = False
    "Whether the sensor's own values along the line are wanted, and not the colours shown."

    @property
    def anything(self) -> bool:
        """Whether there is anything to do."""
        return self.histogram or self.focus or self.line is not None


@dataclass(frozen=True, eq=False)
class Measurement:
    """The measurements of one frame; None for those not requested."""

    frame: Frame
    histogram: Histogram | None = None
    sharpness: float | None = None
    profile: dict[str, NDArray[Any]] | None = None


class MeasuringModel:
    """Measures what `newest` gives, each frame once. No call waits; the signal comes from the thread."""

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
        """Measure this from now on; with nothing wanted, the thread ends."""
        with self._lock:
            if wanted == self._wanted:
                return
            self._wanted = wanted
            self._changed.set()
            if wanted.anything and self._thread is None:
                self._thread = threading.Thread(target=self._measure_on, name="measuring", daemon=True)
                self._thread.start()

    def close(self, timeout: float = 1.0) -> bool:
        """Measure nothing more. Whether the thread ended within `timeout` seconds."""
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
            # A damaged frame must not end the measuring of those that follow.
            log.exception("frame %d could not be measured", frame.frame_id)
        else:
            self.measured.emit(measurement)
