"""How warm the camera gets: towards a balance that streaming raises, as a housing does."""

from __future__ import annotations

import math

_AMBIENT = 24.0
_TIME_CONSTANT_S = 90.0


class Thermometer:
    """One place in the camera. Times in nanoseconds on any one clock."""

    def __init__(self, now: int, idle: float, streaming: float) -> None:
        self._idle = idle
        "Degrees above the surroundings at rest."
        self._streaming = streaming
        "Degrees more while streaming."
        self._rise = 0.7 * idle
        self._since = now
        self._load = 0.0

    def set_streaming(self, streaming: bool, now: int) -> None:
        """Tell it that the load changes."""
        self._rise = self._now(now)
        self._since = now
        self._load = 1.0 if streaming else 0.0

    def read(self, now: int) -> float:
        """Degrees Celsius."""
        return round(_AMBIENT + self._now(now), 2)

    def _now(self, now: int) -> float:
        goal = self._idle + self._load * self._streaming
        decay = math.exp(-(now - self._since) * 1e-9 / _TIME_CONSTANT_S)
        return goal + (self._rise - goal) * decay
