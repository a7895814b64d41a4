"""Leader, trailer, and the division of a payload into bulk transfers. Little-endian."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import IntEnum
from typing import ClassVar

from grabbergui.core.errors import RemoteProtocolError
from grabbergui.driver.u3v.bootstrap import Sirm, StreamRequirements

LEADER_PREFIX = 0x4C563355
"`U3VL`."
TRAILER_PREFIX = 0x54563355
"`U3VT`."

SMALLEST_LEADER = 28
IMAGE_LEADER_SIZE = 52
SMALLEST_TRAILER = 28
EXTENDED_CHUNK_TRAILER_SIZE = 36

USUAL_LEADER_SPACE = 1024
"Leader or trailer size for a device that reports 0."
LARGEST_PAYLOAD = 1 << 29
"Bytes; more is a faulty register, not an image."
LARGEST_LEADER = 1 << 20
"Bytes of a leader or trailer, likewise."


class U3vPayloadType(IntEnum):
    """Payload type of a block; bit 14 marks chunk data."""

    IMAGE = 0x0001
    GENDC_CONTAINER = 0x1001
    GENDC_COMPONENT = 0x1002
    CHUNK = 0x4000
    IMAGE_EXTENDED_CHUNK = 0x4001


_WITH_GEOMETRY = (U3vPayloadType.IMAGE, U3vPayloadType.IMAGE_EXTENDED_CHUNK)


@dataclass(frozen=True)
class Leader:
    """First transfer of a block."""

    GENERIC: ClassVar[struct.Struct] = struct.Struct("<IHHQHHQ")
    IMAGE: ClassVar[struct.Struct] = struct.Struct("<IIIIIHH")

    block_id: int
    payload_type: int
    "A `U3vPayloadType`, or an unknown number."
    timestamp: int
    "Nanoseconds of the device's clock."
    pixel_format: int = 0
    "PFNC code; this and the following fields only if `has_geometry`."
    size_x: int = 0
    size_y: int = 0
    "The largest height; the trailer has the actual one."
    offset_x: int = 0
    offset_y: int = 0
    padding_x: int = 0
    "Bytes at the end of each line."

    @property
    def has_geometry(self) -> bool:
        """Whether the leader has the fields of an image."""
        return self.payload_type in _WITH_GEOMETRY

    def encode(self, size: int = 0) -> bytes:
        """Return the leader, padded with zeros to `size`."""
        length = IMAGE_LEADER_SIZE if self.has_geometry else SMALLEST_LEADER
        data = self.GENERIC.pack(
            LEADER_PREFIX, 0, length, self.block_id, 0, self.payload_type, self.timestamp
        )
        if self.has_geometry:
            data += self.IMAGE.pack(
                self.pixel_format, self.size_x, self.size_y, self.offset_x, self.offset_y, self.padding_x, 0
            )
        return data.ljust(size, b"\0")

    @classmethod
    def decode(cls, data: bytes) -> Leader:
        """Read a leader; trailing bytes are ignored. Raises RemoteProtocolError."""
        if len(data) < cls.GENERIC.size:
            raise RemoteProtocolError(f"leader of {len(data)} bytes, need {cls.GENERIC.size}")
        prefix, _, _, block_id, _, payload_type, timestamp = cls.GENERIC.unpack_from(data)
        if prefix != LEADER_PREFIX:
            raise RemoteProtocolError(f"leader begins with 0x{prefix:08X}, not 0x{LEADER_PREFIX:08X}")
        if payload_type not in _WITH_GEOMETRY:
            return cls(block_id, payload_type, timestamp)
        if len(data) < IMAGE_LEADER_SIZE:
            raise RemoteProtocolError(f"image leader of {len(data)} bytes, need {IMAGE_LEADER_SIZE}")
        *geometry, _ = cls.IMAGE.unpack_from(data, cls.GENERIC.size)
        return cls(block_id, payload_type, timestamp, *geometry)


@dataclass(frozen=True)
class Trailer:
    """Last transfer of a block."""

    GENERIC: ClassVar[struct.Struct] = struct.Struct("<IHHQHHQ")

    block_id: int
    status: int
    "0, or a `gencp.Status` like DATA_DISCARDED."
    valid_payload_size: int
    "Bytes of the payload that are valid."
    size_y: int | None = None
    "The actual height; None if the trailer is too short for it."
    chunk_layout_id: int = 0

    def encode(self, payload_type: int, size: int = 0) -> bytes:
        """Return the trailer of a block of this type, padded with zeros to `size`."""
        fields = [self.chunk_layout_id] if payload_type == U3vPayloadType.CHUNK else [self.size_y or 0]
        if payload_type == U3vPayloadType.IMAGE_EXTENDED_CHUNK:
            fields.append(self.chunk_layout_id)
        length = SMALLEST_TRAILER + 4 * len(fields)
        head = self.GENERIC.pack(
            TRAILER_PREFIX, 0, length, self.block_id, self.status, 0, self.valid_payload_size
        )
        return (head + struct.pack(f"<{len(fields)}I", *fields)).ljust(size, b"\0")

    @classmethod
    def decode(cls, data: bytes, payload_type: int) -> Trailer:
        """Read the trailer of a block of this type. Raises RemoteProtocolError."""
        if len(data) < cls.GENERIC.size:
            raise RemoteProtocolError(f"trailer of {len(data)} bytes, need {cls.GENERIC.size}")
        prefix, _, _, block_id, status, _, valid = cls.GENERIC.unpack_from(data)
        if prefix != TRAILER_PREFIX:
            raise RemoteProtocolError(f"trailer begins with 0x{prefix:08X}, not 0x{TRAILER_PREFIX:08X}")
        rest = [int.from_bytes(data[at : at + 4], "little") for at in (28, 32) if len(data) >= at + 4]
        if payload_type == U3vPayloadType.CHUNK:
            return cls(block_id, status, valid, None, rest[0] if rest else 0)
        has_layout = payload_type == U3vPayloadType.IMAGE_EXTENDED_CHUNK and len(rest) == 2
        return cls(block_id, status, valid, rest[0] if rest else None, rest[1] if has_layout else 0)


def is_leader(data: bytes) -> bool:
    """Return whether a transfer begins like a leader."""
    return len(data) >= SMALLEST_LEADER and data[:4] == LEADER_PREFIX.to_bytes(4, "little")


def is_trailer(data: bytes) -> bool:
    """Return whether a transfer begins like a trailer."""
    return len(data) >= SMALLEST_TRAILER and data[:4] == TRAILER_PREFIX.to_bytes(4, "little")


def round_up(value: int, unit: int) -> int:
    """Return the next multiple of `unit`."""
    return -(-value // unit) * unit


@dataclass(frozen=True)
class TransferPlan:
    """The transfers of every block, as written into SIRM 0x18 to 0x2F."""

    FORMAT: ClassVar[struct.Struct] = struct.Struct("<IIIIII")
    ADDRESS: ClassVar[int] = Sirm.MAXIMUM_LEADER_SIZE

    leader_size: int
    "Largest size of the leader in bytes."
    transfer_size: int
    "Bytes of each full payload transfer."
    transfer_count: int
    final_1: int
    "Bytes of the transfer after the full ones; 0: none."
    final_2: int
    trailer_size: int

    @property
    def payload_sizes(self) -> list[int]:
        """Bytes of each payload transfer, in order."""
        finals = [size for size in (self.final_1, self.final_2) if size]
        return [self.transfer_size] * self.transfer_count + finals

    @property
    def payload_space(self) -> int:
        """Bytes of all payload transfers together."""
        return self.transfer_size * self.transfer_count + self.final_1 + self.final_2

    def encode(self) -> bytes:
        """Return the six registers, 24 bytes."""
        return self.FORMAT.pack(
            self.leader_size,
            self.transfer_size,
            self.transfer_count,
            self.final_1,
            self.final_2,
            self.trailer_size,
        )

    @classmethod
    def decode(cls, data: bytes) -> TransferPlan:
        """Read the six registers. Raises RemoteProtocolError if they are incomplete."""
        if len(data) < cls.FORMAT.size:
            raise RemoteProtocolError(f"stream registers of {len(data)} bytes, need {cls.FORMAT.size}")
        return cls(*cls.FORMAT.unpack_from(data))

    @classmethod
    def for_device(
        cls, needs: StreamRequirements, largest_transfer: int, packet_size: int = 1024
    ) -> TransferPlan:
        """Return the plan for a device's requirements, in transfers of at most `largest_transfer` bytes.

        Full transfers are multiples of the alignment and of USB's packet; the rest is one transfer, rounded
        up to the alignment. Raises RemoteProtocolError for an impossible size.
        """
        payload = needs.payload_size
        if not 0 < payload <= LARGEST_PAYLOAD:
            raise RemoteProtocolError(
                f"the device announces a payload of {payload} bytes; 1 to {LARGEST_PAYLOAD} make sense"
            )
        if max(needs.leader_size, needs.trailer_size) > LARGEST_LEADER:
            raise RemoteProtocolError(
                f"the device announces a leader of {needs.leader_size} bytes and a trailer of"
                f" {needs.trailer_size}; at most {LARGEST_LEADER} make sense"
            )
        unit = max(needs.alignment, packet_size)
        size = max(largest_transfer // unit * unit, unit)
        # At least one full transfer if the payload fills it, because cameras expect that.
        size = max(min(size, payload // unit * unit), unit)
        count, rest = divmod(payload, size)
        return cls(
            leader_size=round_up(needs.leader_size or USUAL_LEADER_SPACE, needs.alignment),
            transfer_size=size,
            transfer_count=count,
            final_1=round_up(rest, needs.alignment),
            final_2=0,
            trailer_size=round_up(needs.trailer_size or USUAL_LEADER_SPACE, needs.alignment),
        )
