"""Times of recorded frames, which never decrease, even where the clock was set back."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

DEFAULT_RATE = 25.0
"Frames per second of a recording without times."

_CLOCK_SET = 1_000_000_000
"Nanoseconds. If the time decreases by more, the clock was set back."
T = TypeVar("T")


class Rising:
    """Converts the times of successive frames to a clock that is never set back."""

    def __init__(self) -> None:
        self._highest = 0
        self._shift = 0

    def next(self, time_ns: int) -> int:
        """Return a time that is not earlier than those before it.

        A slightly earlier time becomes the highest so far; if the clock was set back, time continues there.
        """
        if time_ns + self._shift < self._highest - _CLOCK_SET:
            self._shift = self._highest - time_ns
        self._highest = max(self._highest, time_ns + self._shift)
        return self._highest


def rising(times: list[int]) -> list[int]:
    """Return the times of frames as converted by `Rising`."""
    clock = Rising()
    return [clock.next(time) for time in times]


def in_order_of_receipt(items: list[T], time: Callable[[T], int]) -> list[T]:
    """Sort items that are roughly in order by time, but not across a point where the clock was set back."""
    sections: list[list[T]] = [[]]
    latest = 0
    for item in items:
        if time(item) < latest - _CLOCK_SET:
            sections.append([])
            latest = 0
        sections[-1].append(item)
        latest = max(latest, time(item))
    return [item for section in sections for item in sorted(section, key=time)]
