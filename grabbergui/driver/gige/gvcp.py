"""GVCP, the control protocol of GigE Vision: commands, acknowledges, registers and memory.

Encodes and decodes both directions, for the host and the simulated camera. Integers are big-endian. No I/O.
`gvcp_messages` has DISCOVERY, FORCEIP, events and actions.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import IntEnum
from typing import ClassVar, NamedTuple

from grabbergui.core.errors import LocalProtocolError, RemoteProtocolError

KEY = 0x42
"First byte of every command."

MAX_PAYLOAD = 540
"Payload bytes of the largest message: a datagram of 576 bytes less its IP, UDP and GVCP headers."
MAX_MEMORY = 536
"Bytes that one READMEM or WRITEMEM may carry."
MEMORY_CHUNK = 512
"Bytes of one request of ours. Other hosts use the same size, so every device supports it."
MAX_READS = 135
"Registers in one READREG."
MAX_WRITES = 67
"Registers in one WRITEREG."

FLAG_ACK_REQUIRED = 0x01
FLAG_BROADCAST_ACK = 0x10
"On DISCOVERY and FORCEIP: the acknowledge may be broadcast."
FLAG_EXTENDED_IDS = 0x10
"On PACKETRESEND and events: block ids of 64 bits."
FLAG_SCHEDULED = 0x80
"On ACTION: a time follows."
PENDING_ACK = 0x0089
DEVICE_SPECIFIC = 0x4000
"Bit of status codes that the maker of the device defines (GVCP, GVSP and GenCP)."
_ACK_HEADER = struct.Struct(">HHHH")


class CommandCode(IntEnum):
    """Code of a command. Its acknowledge has the next higher value."""

    DISCOVERY = 0x0002
    FORCEIP = 0x0004
    PACKETRESEND = 0x0040
    READREG = 0x0080
    WRITEREG = 0x0082
    READMEM = 0x0084
    WRITEMEM = 0x0086
    EVENT = 0x00C0
    EVENTDATA = 0x00C2
    ACTION = 0x0100


class Status(IntEnum):
    """Status codes of GVCP acknowledges and GVSP packets."""

    SUCCESS = 0x0000
    PACKET_RESEND = 0x0100
    NOT_IMPLEMENTED = 0x8001
    INVALID_PARAMETER = 0x8002
    INVALID_ADDRESS = 0x8003
    WRITE_PROTECT = 0x8004
    BAD_ALIGNMENT = 0x8005
    ACCESS_DENIED = 0x8006
    BUSY = 0x8007
    LOCAL_PROBLEM = 0x8008
    MSG_MISMATCH = 0x8009
    INVALID_PROTOCOL = 0x800A
    NO_MSG = 0x800B
    PACKET_UNAVAILABLE = 0x800C
    DATA_OVERRUN = 0x800D
    INVALID_HEADER = 0x800E
    WRONG_CONFIG = 0x800F
    PACKET_NOT_YET_AVAILABLE = 0x8010
    PACKET_AND_PREVIOUS_REMOVED = 0x8011
    PACKET_REMOVED = 0x8012
    NO_REF_TIME = 0x8013
    PACKET_TEMPORARILY_UNAVAILABLE = 0x8014
    OVERFLOW = 0x8015
    ACTION_LATE = 0x8016
    LEADER_TRAILER_OVERFLOW = 0x8017
    ERROR = 0x8FFF


def status_text(status: int) -> str:
    """Return a status as display text: `ACCESS_DENIED (0x8006)`, or of a maker's own."""
    try:
        return f"{Status(status).name} (0x{status:04X})"
    except ValueError:
        if status & DEVICE_SPECIFIC:
            return f"status 0x{status:04X}, which its maker defines (see the camera's manual)"
        return f"status 0x{status:04X}, which this program does not know"


@dataclass(frozen=True)
class CommandHeader:
    """First eight bytes of a command."""

    FORMAT: ClassVar[struct.Struct] = struct.Struct(">BBHHH")

    flags: int
    command: int
    req_id: int
    "1..65535; repeated unchanged in a retry."

    @classmethod
    def decode(cls, datagram: bytes) -> CommandHeader:
        """Read and check a header. Raises RemoteProtocolError."""
        if len(datagram) < cls.FORMAT.size:
            raise RemoteProtocolError(f"GVCP command of {len(datagram)} bytes, need {cls.FORMAT.size}")
        key, flags, command, length, req_id = cls.FORMAT.unpack_from(datagram)
        if key != KEY:
            raise RemoteProtocolError(f"GVCP command begins with 0x{key:02X} instead of 0x{KEY:02X}")
        if length != len(datagram) - cls.FORMAT.size:
            raise RemoteProtocolError(
                f"GVCP command announces {length} bytes, {len(datagram) - cls.FORMAT.size} arrived"
            )
        if req_id == 0:
            raise RemoteProtocolError("GVCP command with req_id 0")
        return cls(flags, command, req_id)


class Ack(NamedTuple):
    """An acknowledge with its payload still encoded."""

    status: int
    acknowledge: int
    "Code of the command plus one, or `PENDING_ACK`."
    ack_id: int
    "The `req_id` being answered."
    payload: bytes = b""

    @property
    def failed(self) -> bool:
        """Whether the device refused; the payload is then meaningless."""
        return bool(self.status & 0x8000)

    def encode(self) -> bytes:
        """Return the datagram."""
        header = _ACK_HEADER.pack(self.status, self.acknowledge, len(self.payload), self.ack_id)
        return header + self.payload

    @classmethod
    def decode(cls, datagram: bytes) -> Ack:
        """Read an acknowledge. Raises RemoteProtocolError.

        Bytes beyond the announced length are cut off; an error's payload may have any length.
        """
        if len(datagram) < _ACK_HEADER.size:
            raise RemoteProtocolError(f"GVCP acknowledge of {len(datagram)} bytes, need {_ACK_HEADER.size}")
        status, acknowledge, length, ack_id = _ACK_HEADER.unpack_from(datagram)
        payload = bytes(datagram[_ACK_HEADER.size : _ACK_HEADER.size + length])
        if len(payload) < length and not status & 0x8000:
            raise RemoteProtocolError(f"GVCP acknowledge announces {length} bytes, {len(payload)} arrived")
        return cls(status, acknowledge, ack_id, payload)


def encode_command(
    command: CommandCode, payload: bytes, req_id: int, flags: int = FLAG_ACK_REQUIRED
) -> bytes:
    """Return the datagram of a command. Raises LocalProtocolError for values that cannot be encoded."""
    if not 1 <= req_id <= 0xFFFF:
        raise LocalProtocolError(f"req_id {req_id} is not in 1 … 65535")
    if len(payload) > MAX_PAYLOAD:
        raise LocalProtocolError(f"GVCP payload of {len(payload)} bytes, at most {MAX_PAYLOAD} fit")
    return CommandHeader.FORMAT.pack(KEY, flags, command, len(payload), req_id) + payload


def split_command(datagram: bytes) -> tuple[CommandHeader, bytes]:
    """Return header and payload of a command. Raises RemoteProtocolError."""
    return CommandHeader.decode(datagram), bytes(datagram[CommandHeader.FORMAT.size :])


def _words(payload: bytes, what: str) -> tuple[int, ...]:
    if not payload or len(payload) % 4:
        raise RemoteProtocolError(f"{what} of {len(payload)} bytes, need a multiple of 4")
    return struct.unpack(f">{len(payload) // 4}I", payload)


def _check_alignment(address: int, length: int) -> None:
    if address % 4 or not 0 <= address <= 0xFFFFFFFC:
        raise LocalProtocolError(f"GVCP address 0x{address:X} is no multiple of 4 below 2^32")
    if length % 4 or not 4 <= length <= MAX_MEMORY:
        raise LocalProtocolError(f"{length} bytes of memory: need a multiple of 4 in 4 … {MAX_MEMORY}")


@dataclass(frozen=True)
class ReadReg:
    """READREG_CMD: the values of some registers."""

    CODE: ClassVar[CommandCode] = CommandCode.READREG

    addresses: tuple[int, ...]

    def payload(self) -> bytes:
        """Return the command's payload."""
        if not 1 <= len(self.addresses) <= MAX_READS:
            raise LocalProtocolError(f"READREG of {len(self.addresses)} registers, 1 … {MAX_READS} fit")
        return struct.pack(f">{len(self.addresses)}I", *self.addresses)

    @classmethod
    def decode(cls, payload: bytes) -> ReadReg:
        """Read the command. Raises RemoteProtocolError."""
        return cls(_words(payload, "READREG"))

    def decode_ack(self, payload: bytes) -> tuple[int, ...]:
        """Return the values. Raises RemoteProtocolError unless there are as many as requested."""
        values = _words(payload, "READREG_ACK")
        if len(values) != len(self.addresses):
            raise RemoteProtocolError(
                f"READREG_ACK of {len(values)} registers, {len(self.addresses)} were requested"
            )
        return values


@dataclass(frozen=True)
class WriteReg:
    """WRITEREG_CMD: (address, value) pairs, written in order."""

    CODE: ClassVar[CommandCode] = CommandCode.WRITEREG

    writes: tuple[tuple[int, int], ...]

    def payload(self) -> bytes:
        """Return the command's payload."""
        if not 1 <= len(self.writes) <= MAX_WRITES:
            raise LocalProtocolError(f"WRITEREG of {len(self.writes)} registers, 1 … {MAX_WRITES} fit")
        return b"".join(struct.pack(">II", address, value) for address, value in self.writes)

    @classmethod
    def decode(cls, payload: bytes) -> WriteReg:
        """Read the command. Raises RemoteProtocolError."""
        words = _words(payload, "WRITEREG")
        if len(words) % 2:
            raise RemoteProtocolError(f"WRITEREG of {len(payload)} bytes, need a multiple of 8")
        return cls(tuple(zip(words[::2], words[1::2], strict=True)))


def encode_write_ack(index: int) -> bytes:
    """Return the payload of WRITEREG_ACK (registers written) or WRITEMEM_ACK (bytes written).

    Devices disagree on the number, so hosts check only the status.
    """
    return struct.pack(">HH", 0, index)


@dataclass(frozen=True)
class ReadMem:
    """READMEM_CMD: bytes of memory; address and count are multiples of 4."""

    CODE: ClassVar[CommandCode] = CommandCode.READMEM
    FORMAT: ClassVar[struct.Struct] = struct.Struct(">IHH")

    address: int
    count: int

    def payload(self) -> bytes:
        """Return the command's payload."""
        _check_alignment(self.address, self.count)
        return self.FORMAT.pack(self.address, 0, self.count)

    @classmethod
    def decode(cls, payload: bytes) -> ReadMem:
        """Read the command. Raises RemoteProtocolError for its length only."""
        if len(payload) != cls.FORMAT.size:
            raise RemoteProtocolError(f"READMEM of {len(payload)} bytes, need {cls.FORMAT.size}")
        address, _, count = cls.FORMAT.unpack(payload)
        return cls(address, count)

    @staticmethod
    def encode_ack(address: int, data: bytes) -> bytes:
        """Return the acknowledge's payload."""
        return struct.pack(">I", address) + data

    def decode_ack(self, payload: bytes) -> bytes:
        """Return the bytes read. Raises RemoteProtocolError."""
        if len(payload) < 4:
            raise RemoteProtocolError(f"READMEM_ACK of {len(payload)} bytes has no address")
        (address,) = struct.unpack_from(">I", payload)
        if address != self.address or len(payload) - 4 != self.count:
            raise RemoteProtocolError(
                f"READMEM_ACK of {len(payload) - 4} bytes at 0x{address:X},"
                f" {self.count} at 0x{self.address:X} were requested"
            )
        return payload[4:]


@dataclass(frozen=True)
class WriteMem:
    """WRITEMEM_CMD: address and length are multiples of 4."""

    CODE: ClassVar[CommandCode] = CommandCode.WRITEMEM

    address: int
    data: bytes

    def payload(self) -> bytes:
        """Return the command's payload."""
        _check_alignment(self.address, len(self.data))
        return struct.pack(">I", self.address) + self.data

    @classmethod
    def decode(cls, payload: bytes) -> WriteMem:
        """Read the command. Raises RemoteProtocolError."""
        if len(payload) < 8:
            raise RemoteProtocolError(f"WRITEMEM of {len(payload)} bytes writes nothing")
        return cls(struct.unpack_from(">I", payload)[0], payload[4:])


@dataclass(frozen=True)
class PacketResend:
    """PACKETRESEND_CMD: requests packets of a block again. It is never acknowledged."""

    CODE: ClassVar[CommandCode] = CommandCode.PACKETRESEND
    STANDARD: ClassVar[struct.Struct] = struct.Struct(">HHII")
    EXTENDED: ClassVar[struct.Struct] = struct.Struct(">HHIIQ")
    TO_THE_END: ClassVar[int] = 0xFFFFFF
    "Value of `last` with standard ids for all packets up to the trailer."

    block_id: int
    first: int
    last: int
    "Inclusive."
    channel: int = 0
    extended: bool = False

    @property
    def flags(self) -> int:
        """Flags of the command."""
        return FLAG_EXTENDED_IDS if self.extended else 0

    def payload(self) -> bytes:
        """Return the command's payload."""
        if self.extended:
            return self.EXTENDED.pack(self.channel, 0, self.first, self.last, self.block_id)
        return self.STANDARD.pack(self.channel, self.block_id, self.first & 0xFFFFFF, self.last & 0xFFFFFF)

    def encode(self, req_id: int) -> bytes:
        """Return the datagram, to be sent from the stream socket."""
        return encode_command(self.CODE, self.payload(), req_id, self.flags)

    @classmethod
    def decode(cls, payload: bytes, flags: int) -> PacketResend:
        """Read the command. Raises RemoteProtocolError."""
        extended = bool(flags & FLAG_EXTENDED_IDS)
        layout = cls.EXTENDED if extended else cls.STANDARD
        if len(payload) != layout.size:
            raise RemoteProtocolError(f"PACKETRESEND of {len(payload)} bytes, need {layout.size}")
        if extended:
            channel, _, first, last, block_id = layout.unpack(payload)
        else:
            channel, block_id, first, last = layout.unpack(payload)
            first, last = first & 0xFFFFFF, last & 0xFFFFFF
        return cls(block_id, first, last, channel, extended)


def encode_pending_ack(milliseconds: int, ack_id: int) -> bytes:
    """Return the datagram that announces how long an acknowledge will take."""
    return Ack(Status.SUCCESS, PENDING_ACK, ack_id, struct.pack(">HH", 0, milliseconds)).encode()


def decode_pending_ack(payload: bytes) -> float:
    """Return the seconds until the final acknowledge. Raises RemoteProtocolError."""
    if len(payload) != 4:
        raise RemoteProtocolError(f"PENDING_ACK of {len(payload)} bytes, need 4")
    return float(struct.unpack(">HH", payload)[1]) / 1000


Request = ReadReg | WriteReg | ReadMem | WriteMem
"""Commands of a control channel."""
