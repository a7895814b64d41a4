"""A device whose register accesses are recorded, for a report."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from typing_extensions import override

from grabbergui.core.errors import AckTimeoutError, DeviceLostError, GrabberError
from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import StreamStatistics
from grabbergui.core.grabber import Access
from grabbergui.driver.device import Device, StreamRequest
from grabbergui.driver.twin.memory import access_of, failure_of
from grabbergui.driver.twin.report_file import MOST_ACCESSES, RecordedAccess

MOST_SILENCES = 4
"Reads in a row that time out, from which on the camera counts as gone: hundreds of them would take hours."


class RecordedDevice(Device):
    """Passes everything on to another device, and records its registers.

    At first each register is read once: whatever asks for it again gets the recorded answer, since reading
    may change it (a counter that clears itself, the next entry of a queue). After `follow` all accesses
    reach the device, and are recorded in their order.
    """

    def __init__(self, device: Device) -> None:
        super().__init__(device.info)
        self.device = device
        self.description_file = device.description_file
        self.chunk_layout, self.event_layout = device.chunk_layout, device.event_layout
        self.reads: dict[tuple[int, int], RecordedAccess] = {}
        "The first read of each address and length."
        self.accesses: list[RecordedAccess] = []
        "Since `follow`."
        self.described = b""
        "The description, once it was read."
        self.last: tuple[int, int] | None = None
        "Address and length of the last read that was asked for."
        self._following = False
        self._silences = 0
        self._guard = threading.RLock()

    def follow(self) -> None:
        """From now on pass on and record every access."""
        self._following = True

    @override
    def open(self, access: Access) -> Access:
        device = self.device
        device.on_lost, device.on_held, device.on_event = self.report_lost, self.on_held, self.on_event
        device.take_over, device.interrupted = self.take_over, False
        self.lost = ""
        granted = device.open(access)
        self.info = device.info
        self.chunk_layout, self.event_layout = device.chunk_layout, device.event_layout
        return granted

    @override
    def interrupt(self) -> None:
        super().interrupt()
        self.device.interrupt()

    @override
    def close(self) -> None:
        self.device.close()

    @override
    def read(self, address: int, length: int) -> bytes:
        with self._guard:
            self.last = (address, length)
            if not self._following:
                return self._read_once(address, length)
            return self._recorded(address, length, None)

    @override
    def write(self, address: int, data: bytes) -> None:
        with self._guard:
            self._recorded(address, len(data), data)

    @override
    def description(self) -> bytes:
        self.described = self.device.description()
        return self.described

    @override
    def use_description(self, xml: str) -> None:
        self.device.use_description(xml)

    @override
    def bootstrap_registers(self) -> list[tuple[str, int, int]]:
        return self.device.bootstrap_registers()

    @override
    def open_events(self) -> None:
        self.device.open_events()

    @override
    def open_stream(self, request: StreamRequest, deliver: Callable[[Frame], None]) -> None:
        self.device.open_stream(request, deliver)

    @override
    def close_stream(self) -> None:
        self.device.close_stream()

    @override
    def stream_statistics(self) -> StreamStatistics:
        return self.device.stream_statistics()

    @override
    def silence(self) -> str:
        return self.device.silence()

    def _read_once(self, address: int, length: int) -> bytes:
        known = self.reads.get((address, length)) or self._covering(address, length)
        if known is None:
            begin = time.perf_counter()
            try:
                data = self.device.read(address, length)
            except DeviceLostError:
                raise
            except GrabberError as error:
                self._silences = self._silences + 1 if isinstance(error, AckTimeoutError) else 0
                failed = access_of(address, length, _since(begin), error=error)
                self.reads[address, length] = failed
                if self._silences >= MOST_SILENCES:
                    raise DeviceLostError(f"the camera did not answer {self._silences} reads") from error
                raise
            self._silences = 0
            known = access_of(address, length, _since(begin), data=data)
            self.reads[address, length] = known
        if known.data is None:
            raise failure_of(known)
        return known.data[address - known.address :][:length]

    def _covering(self, address: int, length: int) -> RecordedAccess | None:
        """Return a recorded read that contains this range."""
        return next(
            (
                read
                for read in self.reads.values()
                if read.data is not None and read.address <= address and address + length <= read.end
            ),
            None,
        )

    def _recorded(self, address: int, length: int, data: bytes | None) -> bytes:
        """Read, or write `data`, and record it."""
        begin, error, written = time.perf_counter(), None, data is not None
        try:
            if data is None:
                data = self.device.read(address, length)
            else:
                self.device.write(address, data)
        except DeviceLostError:
            raise
        except GrabberError as failed:
            error = failed
            raise
        finally:
            if len(self.accesses) < MOST_ACCESSES and (data is not None or error is not None):
                self.accesses.append(
                    access_of(address, length, _since(begin), data=data, error=error, written=written)
                )
        return data


def _since(begin: float) -> float:
    """Return milliseconds."""
    return (time.perf_counter() - begin) * 1000
