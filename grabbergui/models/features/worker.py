"""The thread for all calls of one open source."""

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
