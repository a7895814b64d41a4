"""Requests on the stream endpoint, completed in order.

`SynchronousQueue` works through any pyusb backend, one transfer at a time; `libusb_queue.LibusbQueue` keeps
several in flight. `open_queue` chooses.
"""

from __future__ import annotations

import contextlib
import logging
from abc import ABC, abstractmethod
from collections import deque
from dataclasses import dataclass
from enum import Enum
from typing import Any

import usb.backend.libusb1

from grabbergui.core.errors import AccessDeniedError, DeviceLostError, TransportError
from grabbergui.driver.u3v.block_assembler import Request
from grabbergui.driver.u3v.enumeration import BulkInterface, UsbCamera
from grabbergui.driver.u3v.usb import EndpointHaltedError, UsbHandle, UsbTimeoutError

log = logging.getLogger(__name__)


class Outcome(Enum):
    """Result of a transfer."""

    DONE = "done"
    HALTED = "halted"
    "The device stalled the endpoint."
    FAILED = "failed"
    "Bus error, or more bytes than requested."


@dataclass(frozen=True)
class Completion:
    """A finished request."""

    request: Request
    length: int
    "Bytes received."
    outcome: Outcome = Outcome.DONE


class TransferQueue(ABC):
    """Bulk requests in. One thread, except for `wake`."""

    depth: int
    "Largest number of requests in the queue."

    def __init__(self) -> None:
        self.held = 0
        "Requests submitted and not completed."
        self.held_bytes = 0

    @abstractmethod
    def submit(self, request: Request) -> bool:
        """Queue a request behind the others; return False if the system has no room and the caller must wait.

        Raises DeviceLostError, TransportError.
        """

    @abstractmethod
    def wait(self, timeout: float) -> Completion | None:
        """Return the oldest request once completed; None after about `timeout` s. Raises DeviceLostError."""

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
        """Cancel and release everything. May be called twice; never raises."""

    def _count(self, request: Request, sign: int) -> None:
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
        self._requests: deque[Request] = deque()

    def submit(self, request: Request) -> bool:
        """Keep it until `wait`."""
        self._requests.append(request)
        self._count(request, 1)
        return True

    def wait(self, timeout: float) -> Completion | None:
        """Read the oldest request now."""
        request = self._requests[0]
        outcome, length = Outcome.DONE, 0
        try:
            length = self._handle.read_whole(
                self._stream.endpoint_in, self._stream.number, request.view, timeout
            )
        except UsbTimeoutError:
            return None
        except EndpointHaltedError:
            outcome = Outcome.HALTED
        except DeviceLostError:
            raise
        except TransportError as error:
            log.debug("stream transfer: %s", error)
            outcome = Outcome.FAILED
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


def open_queue(camera: UsbCamera, handle: UsbHandle, depth: int) -> TransferQueue:
    """Return the best queue there is: asynchronous over libusb, synchronous where that cannot be had.

    Raises AccessDeniedError, DeviceLostError, TransportError.
    """
    stream = camera.stream
    if stream is None:
        raise TransportError(f"{handle.name} has no stream interface")
    library = _libusb_of(camera.backend)
    if library is not None and depth > 1:
        try:
            from grabbergui.driver.u3v.libusb_queue import LibusbQueue

            return LibusbQueue(library, camera, stream, depth)
        except ImportError:
            log.info("python-libusb1 is missing; streaming takes one transfer at a time")
        except (AccessDeniedError, DeviceLostError):
            raise
        except TransportError as error:
            log.info("no second handle (%s); streaming takes one transfer at a time", error)
    return SynchronousQueue(handle, stream)


def _libusb_of(backend: Any) -> str | None:
    """Return the path of the libusb that a pyusb backend runs on; None for a simulated bus."""
    if not isinstance(backend, usb.backend.libusb1._LibUSB):
        return None
    name: str = backend.lib._name
    return name
