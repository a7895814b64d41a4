"""Waiting for conditions, and checking promises about time, however busy or slow the machine is."""

from __future__ import annotations

import contextlib
import gc
import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TypeVar

T = TypeVar("T")

PATIENCE = 60.0
"""Seconds after which something counts as never happening; a virtual machine may stand still for half."""
PROGRAM = 120.0
"""Seconds that a program of its own may take to start, do its work and end."""
TRIES = 8
"""Other programs may hold the cores for a moment; a delay in the design would show in every try."""
PAUSE = 0.1
"""Seconds between the first two tries; each pause is that much longer than the one before."""
TURNS, AT_REST = 400_000, 0.02
"""A piece of work, and the seconds that it takes a desktop with nothing else to do."""


def until(condition: Callable[[], T], what: str = "it", seconds: float = PATIENCE) -> T:
    """Poll until a condition holds, and return its value.

    The longer it waits, the less often it polls, but it is late by a twentieth of the wait at most. Polling
    takes time from the work that it waits for.
    """
    begun = time.monotonic()
    while not (found := condition()):
        waited = time.monotonic() - begun
        assert waited < seconds, f"{what} did not happen within {seconds:g} s"
        time.sleep(min(max(0.002, waited / 20), 0.1))
    return found


@contextmanager
def little_garbage() -> Iterator[None]:
    """Restrict Python's collector to new objects, as in a program that does one thing.

    After thousands of tests a whole collection takes a third of a second.
    """
    set_aside_what_stays()
    try:
        yield
    finally:
        set_aside_what_stays()


def set_aside_what_stays() -> None:
    """Make Python's collector skip modules, test items and all other present objects.

    Otherwise a tenth of the tests' work would be scanning 7,000 items repeatedly.
    """
    gc.unfreeze()
    gc.collect()
    gc.freeze()


class Stopwatch:
    """Measures the seconds that its `with` block would take a machine at rest.

    Of wall-clock time, or of the processor's by `time.thread_time` or `time.process_time`.
    """

    seconds = float("inf")

    def __init__(self, clock: Callable[[], float] = time.perf_counter) -> None:
        self._clock = clock

    def __enter__(self) -> Stopwatch:
        self._slowness = slowness(self._clock)
        self._begun = self._clock()
        return self

    def __exit__(self, *_: object) -> None:
        took = self._clock() - self._begun
        self.seconds = took / ((self._slowness + slowness(self._clock)) / 2)


def slowness(clock: Callable[[], float] = time.perf_counter) -> float:
    """Return how many times longer than an idle desktop this machine takes for some work; 1 or more."""
    begun = clock()
    total = 0
    for number in range(TURNS):
        total += number
    return max((clock() - begun) / AT_REST, 1.0)


def crowding() -> float:
    """Return how many programs want each core of this machine; 1 or more."""
    wanted = os.getloadavg()[0]
    with contextlib.suppress(OSError):  # Linux knows how many want one at this moment
        wanted = max(wanted, int(Path("/proc/loadavg").read_text().split()[3].split("/")[0]))
    return max(wanted / (os.cpu_count() or 1), 1.0)


def allowance() -> float:
    """Return the factor by which this machine may exceed a promise about time; 1 on a desktop at rest.

    A thread that waits for a core at each of its steps loses more than its share of the cores.
    """
    return slowness() * (2 * crowding() - 1)


def attempts(
    promised: float, tries: int = TRIES, clock: Callable[[], float] = time.perf_counter
) -> Iterator[Stopwatch]:
    """Yield stopwatches for the same thing until it took no longer than promised, in seconds.

    Prepare within `for watch in attempts(1.0):`, then run `with watch:`. Fails if every attempt took longer,
    with an allowance for other programs on a busy machine.
    """
    took: list[str] = []
    while len(took) < tries:
        time.sleep(PAUSE * len(took))
        crowded = crowding()
        watch = Stopwatch(clock)
        yield watch
        allowed = promised * (2 * max(crowded, crowding()) - 1)
        if watch.seconds <= allowed:
            return
        took.append(f"{watch.seconds:.3g} of {allowed:.3g}")
    raise AssertionError(f"took {', '.join(took)} s, and {promised:g} s were promised")
