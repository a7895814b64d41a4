"""The lines of the simulated camera: the input Line1 and the output Line2. Nothing here waits.

Times are nanoseconds of the host's monotonic clock.
"""

from __future__ import annotations

from collections.abc import Callable

from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.enumerations import LineSource
from grabbergui.driver.sim.memory import RegisterMemory

LINE1, LINE2 = 0, 1
"Indices of the lines, as in LineSelector."


class SignalLines:
    """Levels at the connector and inside the camera. The caller holds the camera's lock."""

    def __init__(self, memory: RegisterMemory, edge: Callable[[bool, int], None]) -> None:
        """`edge` is called with each new level of Line1 inside the camera, and the time."""
        self._memory = memory
        self._edge = edge
        self._connector = False
        "The level at the input, before the inverter."
        self._pending: list[tuple[bool, int]] = []

    def set_input(self, high: bool, at: int) -> None:
        """Set the level at the connector of Line1."""
        self._connector = high
        self.update(at)

    def update(self, at: int) -> None:
        """Apply the inverter of Line1, which may just have been switched."""
        level = self._connector != bool(self._memory.integer(reg.LINE_INVERTER[LINE1]))
        if level != bool(self._memory.integer(reg.LINE_STATUS[LINE1])):
            self._memory.set(reg.LINE_STATUS[LINE1], int(level))
            self._edge(level, at)

    def expose(self, start: int, end: int) -> None:
        """Show an exposure on Line2 if that is its source."""
        if self._memory.integer(reg.LINE_SOURCE[LINE2]) == LineSource.EXPOSURE_ACTIVE:
            self._put_out(True, start)
            self._put_out(False, end)

    def set_user_output(self, high: bool, at: int) -> None:
        """Show UserOutput0 on Line2 if that is its source."""
        if self._memory.integer(reg.LINE_SOURCE[LINE2]) == LineSource.USER_OUTPUT0:
            self._put_out(high, at)

    def take_output(self) -> list[tuple[bool, int]]:
        """Return the levels at the connector of Line2 since the last call, with their times."""
        pending, self._pending = self._pending, []
        return pending

    def _put_out(self, high: bool, at: int) -> None:
        level = high != bool(self._memory.integer(reg.LINE_INVERTER[LINE2]))
        self._memory.set(reg.LINE_STATUS[LINE2], int(high))
        self._pending.append((level, at))
