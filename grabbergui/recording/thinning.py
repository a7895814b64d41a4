"""Which frames of a stream are recorded: all, every n-th, or one in so many seconds (time-lapse). No I/O."""

from __future__ import annotations

import math
from dataclasses import dataclass

from grabbergui.core.errors import UsageError


@dataclass(frozen=True)
class Thinning:
    """The choice of frames; both together: the first of every n-th ones that is due."""

    every: int = 1
    "1: all frames; 10: the first, the eleventh and so on."
    interval: float = 0.0
    "Seconds from one recorded frame to the next at least; 0: no matter."

    def __post_init__(self) -> None:
        """Raise UsageError for what cannot be."""
        if self.every < 1:
            raise UsageError(f"every {self.every}-th frame cannot be recorded; write 1 or more")
        if not (self.interval >= 0 and math.isfinite(self.interval)):
            raise UsageError(f"a time-lapse of {self.interval} s is not possible; write 0 or more")

    def rate(self, rate: float) -> float:
        """Return how many frames per second are recorded of a stream with `rate`; 0 if unknown."""
        thinned = rate / self.every
        if not self.interval:
            return thinned
        return min(thinned, 1 / self.interval) if thinned else 1 / self.interval


class ThinnedFrames:
    """Decides on the frames of one recording, in their order."""

    def __init__(self, thinning: Thinning) -> None:
        self._thinning = thinning
        self._seen = 0
        self._due: float | None = None

    def take(self, captured: float) -> bool:
        """Return whether the next frame, received at `captured` seconds of any clock, is recorded."""
        number, self._seen = self._seen, self._seen + 1
        thinning = self._thinning
        if number % thinning.every:
            return False
        if self._due is None:
            self._due = captured
        if captured < self._due:
            return False
        if thinning.interval:
            # In step with the first one: frames that are late do not delay those after them.
            self._due += thinning.interval * (math.floor((captured - self._due) / thinning.interval) + 1)
        return True


ALL_FRAMES = Thinning()
