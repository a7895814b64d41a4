"""The device's clock seen from the host's."""

from __future__ import annotations

import time
from collections.abc import Callable

BRACKETS = 3
"Readings of which the quickest counts."


class DeviceClock:
    """Maps device time to host time (`time.monotonic_ns`), by one reading of both at the same moment.

    Any thread may map; a new reading corrects the drift between the two crystals.
    """

    def __init__(self) -> None:
        self._offset: int | None = None

    def synchronise(self, latch: Callable[[], None], read_ns: Callable[[], int]) -> None:
        """Let the device note its time (`latch`), then fetch it; the quickest of a few readings counts.

        Errors of either call pass through.
        """
        best: tuple[int, int] | None = None
        for _ in range(BRACKETS):
            before = time.monotonic_ns()
            latch()
            after = time.monotonic_ns()
            reading = (after - before, (before + after) // 2 - read_ns())
            best = min(best, reading) if best else reading
        if best is not None:
            self._offset = best[1]

    def forget(self) -> None:
        """Drop the reading: another device, or its clock was reset."""
        self._offset = None

    def host_time(self, device_ns: int, arrival_ns: int) -> int:
        """Host time of a device time stamp; the arrival where it cannot be told or would be later."""
        if self._offset is None or not device_ns:
            return arrival_ns
        mapped = device_ns + self._offset
        # More than a minute off is another clock's time, not a long way.
        return mapped if 0 <= arrival_ns - mapped < 60_000_000_000 else arrival_ns
