"""Stream transfers one at a time, through any pyusb backend."""

from __future__ import annotations

import contextlib
import logging
from collections import deque

from grabbergui.core.errors import DeviceLostError, TransportError
from grabbergui.driver.u3v.block_assembler import Request
from grabbergui.driver.u3v.enumeration import BulkInterface
from grabbergui.driver.u3v.transfer_queue import Completion, Outcome, TransferQueue
from grabbergui.driver.u3v.usb import EndpointHaltedError, UsbHandle, UsbTimeoutError

log = logging.getLogger(__name__)


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
        """Forget the requests; none is under way outside `wait`."""
        self._requests.clear()
        self.held = self.held_bytes = 0

    def reset_endpoint(self) -> None:
        """Halt and clear."""
        with contextlib.suppress(EndpointHaltedError):  # a device may refuse to be halted
            self._handle.set_halt(self._stream.endpoint_in)
        self._handle.clear_halt(self._stream.endpoint_in)

    def wake(self) -> None:
        """A read cannot be cut short; it ends by its timeout."""

    def close(self) -> None:
        """Release the stream interface."""
        self.cancel()
        self._handle.release(self._stream.number)
