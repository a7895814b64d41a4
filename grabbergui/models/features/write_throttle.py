"""When writes are sent: at most so many a second, the last value always."""

from __future__ import annotations


class WriteThrottle:
    """Limits each feature to one write an interval, and keeps all writes in the order of their requests.

    A write that would overtake a waiting write of another feature waits with it: an exposure written after
    its automatic mode was switched on would switch the mode off again. Times are seconds of any one clock.
    """

    def __init__(self, interval: float = 1 / 60) -> None:
        self.interval = interval
        "Shortest time between two writes of one feature in seconds: a screen shows 60 frames per second."
        self._sent: dict[str, float] = {}
        self._waiting: dict[str, float] = {}

    def ask(self, name: str, now: float) -> float:
        """Return the delay of a write in seconds. It replaces a waiting write of the same name."""
        earliest = self._sent.get(name, now - self.interval) + self.interval
        due = max(now, earliest, *self._waiting.values())
        self._waiting[name] = due
        return due - now

    def barrier(self, now: float) -> float:
        """Return the delay in seconds until every waiting write is due, for jobs that depend on them."""
        return max([now, *self._waiting.values()]) - now

    def sent(self, name: str, now: float) -> None:
        """Record that the write was sent."""
        self._waiting.pop(name, None)
        self._sent[name] = now

    def waits(self, name: str) -> bool:
        """Return whether a write of this feature is still to be sent."""
        return name in self._waiting

    def waiting(self) -> tuple[str, ...]:
        """Return the features with a write still to be sent."""
        return tuple(self._waiting)
