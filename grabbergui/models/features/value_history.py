"""Values of features, sampled over time."""

from __future__ import annotations

import csv
import io
import math
import threading
import time
from collections.abc import Mapping
from datetime import datetime, timezone

import numpy as np
from numpy.typing import NDArray
from psygnal import Signal

from grabbergui.core.errors import FeatureError, GrabberError
from grabbergui.core.features import Feature, FeatureKind
from grabbergui.core.grabber import FrameGrabber
from grabbergui.models.features.worker import FeatureWorker

MOST_SAMPLES = 36_000
"Most samples of one value: an hour at ten a second. The oldest are dropped."
WATCH_PERIOD = 0.1
"Seconds between two reads of everything."
RETRY_PERIOD = 1.0
"Seconds between two reads of a camera that does not answer."
MOST_WATCHED = 12
"Most features watched at once: more curves cannot be distinguished, and each costs the camera a read."
PLOTTABLE = (FeatureKind.INTEGER, FeatureKind.FLOAT, FeatureKind.BOOLEAN)
"Kinds of features whose values can be plotted."


class ValueHistory:
    """Samples of one value, the oldest first. One thread at a time."""

    def __init__(self, most: int = MOST_SAMPLES) -> None:
        self._most = most
        # Twice the length, so that samples need moving to the front only now and then.
        self._samples: NDArray[np.float64] = np.empty((2, min(2 * most, 256)))
        self._begin = self._end = 0

    def __len__(self) -> int:
        return self._end - self._begin

    def add(self, moment: float, value: float) -> None:
        """Add a sample: seconds since the epoch, and the value or NaN."""
        if self._end == self._samples.shape[1]:
            self._make_room()
        self._samples[:, self._end] = moment, value
        self._end += 1
        self._begin = max(self._begin, self._end - self._most)

    def since(self, moment: float = -np.inf) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return times and values (n,) since a moment, as views that are valid until the next `add`."""
        times, values = self._samples[:, self._begin : self._end]
        first = int(np.searchsorted(times, moment))
        return times[first:], values[first:]

    def _make_room(self) -> None:
        kept = self._samples[:, self._begin : self._end]
        length = min(2 * self._most, max(256, 2 * kept.shape[1]))
        larger = np.empty((2, length))
        larger[:, : kept.shape[1]] = kept
        self._samples, self._begin, self._end = larger, 0, kept.shape[1]


def to_csv(histories: Mapping[str, ValueHistory]) -> str:
    """Return a line for each time and a column for each value; empty where a value was not read."""
    rows: dict[float, dict[str, float]] = {}
    for name, history in histories.items():
        for moment, value in zip(*history.since(), strict=True):
            if np.isfinite(value):
                rows.setdefault(float(moment), {})[name] = float(value)
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["time", *histories])
    for moment in sorted(rows):
        when = datetime.fromtimestamp(moment, timezone.utc).isoformat(timespec="milliseconds")
        writer.writerow([when, *(rows[moment].get(name, "") for name in histories)])
    return text.getvalue()


class ValueWatch:
    """Samples some features on a source's own worker, at most ten times a second, only while wanted.

    All methods may be called from any thread and none waits; the signal comes from the worker.
    """

    sampled = Signal(float, dict, dict)
    """Time of the read (seconds since the epoch), values (dict[str, float], NaN for none), their units."""

    def __init__(self, period: float = WATCH_PERIOD) -> None:
        self._period = period
        self._names: tuple[str, ...] = ()
        self._source: tuple[FrameGrabber, FeatureWorker] | None = None
        self._wanted = False
        self._reading = 0
        "Increases whenever the current series of reads ends; a job with an older number does nothing."
        self._lock = threading.Lock()

    @property
    def names(self) -> tuple[str, ...]:
        """The features that are read, in the order of their request."""
        return self._names

    @property
    def full(self) -> bool:
        """Whether no more can be watched."""
        return len(self._names) >= MOST_WATCHED

    def attach(self, grabber: FrameGrabber, worker: FeatureWorker) -> None:
        """Read from this source."""
        with self._lock:
            self._source = (grabber, worker)
            self._begin_anew()

    def detach(self) -> None:
        """Stop reading, but keep the names."""
        with self._lock:
            self._source = None
            self._begin_anew()

    def want(self, wanted: bool) -> None:
        """Set whether values are wanted."""
        with self._lock:
            if wanted != self._wanted:
                self._wanted = wanted
                self._begin_anew()

    def add(self, name: str) -> None:
        """Watch one more feature; does nothing if it is watched already, or if `full`."""
        with self._lock:
            if name not in self._names and not self.full:
                self._names = (*self._names, name)
                self._begin_anew()

    def remove(self, name: str) -> None:
        """Stop watching a feature."""
        with self._lock:
            self._names = tuple(other for other in self._names if other != name)
            self._begin_anew()

    def _begin_anew(self) -> None:
        self._reading += 1
        if self._source is not None and self._wanted and self._names:
            self._submit(self._source, self._reading, 0.0)

    def _submit(self, source: tuple[FrameGrabber, FeatureWorker], reading: int, delay: float) -> None:
        grabber, worker = source
        worker.submit(lambda: self._read(grabber, reading), delay=delay, failed=lambda _: None)

    def _read(self, grabber: FrameGrabber, reading: int) -> None:
        with self._lock:
            if reading != self._reading:
                return
            names = self._names
        delay = self._period
        values: dict[str, float] = {}
        units: dict[str, str] = {}
        for name in names:
            values[name] = math.nan
            try:
                feature = grabber.feature(name)
                values[name], units[name] = _as_number(feature), feature.unit
            except FeatureError:
                continue
            except GrabberError:
                delay = RETRY_PERIOD
                break
        with self._lock:
            if reading != self._reading or self._source is None:
                return
            self._submit(self._source, reading, delay)
        self.sampled.emit(time.time(), values, units)


def _as_number(feature: Feature) -> float:
    """Return a feature's value for a plot; NaN if it has none."""
    value = feature.value
    return float(value) if isinstance(value, int | float) else math.nan
