"""The thread for all calls of one open source; the timing of writes; values sampled over time."""

from __future__ import annotations

import csv
import io
import logging
import math
import threading
import time
from collections import OrderedDict
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from datetime import datetime, timezone
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray
from psygnal import Signal

from grabbergui.core.errors import FeatureError, GrabberError
from grabbergui.core.features import Feature, FeatureKind
from grabbergui.core.grabber import FrameGrabber

log = logging.getLogger(__name__)

T = TypeVar("T")


@dataclass(frozen=True)
class _Job:
    run: Callable[[], Any]
    done: Callable[[Any], None] | None
    failed: Callable[[GrabberError], None] | None
    due: float
    "Earliest start on `time.monotonic`."


class FeatureWorker:
    """Runs jobs in order on a thread of its own.

    A slow call to a camera delays only the jobs after it. `submit` and `close` may be called from any thread
    and `submit` never waits. A job must end by itself: every grabber call has a timeout.
    """

    def __init__(self, name: str = "features") -> None:
        self._waiting: OrderedDict[object, _Job] = OrderedDict()
        self._wakeup = threading.Condition()
        self._closed = False
        self._thread = threading.Thread(target=self._work, name=name, daemon=True)
        self._thread.start()

    def submit(
        self,
        job: Callable[[], T],
        *,
        key: str | None = None,
        done: Callable[[T], None] | None = None,
        failed: Callable[[GrabberError], None] | None = None,
        delay: float = 0.0,
    ) -> bool:
        """Run `job` later; then `done` with its result or `failed` with its error, both on the worker.

        A job with a `key` replaces a waiting job with the same key, which is then neither run nor answered,
        and goes to the end of the queue. `failed` also gets an OSError about a file, as a GrabberError; any
        other exception is a bug, which is logged and reported likewise. During a `delay` in seconds other
        jobs may overtake. Returns False and does nothing once closed.
        """
        with self._wakeup:
            if self._closed:
                return False
            slot: object = object() if key is None else key
            self._waiting.pop(slot, None)
            self._waiting[slot] = _Job(job, done, failed, time.monotonic() + delay)
            self._wakeup.notify()
            return True

    @property
    def has_due_job(self) -> bool:
        """Whether a job waits only for the running one, which should then pause if it can."""
        with self._wakeup:
            now = time.monotonic()
            return any(job.due <= now for job in self._waiting.values())

    def close(self, timeout: float = 6.0) -> bool:
        """Finish queued jobs and end the thread; return whether it ended within `timeout` seconds.

        Refuses new jobs and cuts delays short. May be called twice; called by a job, it does not wait.
        """
        with self._wakeup:
            self._closed = True
            self._wakeup.notify()
        if threading.current_thread() is self._thread:
            return False
        self._thread.join(timeout)
        return not self._thread.is_alive()

    def _work(self) -> None:
        while (job := self._next()) is not None:
            self._run(job)

    def _next(self) -> _Job | None:
        with self._wakeup:
            while self._waiting or not self._closed:
                now = time.monotonic()
                for slot, job in self._waiting.items():
                    if job.due <= now or self._closed:
                        del self._waiting[slot]
                        return job
                earliest = min((job.due for job in self._waiting.values()), default=None)
                self._wakeup.wait(None if earliest is None else earliest - now)
            return None

    def _run(self, job: _Job) -> None:
        try:
            try:
                result = _result_of(job)
            except GrabberError as error:
                if job.failed is not None:
                    job.failed(error)
                else:
                    log.warning("%s", error)
            else:
                if job.done is not None:
                    job.done(result)
        except Exception as error:
            # The thread must survive: without it the window could not even close its camera.
            log.exception("a job of the feature worker failed")
            self._report(job, error)

    def _report(self, job: _Job, error: Exception) -> None:
        if job.failed is None:
            return
        try:
            job.failed(GrabberError(f"internal error, see the log: {type(error).__name__}: {error}"))
        except Exception:
            log.exception("the feature worker could not report an error")


def _result_of(job: _Job) -> Any:
    try:
        return job.run()
    except OSError as error:
        if error.filename is None:
            raise
        raise GrabberError(f"{error.filename}: {error.strerror}") from error


# -- when writes are sent ------------------------------------------------------------------------
class WriteThrottle:
    """Limits each feature to one write an interval, and keeps all writes in the order of their requests.

    A write that would overtake a waiting write of another feature waits with it: an exposure written after
    its automatic mode was switched on would switch the mode off again. Times are seconds of any one clock.
    """

    def __init__(self, interval: float = 1 / 60) -> None:
        self.interval = interval
        "Shortest time between two writes of one feature in seconds: a screen shows 60 frames per second."
        self._sent: dict[str, float] = {}
        self._waiting: dict[str, float] = {}

    def ask(self, name: str, now: float) -> float:
        """Return the delay of a write in seconds. It replaces a waiting write of the same name."""
        earliest = self._sent.get(name, now - self.interval) + self.interval
        due = max(now, earliest, *self._waiting.values())
        self._waiting[name] = due
        return due - now

    def barrier(self, now: float) -> float:
        """Return the delay in seconds until every waiting write is due, for jobs that depend on them."""
        return max([now, *self._waiting.values()]) - now

    def sent(self, name: str, now: float) -> None:
        """Record that the write was sent."""
        self._waiting.pop(name, None)
        self._sent[name] = now

    def waits(self, name: str) -> bool:
        """Return whether a write of this feature is still to be sent."""
        return name in self._waiting

    def waiting(self) -> tuple[str, ...]:
        """Return the features with a write still to be sent."""
        return tuple(self._waiting)


# -- values over time ----------------------------------------------------------------------------
MOST_SAMPLES = 36_000
"Most samples of one value: an hour at ten a second. The oldest are dropped."


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


WATCH_PERIOD = 0.1
"Seconds between two reads of everything."
RETRY_PERIOD = 1.0
"Seconds between two reads of a camera that does not answer."
MOST_WATCHED = 12
"Most features watched at once: more curves cannot be told apart, and each costs the camera a read."

PLOTTABLE = (FeatureKind.INTEGER, FeatureKind.FLOAT, FeatureKind.BOOLEAN)
"Kinds of features whose values can be plotted."


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
