"""The register memory of a twin: what a report recorded, over zeros, with the refusals of the original."""

from __future__ import annotations

import statistics
import threading
from collections.abc import Callable, Iterable

from grabbergui.core.errors import (
    AccessDeniedError,
    AckTimeoutError,
    DeviceStatusError,
    GrabberError,
    RemoteProtocolError,
    TransportError,
)
from grabbergui.driver.twin.report_file import LONGEST_READ, RecordedAccess

_PAGE = 256
"Bytes of memory that are allocated at once."
MOST_PAGES = 1 << 18
"64 MiB; a host that writes everywhere is refused more."
LONGEST_ANSWER_MS = 2000.0
"A slower answer of the original is imitated by one that takes as long as this."
INVALID_ADDRESS, NO_MEMORY = 0x8003, 0x8008
"GVCP's status codes, which GenCP shares: no such address; a local problem."

_KINDS: dict[str, type[GrabberError]] = {
    kind.__name__: kind for kind in (AckTimeoutError, AccessDeniedError, RemoteProtocolError, TransportError)
}


def failure_of(access: RecordedAccess) -> GrabberError:
    """Return the error of a failed access, to be raised again."""
    kind = _KINDS.get(access.failure)
    if kind is not None:
        return kind(access.message)
    return DeviceStatusError(access.message, access.status)


def access_of(
    address: int,
    length: int,
    milliseconds: float,
    *,
    data: bytes | None = None,
    error: GrabberError | None = None,
    written: bool = False,
) -> RecordedAccess:
    """Return the record of an access."""
    failure = "" if error is None else type(error).__name__
    status = error.status if isinstance(error, DeviceStatusError) else 0
    message = "" if error is None else str(error)
    return RecordedAccess(address, length, data, milliseconds, failure, status, message, written=written)


class TwinMemory:
    """Reads and writes of a recorded camera. Thread-safe.

    A read with the address and length of a recorded one gets the recorded answer, until something is written
    there; any other is made up of the recorded bytes, with zeros between them. A read that failed fails again
    with the same error. Everything may be written, except where a write was recorded as refused.
    """

    def __init__(self, recorded: Iterable[RecordedAccess], later: Iterable[RecordedAccess] = ()) -> None:
        """`later`: reads and writes during a stream, in their order."""
        self.on_written: Callable[[int, bytes], None] = lambda address, data: None
        "Called after each write, without the lock."
        self._lock = threading.Lock()
        self._pages: dict[int, bytearray] = {}
        self._exact: dict[tuple[int, int], RecordedAccess] = {}
        self._refused: list[RecordedAccess] = []
        "Reads that failed."
        self._refused_writes: dict[int, RecordedAccess] = {}
        self._kept: set[int] = set()
        "Addresses at which a written value was read back."
        self._commands: set[tuple[int, bytes]] = set()
        "Writes after which a register returns to its content."
        times = []
        for access in recorded:
            times.append(access.milliseconds)
            if access.data is None:
                self._refused.append(access)
            else:
                self._store(access.address, access.data)
            self._exact.setdefault((access.address, access.length), access)
        self._usual_ms = statistics.median(times) if times else 0.0
        self._learn(later)

    def restore_after(self, address: int, data: bytes) -> None:
        """Let a register return to its content after a command is written, unless the original's did not."""
        if address not in self._kept:
            self._commands.add((address, data))

    def answer_time(self, address: int, length: int) -> float:
        """Return the seconds that the original needed for this access, or for most."""
        access = self._exact.get((address, length))
        return min(access.milliseconds if access else self._usual_ms, LONGEST_ANSWER_MS) / 1000

    def read(self, address: int, length: int) -> bytes:
        """Return the bytes of a range. Raises what the original raised."""
        if length > LONGEST_READ:
            raise DeviceStatusError(f"{length} bytes are no register", INVALID_ADDRESS)
        with self._lock:
            exact = self._exact.get((address, length))
            if exact is not None:
                if exact.data is None:
                    raise failure_of(exact)
                return exact.data
            for access in self._refused:
                if access.address < address + length and address < access.end:
                    raise failure_of(access)
            return self._load(address, length)

    def write(self, address: int, data: bytes) -> None:
        """Store bytes. Raises DeviceStatusError where the original refused, or for more than fits."""
        refused = self._refused_writes.get(address)
        if refused is not None:
            raise failure_of(refused)
        with self._lock:
            if (address, data) not in self._commands:
                self._forget(address, len(data))
                self._store(address, data)
        self.on_written(address, data)

    def peek(self, address: int, length: int) -> bytes:
        """Return the bytes of a range, zeros where reading fails."""
        with self._lock:
            return self._load(address, length)

    def _learn(self, later: Iterable[RecordedAccess]) -> None:
        written: dict[tuple[int, int], bytes] = {}
        for access in later:
            place = (access.address, access.length)
            if access.written and access.failure:
                self._refused_writes[access.address] = access
            elif access.written and access.data is not None:
                written[place] = access.data
            elif place in written and access.data == written[place] and any(access.data):
                self._kept.add(access.address)

    def _forget(self, address: int, length: int) -> None:
        """Drop recorded answers about bytes that are about to change."""
        for place in [place for place in self._exact if _overlap(place, address, length)]:
            if self._exact[place].data is not None:
                del self._exact[place]

    def _load(self, address: int, length: int) -> bytes:
        content = bytearray(length)
        for page, start, at, count in _pieces(address, length):
            stored = self._pages.get(page)
            if stored is not None:
                content[at : at + count] = stored[start : start + count]
        return bytes(content)

    def _store(self, address: int, data: bytes) -> None:
        for page, start, at, count in _pieces(address, len(data)):
            stored = self._pages.get(page)
            if stored is None:
                if len(self._pages) >= MOST_PAGES:
                    raise DeviceStatusError("this simulated camera has no memory left", NO_MEMORY)
                stored = self._pages[page] = bytearray(_PAGE)
            stored[start : start + count] = data[at : at + count]


def _overlap(place: tuple[int, int], address: int, length: int) -> bool:
    return place[0] < address + length and address < place[0] + place[1]


def _pieces(address: int, length: int) -> Iterable[tuple[int, int, int, int]]:
    """Yield for each page: its number, the offset in it, the offset in the range, and the bytes."""
    at = 0
    while at < length:
        page, start = divmod(address + at, _PAGE)
        count = min(_PAGE - start, length - at)
        yield page, start, at, count
        at += count
