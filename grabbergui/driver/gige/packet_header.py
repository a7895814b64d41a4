"""The header of a GVSP packet: one layout for a single packet, for arrays of them, and for the kernel.

It has 8 bytes, or 20 with 64-bit block ids (GigE Vision 2.2, "GVSP Packet Header"). Integers are big-endian.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import IntEnum
from typing import Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.errors import RemoteProtocolError
from grabbergui.driver.gige.gvcp import Status

STANDARD: Final = np.dtype([("status", ">u2"), ("block_id", ">u2"), ("format_and_packet_id", ">u4")])
"The format is in the upper eight bits."
EXTENDED: Final = np.dtype(
    [
        ("status", ">u2"),
        ("flags", ">u2"),
        ("format_and_parts", ">u4"),
        ("block_id", ">u8"),
        ("packet_id", ">u4"),
    ]
)
"The format, with `EXTENDED_BIT`, is in the upper eight bits, the number of parts in the lower eight."
EXTENDED_BIT = 0x80
"In the format: 64-bit block ids and a header of 20 bytes."
PACKET_ID_MASK = 0xFFFFFF
"In the last word of a standard header."
FLAG_RESEND = 0x1
"In the flags of an extended header."
# The first eight bytes of either header, as one number: status, then block id or flags, then the format.
_FIRST_WORD = np.dtype(">u8")
_ID_BITS = np.uint64(24)
_ID_MASK = np.uint64(PACKET_ID_MASK)
_EXTENDED_WORD = np.uint64(EXTENDED_BIT << 24)
_RESENT = np.uint64(Status.PACKET_RESEND << 48)
"Status of a resent packet in a standard header."
_EXTENDED_RESENT = np.uint64(Status.PACKET_RESEND << 48 | FLAG_RESEND << 32)
"Status of a resent packet in an extended header, or its resend flag."


def offset_of(layout: np.dtype[np.void], field: str) -> int:
    """Return at which byte of a header a field begins."""
    assert layout.fields is not None
    return layout.fields[field][1]


def _struct_of(layout: np.dtype[np.void]) -> struct.Struct:
    """Return the same layout for single headers, which `struct` reads several times faster."""
    assert layout.names is not None
    return struct.Struct(
        ">" + "".join("BHIQ"[layout[name].itemsize.bit_length() - 1] for name in layout.names)
    )


class PacketFormat(IntEnum):
    """Content of a packet."""

    LEADER = 1
    TRAILER = 2
    PAYLOAD = 3
    ALL_IN = 4
    H264 = 5
    MULTI_ZONE = 6
    MULTI_PART = 7
    GENDC = 8


@dataclass(frozen=True)
class PacketHeader:
    """The first 8 or 20 bytes of a stream packet."""

    STANDARD: ClassVar[struct.Struct] = _struct_of(STANDARD)
    EXTENDED: ClassVar[struct.Struct] = _struct_of(EXTENDED)

    format: int
    "A `PacketFormat`, or a number that is none."
    block_id: int
    "1..65535, or 64 bits; 0 is a test packet."
    packet_id: int
    status: int = 0
    extended: bool = False
    flags: int = 0
    parts: int = 0
    "Number of parts, in the leader of a multi-part block."

    @property
    def size(self) -> int:
        """Bytes of the header."""
        return self.EXTENDED.size if self.extended else self.STANDARD.size

    @property
    def failed(self) -> bool:
        """Whether the packet only reports a status and has no data."""
        return bool(self.status & 0x8000)

    @property
    def sent_again(self) -> bool:
        """Whether the device flags the packet as resent."""
        return bool(self.flags & FLAG_RESEND) or self.status == Status.PACKET_RESEND

    def encode(self) -> bytes:
        """Return the header's bytes."""
        if self.extended:
            word = (self.format | EXTENDED_BIT) << 24 | self.parts
            return self.EXTENDED.pack(self.status, self.flags, word, self.block_id, self.packet_id)
        return self.STANDARD.pack(self.status, self.block_id, self.format << 24 | self.packet_id)

    @classmethod
    def decode(cls, datagram: bytes | memoryview) -> PacketHeader:
        """Read the header only. Raises RemoteProtocolError."""
        if len(datagram) < cls.STANDARD.size:
            raise RemoteProtocolError(f"GVSP packet of {len(datagram)} bytes, need {cls.STANDARD.size}")
        status, block_id, word = cls.STANDARD.unpack_from(datagram)
        if not word >> 24 & EXTENDED_BIT:
            return cls(word >> 24, block_id, word & PACKET_ID_MASK, status)
        if len(datagram) < cls.EXTENDED.size:
            raise RemoteProtocolError(
                f"GVSP packet with extended ids of {len(datagram)} bytes, need {cls.EXTENDED.size}"
            )
        status, flags, word, block_id, packet_id = cls.EXTENDED.unpack_from(datagram)
        return cls(word >> 24 & ~EXTENDED_BIT, block_id, packet_id, status, True, flags, word & 0xFF)


def count_in_order(rows: NDArray[np.uint8]) -> int:
    """Return how many packets, from the first on, are consecutive and not resent: on a good network all.

    The `rows` (n, length) begin with a standard header at least.
    """
    words = _first_words(rows)
    extended = bool(words[0] & _EXTENDED_WORD)
    if words[0] & (_EXTENDED_RESENT if extended else _RESENT):
        return 0
    if not extended:
        breaks = words[1:] - words[:-1] != 1
    elif rows.shape[1] >= EXTENDED.itemsize:
        breaks = words[1:] != words[:-1]
        breaks |= np.diff(_field(rows, "block_id")) != 0
        breaks |= np.diff(_field(rows, "packet_id")) != 1
    else:
        return 0
    return int(breaks.argmax()) + 1 if breaks.any() else len(rows)


def decode_rows(rows: NDArray[np.uint8]) -> tuple[NDArray[np.intp], NDArray[np.bool_], NDArray[np.bool_]]:
    """Return the packet ids of rows as in `count_in_order`, which are resent, and where others begin.

    The last array is one shorter: whether a row differs from the one before in more than these two.
    """
    words = _first_words(rows)
    extended = (words & _EXTENDED_WORD).astype(bool)
    some = bool(extended.any())
    flags = words & (np.where(extended, _EXTENDED_RESENT, _RESENT) if some else _RESENT)
    kinds = (words ^ flags) >> _ID_BITS
    differs = kinds[1:] != kinds[:-1]
    numbers = words & _ID_MASK
    if some and rows.shape[1] < EXTENDED.itemsize:
        differs |= extended[1:]
    elif some:
        numbers = np.where(extended, _field(rows, "packet_id"), numbers)
        differs |= extended[1:] & (np.diff(_field(rows, "block_id")) != 0)
    return numbers.astype(np.intp), flags.astype(bool), differs


def _first_words(rows: NDArray[np.uint8]) -> NDArray[np.uint64]:
    return rows[:, : _FIRST_WORD.itemsize].view(_FIRST_WORD)[:, 0].astype(np.uint64)


def _field(rows: NDArray[np.uint8], name: str) -> NDArray[np.uint64]:
    """Return a field of each row's extended header."""
    numbers: NDArray[Any] = rows[:, : EXTENDED.itemsize].view(EXTENDED)[:, 0][name]
    return numbers.astype(np.uint64)
