"""When a write may be sent: decides, and reads no clock."""

from __future__ import annotations


class WriteThrottle:
    """Lets each feature be written once an interval, and keeps all writes in the order they were asked for.

    A write that would overtake a waiting one of another feature waits with it: an exposure written after
    its automatic mode was switched on would switch it off again. Times are seconds of any one clock.
    """

    def __init__(self, interval: float = 1 / 60) -> None:
        self.interval = interval
        "Least time between two writes of one feature, seconds: a screen shows no more than 60 pictures."
        self._sent: dict[str, float] = {}
        self._waiting: dict[str, float] = {}

    def ask(self, name: str, now: float) -> float:
        """How long from now a write has to wait. It takes the place of one of the same name that waits."""
        earliest = self._sent.get(name, now - self.interval) + self.interval
        due = max(now, earliest, *self._waiting.values())
        self._waiting[name] = due
        return due - now

    def barrier(self, now: float) -> float:
        """How long from now until every waiting write is due; what depends on them waits as long."""
        return max(now, *self._waiting.values(), now) - now

    def sent(self, name: str, now: float) -> None:
        """The write is on its way."""
        self._waiting.pop(name, None)
        self._sent[name] = now

    def waits(self, name: str) -> bool:
        """Whether a write is still to be sent."""
        return name in self._waiting

    def waiting(self) -> tuple[str, ...]:
        """Features with a write still to be sent."""
        return tuple(self._waiting)
