"""The guardian's decision when to stop. No I/O: time is an argument."""

from __future__ import annotations

import math

REPEATS = (0.0, 0.05, 0.2, 0.5, 1.0)
"""Seconds after an alarm at which the stop is sent: a command may still be on its way at the first."""


class StopScheduler:
    """Decides when to stop. No I/O: time is an argument, in seconds on any clock."""

    def __init__(self, silence: float) -> None:
        """`silence` is how long heartbeats may stay away while the robot moves, seconds."""
        self.stops = 0
        "Alarms so far."
        self.why = ""
        "Reason of the last."
        self.fault = False
        "Whether the last was a fault of the robot's."
        self.requested = 0
        "Number of the last stop that the program requested."
        self._silence = silence
        self._limit = math.inf
        self._repeats: list[float] = []

    @property
    def stopping(self) -> bool:
        """Whether a stop is still to be sent."""
        return bool(self._repeats)

    @property
    def due(self) -> float:
        """When `stop_due` must be called at the latest."""
        return min([self._limit, *self._repeats[:1]])

    def beat(self, now: float, moving: bool, stops: int) -> None:
        """Handle a heartbeat; ignore it if the program does not know of the last stop yet."""
        if stops == self.stops:
            self._limit = now + self._silence if moving else math.inf

    def alarm(self, now: float, why: str, *, fault: bool = False) -> None:
        """Stop now, and repeat it a few times."""
        self.stops += 1
        self.why, self.fault, self._limit = why, fault, math.inf
        self._repeats = [now + seconds for seconds in REPEATS]

    def request(self, now: float, number: int) -> None:
        """Stop because the program requested it."""
        self.requested, self._limit = number, math.inf
        self._repeats = [now, *self._repeats]

    def stop_due(self, now: float) -> bool:
        """Return whether the stop must be sent now."""
        if now >= self._limit:
            self.alarm(now, f"the servo program was silent for {1e3 * self._silence:.0f} ms")
        pending = [moment for moment in self._repeats if moment > now]
        due, self._repeats = len(pending) < len(self._repeats), pending
        return due
