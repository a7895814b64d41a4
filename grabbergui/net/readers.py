"""The readers connected to a server of ours, and how much each has taken; the same for both networks."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Reader:
    """A program that is connected to a shared camera."""

    name: str
    "The port or node, as its network names it."
    takes: str
    "The port or topic that it is connected to; YARP's carrier in brackets."
    address: str = ""
    "Its computer's address; empty if the network does not report it."
    images: int = 0
    """Images sent to it since it connected. ROS 2 counts them for each topic, not for each subscriber: since
    the start, the same for all subscribers of a topic."""
    bytes: int = 0
    "Their bytes, as sent."

    @property
    def key(self) -> tuple[str, str]:
        """Distinguishes connections."""
        return self.name, self.takes
