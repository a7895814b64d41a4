"""Requests on the stream endpoint, completed in order.

Two ways under one interface: `synchronous_queue` on any pyusb backend, one transfer at a time, and
`libusb_queue`, which keeps several in flight; `queue_choice` takes the better one.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from enum import Enum

from grabbergui.driver.u3v.block_assembler import Request


class Outcome(Enum):
    """How a transfer ended."""

    DONE = "done"
    HALTED = "halted"
    "The device stalled the endpoint."
    FAILED = "failed"
    "An error on the bus, or more bytes than were asked for."


@dataclass(frozen=True)
class Completion:
    """A request that is over."""

    request: Request
    length: int
    "Bytes that came."
    outcome: Outcome = Outcome.DONE


class TransferQueue(ABC):
    """Bulk requests in. One thread, except for `wake`."""

    depth: int
    "How many requests it may hold."

    def __init__(self) -> None:
        self.held = 0
        "Requests submitted and not completed."
        self.held_bytes = 0

    @abstractmethod
    def submit(self, request: Request) -> bool:
        """Queue a request behind the others; False where the system has no room just now: wait first.

        Raises DeviceLostError, TransportError.
        """

    @abstractmethod
    def wait(self, timeout: float) -> Completion | None:
        """The oldest request, completed; None after about `timeout` seconds. Raises DeviceLostError."""

    @abstractmethod
    def cancel(self) -> None:
        """Give up every request; on return none touches its memory any more. Never raises."""

    @abstractmethod
    def reset_endpoint(self) -> None:
        """Halt the endpoint and clear the halt, so that nothing stale is left in it."""

    @abstractmethod
    def wake(self) -> None:
        """Let `wait` return early. Any thread."""

    @abstractmethod
    def close(self) -> None:
        """Cancel and let go. May be called twice; never raises."""

    def _count(self, request: Request, sign: int) -> None:
        self.held += sign
        self.held_bytes += sign * len(request.view)
