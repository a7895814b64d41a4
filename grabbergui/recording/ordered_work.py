"""Work shared out to several threads, its results taken up in the order in which it was given."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Generic, TypeVar

Result = TypeVar("Result")


class OrderedWork(Generic[Result]):
    """A few pieces of work at a time, for what releases the GIL: compressing, writing.

    Used from one thread; `done` is called on that thread. However slow the work is, no more than `waiting`
    pieces are held when `add` returns: with 0 it returns when the work is done.
    """

    def __init__(self, name: str, threads: int, waiting: int, done: Callable[[Result], object]) -> None:
        self._pool = ThreadPoolExecutor(threads, thread_name_prefix=name)
        self._waiting = waiting
        self._done = done
        self._begun: deque[Future[Result]] = deque()

    @property
    def held(self) -> int:
        """Pieces that were given and whose results were not taken up yet."""
        return len(self._begun)

    def add(self, work: Callable[[], Result]) -> None:
        """Give a piece of work; waits while too many are held. Raises what it or an earlier piece raised."""
        self._begun.append(self._pool.submit(work))
        while self._begun and (self._begun[0].done() or len(self._begun) > self._waiting):
            self._done(self._begun.popleft().result())

    def finish(self) -> None:
        """Wait for all and end the threads; then raises the first error there was. May be called twice."""
        failure: BaseException | None = None
        while self._begun:
            try:
                self._done(self._begun.popleft().result())
            except Exception as error:
                failure = failure or error
        self._pool.shutdown()
        if failure is not None:
            raise failure
