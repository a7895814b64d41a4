"""The watching thread of an opened camera: receives events, notices unplugging, reads the camera's clock."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable

import numpy as np

from grabbergui.core.errors import DeviceLostError, GrabberError, RemoteProtocolError, TransportError
from grabbergui.driver.u3v.enumeration import BulkInterface
from grabbergui.driver.u3v.gencp import Event, decode_events
from grabbergui.driver.u3v.stream_protocol import round_up
from grabbergui.driver.u3v.usb import EndpointHaltedError, UsbHandle, UsbTimeoutError

log = logging.getLogger(__name__)

BRACKETS = 3
"Readings of which the quickest counts."


class DeviceClock:
    """Maps device time to host time (`time.monotonic_ns`), by one reading of both at the same moment.

    Any thread may map; a new reading corrects the drift between the two crystals.
    """

    def __init__(self) -> None:
        self._offset: int | None = None

    def synchronise(self, latch: Callable[[], None], read_ns: Callable[[], int]) -> None:
        """Let the device note its time (`latch`), then fetch it; the quickest of a few readings counts.

        Errors of either call pass through.
        """
        best: tuple[int, int] | None = None
        for _ in range(BRACKETS):
            before = time.monotonic_ns()
            latch()
            after = time.monotonic_ns()
            reading = (after - before, (before + after) // 2 - read_ns())
            best = min(best, reading) if best else reading
        if best is not None:
            self._offset = best[1]

    def forget(self) -> None:
        """Drop the reading: another device, or its clock was reset."""
        self._offset = None

    def host_time(self, device_ns: int, arrival_ns: int) -> int:
        """Return the host time of a device time stamp; the arrival if that is unknown or would be later."""
        if self._offset is None or not device_ns:
            return arrival_ns
        mapped = device_ns + self._offset
        # More than a minute off is another clock's time, not a long way.
        return mapped if 0 <= arrival_ns - mapped < 60_000_000_000 else arrival_ns


LARGEST_EVENT = 65536
WAIT_TIME = 0.2
"Seconds after which the thread checks whether it should end."
PRESENCE_PERIOD = 1.0
"Seconds between checks whether a camera without event interface is still plugged in."
ERRORS_IN_A_ROW = 5
"Failed transfers after which the camera is given up, though it is still plugged in."
CLOCK_PERIOD = 10.0
"Seconds between readings of the camera's clock: crystals drift by up to a millisecond in that time."


class Watcher:
    """One thread. Calls `on_event` and `on_lost` from it."""

    def __init__(
        self,
        handle: UsbHandle,
        event: BulkInterface | None,
        longest_event: int,
        on_event: Callable[[int, bytes], None],
        on_lost: Callable[[str], None],
        synchronise_clock: Callable[[], None],
    ) -> None:
        self.ignored = 0
        "Malformed event packets."
        self._handle = handle
        self._event = event
        self._on_event = on_event
        self._on_lost = on_lost
        self._synchronise_clock = synchronise_clock
        self._errors = 0
        "Failed event transfers since one that did not."
        self._stopping = threading.Event()
        packet_size = event.packet_size if event else 1024
        room = round_up(min(max(longest_event, packet_size), LARGEST_EVENT), packet_size)
        self._inbox = np.zeros(room, np.uint8)
        self._thread = threading.Thread(target=self._run, name="u3v-watch", daemon=True)

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def stop(self) -> None:
        """End the thread; returns once it has ended. Nothing is called any more then."""
        self._stopping.set()
        if self._thread is not threading.current_thread() and self._thread.ident is not None:
            self._thread.join()

    def _run(self) -> None:
        next_clock = time.monotonic() + CLOCK_PERIOD
        try:
            while not self._stopping.is_set():
                if self._event is not None:
                    self._receive(self._event)
                elif not self._stopping.wait(PRESENCE_PERIOD) and not self._handle.is_present():
                    raise DeviceLostError(f"{self._handle.name} was unplugged")
                if time.monotonic() >= next_clock:
                    next_clock = time.monotonic() + CLOCK_PERIOD
                    self._synchronise_clock()
        except GrabberError as error:
            if not self._stopping.is_set():
                self._on_lost(str(error))

    def _receive(self, event: BulkInterface) -> None:
        try:
            length = self._handle.read_into(event.endpoint_in, event.number, self._inbox, WAIT_TIME)
        except UsbTimeoutError:
            return
        except EndpointHaltedError:
            self._handle.clear_halt(event.endpoint_in)
            return
        except DeviceLostError:
            raise
        except TransportError as error:
            self._endure(error)
            return
        self._errors = 0
        try:
            records = decode_events(self._inbox[:length].tobytes())
        except RemoteProtocolError as error:
            self.ignored += 1
            log.debug("event: %s", error)
            return
        for record in records:
            self._on_event(record.event_id, self._adapted(record))

    def _endure(self, error: TransportError) -> None:
        """Go on after a disturbance on the bus, or an event longer than announced; not after too many."""
        log.info("event: %s", error)
        self._errors += 1
        if self._errors > ERRORS_IN_A_ROW or not self._handle.is_present():
            raise error
        self._stopping.wait(WAIT_TIME)  # a failure comes at once, where a time-out would have waited

    @staticmethod
    def _adapted(record: Event) -> bytes:
        # GenApi's adapter takes a whole packet and reads its first record only.
        return record.encode(0)
