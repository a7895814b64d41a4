"""Measures the frames looked at, in full, on a thread of its own and only while somebody wants it."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray
from psygnal import Signal

from grabbergui.core.errors import PixelFormatError
from grabbergui.core.frame import Frame
from grabbergui.core.region import Region
from grabbergui.models.measuring import histogram, line_profile
from grabbergui.models.measuring.histogram import Histogram
from grabbergui.models.measuring.line_profile import Line
from grabbergui.models.measuring.sharpness import sharpness

log = logging.getLogger(__name__)

PERIOD = 0.1
"Seconds between two measurements: as fast as a figure can be read."


@dataclass(frozen=True)
class Wanted:
    """What is to be measured."""

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
    """What was measured of one frame; None where nobody asked."""

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
        """What is measured."""
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
                histogram.measure(frame) if wanted.histogram else None,
                sharpness(frame, wanted.focus_region) if wanted.focus else None,
                line_profile.measure(frame, line, raw=raw) if line is not None else None,
            )
        except PixelFormatError as error:
            log.debug("frame %d is not measured: %s", frame.frame_id, error)
        except Exception:
            # A damaged frame must not end the measuring of those that follow.
            log.exception("frame %d could not be measured", frame.frame_id)
        else:
            self.measured.emit(measurement)
