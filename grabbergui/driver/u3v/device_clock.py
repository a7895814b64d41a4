"""Maps the time of a USB3 Vision camera to this computer's."""

from __future__ import annotations

import time
from collections.abc import Callable

BRACKETS = 3
"Number of readings, of which the fastest counts."
APART_NS = 100_000_000
"Between two readings that show how fast the device's clock runs; each may be a millisecond wrong."
MOST_DRIFT = 0.05
"Share by which a clock may be slow; one in other units than nanoseconds is slower by far."


class DeviceClock:
    """Maps device time to host time (`time.monotonic_ns`), from a simultaneous reading of both clocks.

    Any thread may map; each new reading corrects the clocks' drift. A clock that proves slow is not used: it
    would date frames before their exposure, by more from reading to reading.
    """

    def __init__(self) -> None:
        self._offset: int | None = None
        self._reading: tuple[int, int] | None = None
        "Host time and device time, by which later readings are judged."
        self._slow = False

    def synchronise(self, latch: Callable[[], None], read_ns: Callable[[], int]) -> None:
        """Latch the device's time, then read it; use the fastest of a few readings.

        Errors of either call pass through.
        """
        readings = []
        for _ in range(BRACKETS):
            before = time.monotonic_ns()
            latch()
            after = time.monotonic_ns()
            readings.append((after - before, (before + after) // 2, read_ns()))
        _, host, device = min(readings)
        if self._reading is None or device < self._reading[1]:  # the first, or the clock was set back
            self._reading, self._slow = (host, device), False
        elif (elapsed := host - self._reading[0]) >= APART_NS:
            self._slow = device - self._reading[1] < (1 - MOST_DRIFT) * elapsed
            self._reading = (host, device)
        self._offset = None if self._slow else host - device

    def forget(self) -> None:
        """Drop the readings, because the device or its clock's origin changes."""
        self._offset = self._reading = None

    def host_time(self, device_ns: int, arrival_ns: int) -> int:
        """Return the host time of a device timestamp; the arrival time if unknown or implausible."""
        if self._offset is None or not device_ns:
            return arrival_ns
        mapped = device_ns + self._offset
        # A difference of more than a minute is a different clock, not a delay.
        return mapped if 0 <= arrival_ns - mapped < 60_000_000_000 else arrival_ns
