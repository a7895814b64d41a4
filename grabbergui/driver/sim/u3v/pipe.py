"""A bulk IN endpoint as USB sees it: packets that requests collect."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable

from grabbergui.driver.sim.u3v.registers import PACKET_SIZE


class PipeError(Exception):
    """A request did not succeed; never leaves the simulated camera."""


class PipeHaltedError(PipeError):
    """The endpoint is stalled."""


class PipeGoneError(PipeError):
    """The device was unplugged."""


class PipeTimeoutError(PipeError):
    """No transfer was available in time."""


class PipeCancelledError(PipeError):
    """The host took the request back."""


class PipeOverflowError(PipeError):
    """A packet did not fit the rest of the request; it is lost."""


class InPipe:
    """The queue of data that the device sends. Any thread.

    A transfer is cut into packets; a request ends when it is full or with a short packet. A transfer whose
    last packet is full does not end a request that wants more, unless an empty packet follows it.
    """

    on_flush: Callable[[], None] | None = None
    """Called after the queue was discarded: a front cancels the transfers it holds. Any thread."""

    def __init__(self) -> None:
        self._transfers: deque[memoryview] = deque()
        self._changed = threading.Condition()
        self._halted = False
        self._gone = False

    @property
    def halted(self) -> bool:
        """Whether requests are stalled."""
        return self._halted

    def put(self, *transfers: bytes | memoryview) -> None:
        """Queue transfers; an empty one is an empty packet. Dropped while halted or unplugged."""
        with self._changed:
            if not self._halted and not self._gone:
                self._transfers.extend(memoryview(transfer) for transfer in transfers)
                self._changed.notify_all()

    def wait_until_fewer(self, transfers: int, timeout: float) -> bool:
        """Wait until fewer transfers than this are queued; False after `timeout` seconds."""
        with self._changed:
            return self._changed.wait_for(lambda: len(self._transfers) < transfers, timeout)

    def take(
        self, size: int, timeout: float | None = None, cancelled: Callable[[], bool] = lambda: False
    ) -> list[memoryview]:
        """Serve one request of `size` bytes; return its data in pieces. Raises a PipeError.

        After a timeout, the data received until then are returned if there are any.
        """
        deadline = None if timeout is None else time.monotonic() + timeout
        parts: list[memoryview] = []
        left = size
        with self._changed:
            while True:
                if self._gone:
                    raise PipeGoneError
                if cancelled():
                    raise PipeCancelledError
                if self._halted:
                    raise PipeHaltedError
                if self._transfers:
                    part = self._take_part(left)
                    parts.append(part)
                    left -= len(part)
                    if left == 0 or len(part) % PACKET_SIZE or not len(part):
                        return parts
                    continue
                wait = None if deadline is None else deadline - time.monotonic()
                if wait is not None and wait <= 0:
                    if parts:
                        return parts
                    raise PipeTimeoutError
                self._changed.wait(wait)

    def wake(self) -> None:
        """Let `take` look at `cancelled`."""
        with self._changed:
            self._changed.notify_all()

    def take_transfer(self, timeout: float) -> memoryview:
        """Return the next transfer as it was queued, for a front that leaves packets to a controller."""
        with self._changed:
            self._changed.wait_for(lambda: self._transfers or self._gone, timeout)
            if self._gone:
                raise PipeGoneError
            if not self._transfers:
                raise PipeTimeoutError
            self._changed.notify_all()
            return self._transfers.popleft()

    def flush(self) -> None:
        """Discard the queued transfers."""
        with self._changed:
            self._transfers.clear()
            self._changed.notify_all()
        if self.on_flush is not None:
            self.on_flush()

    def set_halt(self) -> None:
        """Stall the pipe and discard the queued transfers."""
        with self._changed:
            self._halted = True
            self._transfers.clear()
            self._changed.notify_all()

    def clear_halt(self) -> None:
        """End the stall."""
        with self._changed:
            self._halted = False
            self._changed.notify_all()

    def unplug(self) -> None:
        """Fail every request from here on."""
        with self._changed:
            self._gone = True
            self._transfers.clear()
            self._changed.notify_all()

    def plug_in(self) -> None:
        """Start again."""
        with self._changed:
            self._gone = self._halted = False
            self._transfers.clear()

    def _take_part(self, left: int) -> memoryview:
        transfer = self._transfers[0]
        if len(transfer) > left and left % PACKET_SIZE:
            self._transfers.popleft()
            self._changed.notify_all()
            raise PipeOverflowError
        if len(transfer) > left:
            self._transfers[0] = transfer[left:]
            return transfer[:left]
        self._transfers.popleft()
        self._changed.notify_all()
        return transfer
