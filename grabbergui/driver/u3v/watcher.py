"""Watches an open camera in a thread: its events, its unplugging, its clock."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable

import numpy as np

from grabbergui.core.errors import DeviceLostError, GrabberError, RemoteProtocolError, TransportError
from grabbergui.driver.u3v.gencp import decode_events
from grabbergui.driver.u3v.stream_protocol import round_up
from grabbergui.driver.u3v.usb import BulkInterface, EndpointHaltedError, UsbHandle, UsbTimeoutError

log = logging.getLogger(__name__)

LARGEST_EVENT = 65536
"Largest event packet in bytes, whatever the camera announces."
EVENT_WAIT = 0.2
"Seconds after which the watching thread checks whether it should end."
PRESENCE_PERIOD = 1.0
"Seconds between checks whether a camera without an event interface is still plugged in."
ERRORS_IN_A_ROW = 5
"Failed transfers of one thread after which a camera counts as lost, although it is still plugged in."
CLOCK_PERIOD = 10.0
"Seconds between readings of the camera's clock, which may drift by up to a millisecond in that time."
CLOCK_CHECK = 1.0
"Seconds until the second reading, which shows whether the clock is of any use."


class Watcher:
    """The watching thread, from construction until `stop`. Calls `on_event` and `on_lost`."""

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
        "Number of malformed event packets."
        self._handle = handle
        self._event = event
        self._on_event = on_event
        self._on_lost = on_lost
        self._synchronise_clock = synchronise_clock
        self._errors = 0
        "Failed event transfers since the last successful one."
        self._stopping = threading.Event()
        packet_size = event.packet_size if event else 1024
        room = round_up(min(max(longest_event, packet_size), LARGEST_EVENT), packet_size)
        self._inbox = np.zeros(room, np.uint8)
        self._thread = threading.Thread(target=self._run, name="u3v-watch", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """End the thread and wait for it. No function is called after return."""
        self._stopping.set()
        if self._thread is not threading.current_thread():
            self._thread.join()

    def _run(self) -> None:
        next_clock = time.monotonic() + CLOCK_CHECK
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
            length = self._handle.read_into(event.endpoint_in, event.number, self._inbox, EVENT_WAIT)
        except UsbTimeoutError:
            return
        except EndpointHaltedError:
            self._handle.clear_halt(event.endpoint_in)
            self._stopping.wait(EVENT_WAIT)  # unlike a timeout, a stall returns immediately
            return
        except DeviceLostError:
            raise
        except TransportError as error:
            self._tolerate(error)
            return
        self._errors = 0
        try:
            records = decode_events(self._inbox[:length].tobytes())
        except RemoteProtocolError as error:
            self.ignored += 1
            log.debug("event: %s", error)
            return
        for record in records:
            # GenApi's adapter needs a whole packet and reads only its first record.
            self._on_event(record.event_id, record.encode(0))

    def _tolerate(self, error: TransportError) -> None:
        """Tolerate a bus error or an event that is too long; re-raise the error after too many of them."""
        log.info("event: %s", error)
        self._errors += 1
        if self._errors > ERRORS_IN_A_ROW or not self._handle.is_present():
            raise error
        self._stopping.wait(EVENT_WAIT)  # unlike a timeout, a failure returns immediately
