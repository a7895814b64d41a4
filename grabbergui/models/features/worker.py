"""One thread for all calls of one open source, and when it may send writes."""

from __future__ import annotations

import logging
import threading
import time
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

from grabbergui.core.errors import GrabberError

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
    """Runs jobs in their order on a thread of its own.

    A call to a camera takes as long as the network; here it delays only the calls behind it. `submit` and
    `close` may be called from any thread and `submit` never waits. A job must end by itself: every
    grabber call has a timeout.
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

        A job with a `key` takes the place of a waiting one with the same key, which is then neither run nor
        answered, and goes to the end: jobs submitted in between come first. An exception that is no
        GrabberError is a bug; it is logged and reported like an error. With a `delay` in seconds the job
        lets others pass until then. False, and nothing happens, once closed.
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
    def pressed(self) -> bool:
        """Whether a job waits only for the running one. A long job that can pause should do so then."""
        with self._wakeup:
            now = time.monotonic()
            return any(job.due <= now for job in self._waiting.values())

    def close(self, timeout: float = 6.0) -> bool:
        """Finish queued jobs and end the thread; return whether it ended within `timeout` seconds.

        New jobs are refused, delays are cut short. May be called twice; called by a job, it does not wait.
        """
        with self._wakeup:
            self._closed = True
            self._wakeup.notify()
        if threading.current_thread() is self._thread:
            return False
        self._thread.join(timeout)
        return not self._thread.is_alive()

    @property
    def alive(self) -> bool:
        """Whether the thread still runs."""
        return self._thread.is_alive()

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
                result = job.run()
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


class WriteThrottle:
    """Lets each feature be written once an interval, and keeps all writes in the order they were asked for.

    A write that would overtake a waiting one of another feature waits with it: an exposure written after
    its automatic mode was switched on would switch it off again. Times are seconds of any one clock.
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
        return max(now, *self._waiting.values(), now) - now

    def sent(self, name: str, now: float) -> None:
        """Record that the write was sent."""
        self._waiting.pop(name, None)
        self._sent[name] = now

    def waits(self, name: str) -> bool:
        """Return whether a write is still to be sent."""
        return name in self._waiting

    def waiting(self) -> tuple[str, ...]:
        """Return the features with a write still to be sent."""
        return tuple(self._waiting)
