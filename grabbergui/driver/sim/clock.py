"""The camera's clock: nanoseconds since power-on, or the network's time while PTP is on."""

from __future__ import annotations

import time
from collections.abc import Callable

Clock = Callable[[], int]


class DeviceClock:
    """Turns the host's monotonic time into the device's and back. All in nanoseconds."""

    def __init__(self, monotonic: Clock = time.monotonic_ns, master: Clock = time.time_ns) -> None:
        """`master` is the network's time, which PTP follows."""
        self.monotonic = monotonic
        self._master = master
        self._epoch = monotonic()
        self._following = False

    @property
    def following(self) -> bool:
        """Whether PTP sets the clock."""
        return self._following

    def follow(self, on: bool) -> None:
        """Switch PTP on or off; the clock goes on from where it is."""
        self._following = on
        self.discipline()

    def discipline(self) -> None:
        """Set the clock by its master once more, where it has one."""
        if self._following:
            self._epoch = self.monotonic() - self._master()

    def reset(self) -> None:
        """Start from zero."""
        self._epoch = self.monotonic()

    def now(self) -> int:
        """The device's time."""
        return self.monotonic() - self._epoch

    def offset_from_master(self) -> int:
        """How far the clock is ahead of its master; 0 without one."""
        return self.now() - self._master() if self._following else 0

    def to_device(self, monotonic: int) -> int:
        """A moment of the host's monotonic time on the device's clock."""
        return monotonic - self._epoch

    def to_monotonic(self, device: int) -> int:
        """The moment at which the device's clock shows a time."""
        return device + self._epoch
