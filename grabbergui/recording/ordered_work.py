"""Work on several threads, with its results in order."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Generic, TypeVar

Result = TypeVar("Result")


class OrderedWork(Generic[Result]):
    """Runs tasks that release the GIL (compressing, writing) on several threads, with results in order.

    Use from one thread, which also calls `done` with the results. When `add` returns, at most `waiting` tasks
    are unfinished; with 0 it returns when the task is done.
    """

    def __init__(self, name: str, threads: int, waiting: int, done: Callable[[Result], object]) -> None:
        self._pool = ThreadPoolExecutor(threads, thread_name_prefix=name)
        self._waiting = waiting
        self._done = done
        self._begun: deque[Future[Result]] = deque()

    @property
    def held(self) -> int:
        """Tasks whose results were not yet passed to `done`."""
        return len(self._begun)

    def add(self, work: Callable[[], Result]) -> None:
        """Add a task; wait if too many are held. Raises the error of this task or an earlier one."""
        self._begun.append(self._submitted(work))
        while self._begun and (self._begun[0].done() or len(self._begun) > self._waiting):
            self._done(self._begun.popleft().result())

    def _submitted(self, work: Callable[[], Result]) -> Future[Result]:
        try:
            return self._pool.submit(work)
        except RuntimeError:  # the interpreter is shutting down, and its pools accept no more tasks
            done: Future[Result] = Future()
            try:
                done.set_result(work())
            except Exception as error:
                done.set_exception(error)
            return done

    def finish(self) -> None:
        """Wait for all tasks and end the threads; then raise the first error. May be called twice."""
        failure: BaseException | None = None
        while self._begun:
            try:
                self._done(self._begun.popleft().result())
            except Exception as error:
                failure = failure or error
        self._pool.shutdown()
        if failure is not None:
            raise failure
