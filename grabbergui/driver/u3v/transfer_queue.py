"""Requests on the stream endpoint, completed in order.

`SynchronousQueue` uses any pyusb backend, one transfer at a time.
"""

from __future__ import annotations

import contextlib
import logging
from abc import ABC, abstractmethod
from collections import deque
from dataclasses import dataclass
from enum import Enum

from grabbergui.core.errors import DeviceLostError, TransportError
from grabbergui.driver.u3v.block_assembler import TransferRequest
from grabbergui.driver.u3v.usb import BulkInterface, EndpointHaltedError, UsbHandle, UsbTimeoutError

log = logging.getLogger(__name__)


class TransferOutcome(Enum):
    """Result of a transfer."""

    DONE = "done"
    HALTED = "halted"
    "The device stalled the endpoint."
    FAILED = "failed"
    "Bus error, or more bytes than requested."


@dataclass(frozen=True)
class Completion:
    """A finished request."""

    request: TransferRequest
    length: int
    "Bytes received."
    outcome: TransferOutcome = TransferOutcome.DONE


class TransferQueue(ABC):
    """A queue of bulk requests on the stream's IN endpoint. One thread, except for `wake`."""

    depth: int
    "Largest number of requests in the queue."

    def __init__(self) -> None:
        self.held = 0
        "Number of requests submitted and not completed."
        self.held_bytes = 0

    @abstractmethod
    def submit(self, request: TransferRequest) -> bool:
        """Queue a request; return False if the system has no room and the caller must wait.

        Raises DeviceLostError, TransportError.
        """

    @abstractmethod
    def wait(self, timeout: float) -> Completion | None:
        """Return the oldest request once completed; None after about `timeout` s. Raises DeviceLostError."""

    @abstractmethod
    def cancel(self) -> None:
        """Cancel all requests; after return none accesses its memory. Never raises."""

    @abstractmethod
    def reset_endpoint(self) -> None:
        """Halt the endpoint and clear the halt, to discard stale data."""

    @abstractmethod
    def wake(self) -> None:
        """Let `wait` return early. Any thread."""

    @abstractmethod
    def close(self) -> None:
        """Cancel and release everything. May be called twice; never raises."""

    def _count(self, request: TransferRequest, sign: int) -> None:
        self.held += sign
        self.held_bytes += sign * len(request.view)


class SynchronousQueue(TransferQueue):
    """One blocking read after the other, through pyusb."""

    depth = 1

    def __init__(self, handle: UsbHandle, stream: BulkInterface) -> None:
        """Claim the stream interface. Raises AccessDeniedError, TransportError."""
        super().__init__()
        handle.claim(stream.number)
        self._handle = handle
        self._stream = stream
        self._requests: deque[TransferRequest] = deque()

    def submit(self, request: TransferRequest) -> bool:
        """Keep the request until `wait`."""
        self._requests.append(request)
        self._count(request, 1)
        return True

    def wait(self, timeout: float) -> Completion | None:
        """Read the oldest request now."""
        request = self._requests[0]
        outcome, length = TransferOutcome.DONE, 0
        try:
            length = self._handle.read_whole(
                self._stream.endpoint_in, self._stream.number, request.view, timeout
            )
        except UsbTimeoutError:
            return None
        except EndpointHaltedError:
            outcome = TransferOutcome.HALTED
        except DeviceLostError:
            raise
        except TransportError as error:
            log.debug("stream transfer: %s", error)
            outcome = TransferOutcome.FAILED
        self._requests.popleft()
        self._count(request, -1)
        return Completion(request, length, outcome)

    def cancel(self) -> None:
        """Forget the requests; none is in progress outside `wait`."""
        self._requests.clear()
        self.held = self.held_bytes = 0

    def reset_endpoint(self) -> None:
        """Halt and clear."""
        with contextlib.suppress(EndpointHaltedError):  # a device may refuse to be halted
            self._handle.set_halt(self._stream.endpoint_in)
        self._handle.clear_halt(self._stream.endpoint_in)

    def wake(self) -> None:
        """Do nothing: a synchronous read ends only by its timeout."""

    def close(self) -> None:
        """Release the stream interface."""
        self.cancel()
        self._handle.release(self._stream.number)
