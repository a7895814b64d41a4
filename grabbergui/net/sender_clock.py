"""When a remote image was exposed, from the sender's stamp and the time of its arrival. No I/O, no clock.

A sender's clock may agree with ours, as those of synchronised computers do, or not. If it agrees, the stamp
itself counts. If not, the fastest image so far counts as having taken no time, and every other one as delayed
by as much more as it took: so images that begin to arrive late are known to be old either way.
"""

from __future__ import annotations

AGREE_NS = 50_000_000
"An image that took no less than 0 and no more than this, by the stamp, shows that the clocks agree."
DRIFT = 1e-4
"By how much an unsynchronised clock is fast or slow, at most: two ordinary quartz clocks differ by less."
SET_NS = 5_000_000_000
"A delay that grows by more shows that the sender's clock was set; images do not wait for so long."
STEP_NS = 10_000_000
"A step of our own clock by more restarts the comparison, as the sender may be on this computer."


class SenderClock:
    """Compares one sender's stamps with their arrivals. Use from one thread. All times are nanoseconds."""

    def __init__(self) -> None:
        self._least: int | None = None
        "The shortest delay by the stamps, which clocks that disagree may make negative."
        self._arrived = 0
        "When the last image arrived, monotonic."
        self._offset = 0
        "Our time of day less the monotonic time, when the comparison began."

    def age(self, stamp: int, arrived: int, now: int) -> int:
        """Return how long ago an image was exposed when it arrived; 0 for one without a stamp.

        `stamp` is the sender's time of day, `arrived` our monotonic time and `now` our time of day.
        """
        if stamp <= 0:
            return 0
        if self._least is None or abs(now - arrived - self._offset) > STEP_NS:
            self._least, self._offset = None, now - arrived
        delay = arrived + self._offset - stamp
        if self._least is None or delay > self._least + SET_NS:
            self._least, self._arrived = delay, arrived
        self._least = min(delay, self._least + round(DRIFT * max(arrived - self._arrived, 0)))
        self._arrived = arrived
        return delay if 0 <= self._least <= AGREE_NS else delay - self._least
