"""GenCP over USB3 Vision: commands, acknowledges and events.

One packet is one bulk transfer: a header of 12 bytes, then data, little-endian.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import IntEnum
from typing import ClassVar

from grabbergui.core.errors import LocalProtocolError, RemoteProtocolError

PREFIX = 0x43563355
"First four bytes of a command or acknowledge: `U3VC`."
EVENT_PREFIX = 0x45563355
"First four bytes of an event: `U3VE`."

FLAG_ACKNOWLEDGE = 0x4000
"Set in a command that requires an acknowledge."

HEADER_SIZE = 12
WRITE_OVERHEAD = HEADER_SIZE + 8
"Bytes of a WRITEMEM command before the data."
SMALLEST_ACKNOWLEDGE = HEADER_SIZE + 4
"Bytes of a PENDING acknowledge, for which a host always leaves room."
_READ = struct.Struct("<QHH")
_ADDRESS = struct.Struct("<Q")
_RESERVED_AND_VALUE = struct.Struct("<HH")


class CommandId(IntEnum):
    """Command id of a packet; an acknowledge has the id of its command plus one."""

    READMEM = 0x0800
    READMEM_ACK = 0x0801
    WRITEMEM = 0x0802
    WRITEMEM_ACK = 0x0803
    PENDING_ACK = 0x0805
    EVENT = 0x0C00


class Status(IntEnum):
    """Status codes of acknowledges and of stream trailers; bit 15 marks an error."""

    SUCCESS = 0x0000
    NOT_IMPLEMENTED = 0x8001
    INVALID_PARAMETER = 0x8002
    INVALID_ADDRESS = 0x8003
    WRITE_PROTECT = 0x8004
    BAD_ALIGNMENT = 0x8005
    ACCESS_DENIED = 0x8006
    BUSY = 0x8007
    MESSAGE_TIMEOUT = 0x800B
    INVALID_HEADER = 0x800E
    WRONG_CONFIGURATION = 0x800F
    GENERIC_ERROR = 0x8FFF
    RESEND_NOT_SUPPORTED = 0xA001
    STREAM_ENDPOINT_HALTED = 0xA002
    PAYLOAD_SIZE_NOT_ALIGNED = 0xA003
    STREAM_REGISTERS_INCONSISTENT = 0xA004
    EVENT_ENDPOINT_HALTED = 0xA005
    DATA_DISCARDED = 0xA100
    DATA_OVERRUN = 0xA101


def status_text(status: int) -> str:
    """Return a human-readable status: `0x8003 (invalid address)`."""
    try:
        return f"0x{status:04X} ({Status(status).name.lower().replace('_', ' ')})"
    except ValueError:
        kind = {0: "GenCP", 1: "USB3 Vision", 2: "vendor"}.get(status >> 13 & 3, "reserved")
        return f"0x{status:04X} (unknown {kind} status)"


@dataclass(frozen=True)
class Packet:
    """A command or an acknowledge; they differ in the meaning of `flags`."""

    HEADER: ClassVar[struct.Struct] = struct.Struct("<IHHHH")

    flags: int
    "Flags of a command, status of an acknowledge."
    command: int
    "A `CommandId`, or an unknown number."
    request_id: int
    "0..65535, chosen by the host and repeated by the device."
    data: bytes = b""

    @property
    def status(self) -> int:
        """An acknowledge's status code."""
        return self.flags

    def encode(self) -> bytes:
        """Return the whole transfer. Raises LocalProtocolError for values that do not fit the header."""
        try:
            header = self.HEADER.pack(PREFIX, self.flags, self.command, len(self.data), self.request_id)
        except struct.error as error:
            raise LocalProtocolError(f"GenCP packet does not fit its header: {error}") from error
        return header + self.data

    @classmethod
    def decode(cls, transfer: bytes) -> Packet:
        """Read one transfer. Raises RemoteProtocolError for a wrong length or prefix."""
        if len(transfer) < cls.HEADER.size:
            raise RemoteProtocolError(
                f"GenCP packet of {len(transfer)} bytes, a header has {cls.HEADER.size}"
            )
        prefix, flags, command, length, request_id = cls.HEADER.unpack_from(transfer)
        if prefix != PREFIX:
            raise RemoteProtocolError(f"GenCP packet begins with 0x{prefix:08X}, not 0x{PREFIX:08X}")
        if len(transfer) != cls.HEADER.size + length:
            raise RemoteProtocolError(
                f"GenCP packet announces {length} bytes of data and has {len(transfer) - cls.HEADER.size}"
            )
        return cls(flags, command, request_id, bytes(transfer[cls.HEADER.size :]))


def read_memory(address: int, length: int) -> bytes:
    """Encode the data of a READMEM command. Raises LocalProtocolError for values that do not fit."""
    try:
        return _READ.pack(address, 0, length)
    except struct.error as error:
        raise LocalProtocolError(f"READMEM of {length} bytes at 0x{address:X}: {error}") from error


def parse_read_memory(data: bytes) -> tuple[int, int]:
    """Decode a READMEM command's data to address and byte count. Raises RemoteProtocolError."""
    if len(data) != _READ.size:
        raise RemoteProtocolError(f"READMEM has {len(data)} bytes of data, not {_READ.size}")
    address, _, length = _READ.unpack(data)
    return address, length


def write_memory(address: int, data: bytes) -> bytes:
    """Encode the data of a WRITEMEM command. Raises LocalProtocolError for an address that does not fit."""
    try:
        return _ADDRESS.pack(address) + data
    except struct.error as error:
        raise LocalProtocolError(f"WRITEMEM at 0x{address:X}: {error}") from error


def parse_write_memory(data: bytes) -> tuple[int, bytes]:
    """Decode a WRITEMEM command's data to address and bytes. Raises RemoteProtocolError."""
    if len(data) <= _ADDRESS.size:
        raise RemoteProtocolError(f"WRITEMEM has {len(data)} bytes of data, nothing to write")
    return _ADDRESS.unpack_from(data)[0], data[_ADDRESS.size :]


def reserved_and_value(value: int) -> bytes:
    """Encode the data of a WRITEMEM acknowledge (bytes written) or a PENDING acknowledge (milliseconds)."""
    return _RESERVED_AND_VALUE.pack(0, value)


def parse_reserved_and_value(data: bytes) -> int:
    """Return the value of a WRITEMEM or PENDING acknowledge. Raises RemoteProtocolError."""
    if len(data) < _RESERVED_AND_VALUE.size:
        raise RemoteProtocolError(
            f"acknowledge has {len(data)} bytes of data, not {_RESERVED_AND_VALUE.size}"
        )
    value: int = _RESERVED_AND_VALUE.unpack_from(data)[1]
    return value


@dataclass(frozen=True)
class Event:
    """One event record."""

    RECORD: ClassVar[struct.Struct] = struct.Struct("<HHQ")

    event_id: int
    "The EventID of the device's description; 0x4FFF is the test event."
    timestamp: int
    "Device clock, nanoseconds."
    data: bytes = b""

    def encode(self, request_id: int, *, multi_event: bool = False) -> bytes:
        """Return a packet with this one event, in the form that GenApi's EventAdapterU3V needs."""
        size = self.RECORD.size + len(self.data)
        record = self.RECORD.pack(size if multi_event else 0, self.event_id, self.timestamp) + self.data
        return Packet.HEADER.pack(EVENT_PREFIX, 0, CommandId.EVENT, len(record), request_id) + record


def decode_events(transfer: bytes) -> list[Event]:
    """Return the events of one transfer: one, or several where multi-event is enabled.

    Raises RemoteProtocolError, for the whole packet, if lengths contradict each other.
    """
    if len(transfer) < HEADER_SIZE:
        raise RemoteProtocolError(f"event packet of {len(transfer)} bytes, a header has {HEADER_SIZE}")
    prefix, _, command, length, _ = Packet.HEADER.unpack_from(transfer)
    if prefix != EVENT_PREFIX or command != CommandId.EVENT:
        raise RemoteProtocolError(f"not an event packet: prefix 0x{prefix:08X}, command 0x{command:04X}")
    if len(transfer) != HEADER_SIZE + length:
        raise RemoteProtocolError(
            f"event packet announces {length} bytes and has {len(transfer) - HEADER_SIZE}"
        )
    events = []
    position = HEADER_SIZE
    while position < len(transfer):
        left = len(transfer) - position
        if left < Event.RECORD.size:
            raise RemoteProtocolError(f"event record of {left} bytes, need {Event.RECORD.size}")
        size, event_id, timestamp = Event.RECORD.unpack_from(transfer, position)
        size = size or left  # zero in single-event mode: the rest
        if not Event.RECORD.size <= size <= left:
            raise RemoteProtocolError(f"event record announces {size} bytes; {left} are left")
        data = bytes(transfer[position + Event.RECORD.size : position + size])
        events.append(Event(event_id, timestamp, data))
        position += size
    return events
