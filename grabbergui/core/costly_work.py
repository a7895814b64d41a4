"""Rests between peers' costly requests."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final

REST: Final = 3.0
"""Seconds of rest after each second of work: peers' computing takes a quarter of a core at most."""

_FREE_SECONDS: Final = 0.002
"""Work shorter than this needs no rest."""

_QUEUES: Final = 64


class CostlyWork:
    """Lets peers' costly requests run one at a time, with rests: turns for the whole process.

    Python runs one thread at a time and changes between busy ones every 5 ms: eight peers whose requests only
    compute would leave the stream a ninth of the processor. No address has more than one place in the queue.
    Work that waits for the camera does not belong here.
    """

    def __init__(
        self,
        clock: Callable[[], float] = time.monotonic,
        work_clock: Callable[[], float] = time.thread_time,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self._clock = clock
        self._work_clock = work_clock
        self._sleep = sleep
        self._turn = threading.Lock()
        self._next = 0.0
        "When the rest after the last turn is over."
        self._queues = [threading.Lock() for _ in range(_QUEUES)]
        "By address, so that one with many connections waits as long as one with a single connection."

    @contextmanager
    def turn(self, address: str) -> Iterator[None]:
        """Wait for a turn, and run the block in it. Any thread."""
        with self._queues[hash(address) % _QUEUES], self._turn:
            rest = self._next - self._clock()
            if rest > 0:
                self._sleep(rest)
            begun = self._work_clock()
            try:
                yield
            finally:
                spent = self._work_clock() - begun
                if spent > _FREE_SECONDS:
                    self._next = self._clock() + REST * spent


costly_work = CostlyWork()
"""The process's own."""
