"""A device's clock in terms of the host's."""

from __future__ import annotations

from collections import deque


def ticks_to_ns(ticks: int, frequency: int) -> int:
    """Device ticks as nanoseconds, without the rounding of floats; 0 where the device has no clock."""
    if frequency <= 0:
        return 0
    seconds, rest = divmod(ticks, frequency)
    return seconds * 1_000_000_000 + rest * 1_000_000_000 // frequency


class ClockMapper:
    """Maps device time to host time by the packets that travelled fastest.

    Every arrival is its device time plus the clocks' offset plus a delay that is never negative, so the
    smallest difference seen lately is the best estimate of the offset. Nothing is written to the device.
    """

    def __init__(self, window_ns: int = 10_000_000_000) -> None:
        """`window_ns`: how far back arrivals count; clocks drift apart beyond it."""
        self._window_ns = window_ns
        self._best: deque[tuple[int, int]] = deque()
        self._newest = 0

    def map(self, device_ns: int, arrival_ns: int) -> int:
        """Host time of a device time whose message arrived at `arrival_ns`; never later than that."""
        if device_ns < self._newest:
            self._best.clear()  # the device's clock was set back
        self._newest = device_ns
        offset = arrival_ns - device_ns
        # Kept so that offsets grow from left to right: the leftmost is the smallest of the window.
        while self._best and self._best[-1][1] >= offset:
            self._best.pop()
        self._best.append((arrival_ns, offset))
        while self._best[0][0] < arrival_ns - self._window_ns:
            self._best.popleft()
        return device_ns + self._best[0][1]
