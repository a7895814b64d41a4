"""GVSP, the stream protocol of GigE Vision: packet headers, leaders and trailers.

A block (one frame) is a leader, payload packets and a trailer, numbered by packet_id from 0. All integers
are big-endian. Nothing here touches a socket; `stream.assembler` puts packets together.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property
from typing import ClassVar

from grabbergui.core.errors import RemoteProtocolError
from grabbergui.driver.gige.gvcp import Status

IP_UDP_BYTES = 28
"IP and UDP headers, which SCPS counts too."
EXTENDED_BIT = 0x80
"In the format byte: 64-bit block ids and a header of 20 bytes."
CHUNK_BIT = 0x4000
"In the payload type: chunks are appended."
FLAG_RESEND = 0x1
"In the flags of an extended header."


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


class PayloadKind(IntEnum):
    """Content of a block, apart from chunks."""

    IMAGE = 1
    RAW = 2
    FILE = 3
    CHUNK = 4
    EXTENDED_CHUNK = 5
    JPEG = 6
    JPEG2000 = 7
    H264 = 8
    MULTI_ZONE = 9
    MULTI_PART = 10
    GENDC = 11


_KIND_NAMES: dict[int, str] = {
    PayloadKind.IMAGE: "an image without size or pixel format",
    PayloadKind.RAW: "raw data",
    PayloadKind.FILE: "a file",
    PayloadKind.CHUNK: "chunk data without an image",
    PayloadKind.EXTENDED_CHUNK: "extended chunk data without an image",
    PayloadKind.JPEG: "JPEG images",
    PayloadKind.JPEG2000: "JPEG 2000 images",
    PayloadKind.H264: "H.264 video",
    PayloadKind.MULTI_ZONE: "a multi-zone image without size or pixel format",
    PayloadKind.MULTI_PART: "multi-part data without an image",
    PayloadKind.GENDC: "a GenDC container",
}


@dataclass(frozen=True)
class PacketHeader:
    """The first 8 or 20 bytes of a stream packet."""

    STANDARD: ClassVar[struct.Struct] = struct.Struct(">HHI")
    EXTENDED: ClassVar[struct.Struct] = struct.Struct(">HHB2xBQI")

    format: int
    "A `PacketFormat`, or a number that is none."
    block_id: int
    "1..65535, or 64 bits; 0 is a test packet."
    packet_id: int
    status: int = 0
    extended: bool = False
    flags: int = 0
    parts: int = 0
    "Of the leader of a multi-part block."

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
            format_byte = self.format | EXTENDED_BIT
            return self.EXTENDED.pack(
                self.status, self.flags, format_byte, self.parts, self.block_id, self.packet_id
            )
        return self.STANDARD.pack(self.status, self.block_id, self.format << 24 | self.packet_id)

    @classmethod
    def decode(cls, datagram: bytes | memoryview) -> PacketHeader:
        """Read the header only. Raises RemoteProtocolError."""
        if len(datagram) < cls.STANDARD.size:
            raise RemoteProtocolError(f"GVSP packet of {len(datagram)} bytes, need {cls.STANDARD.size}")
        status, block_id, word = cls.STANDARD.unpack_from(datagram)
        format_byte = word >> 24
        if not format_byte & EXTENDED_BIT:
            return cls(format_byte, block_id, word & 0xFFFFFF, status)
        if len(datagram) < cls.EXTENDED.size:
            raise RemoteProtocolError(
                f"GVSP packet with extended ids of {len(datagram)} bytes, need {cls.EXTENDED.size}"
            )
        status, flags, format_byte, parts, block_id, packet_id = cls.EXTENDED.unpack_from(datagram)
        return cls(format_byte & ~EXTENDED_BIT, block_id, packet_id, status, True, flags, parts)


@dataclass(frozen=True)
class Leader:
    """Description of a block. Sizes are of the image, or of a multi-part block's first image."""

    IMAGE: ClassVar[struct.Struct] = struct.Struct(">BBHQIIIIIHH")
    IMAGE_FIELDS: ClassVar[struct.Struct] = struct.Struct(">IIIIIHH")
    COMMON: ClassVar[struct.Struct] = struct.Struct(">HHQ")

    payload_type: int = PayloadKind.IMAGE
    timestamp: int = 0
    "Device ticks."
    pixel_format: int = 0
    "PFNC code."
    width: int = 0
    height: int = 0
    offset_x: int = 0
    offset_y: int = 0
    padding_x: int = 0
    "Bytes at the end of each line."
    padding_y: int = 0
    "Bytes at the end of the image."
    parts: tuple[Part, ...] = ()

    @property
    def kind(self) -> int:
        """A `PayloadKind`, or a number that is none."""
        return self.payload_type & 0x3FFF

    @property
    def kind_name(self) -> str:
        """Content of the block as display text."""
        return _KIND_NAMES.get(self.kind, "an unknown kind of data")

    @property
    def has_chunks(self) -> bool:
        """Whether more than the image is in the payload."""
        return bool(self.payload_type & CHUNK_BIT) or self.kind == PayloadKind.EXTENDED_CHUNK

    @property
    def is_image(self) -> bool:
        """Whether the layout of the pixels is known."""
        return bool(self.width and self.height and self.pixel_format)

    @cached_property
    def image_bytes(self) -> int:
        """Bytes of the image with its padding; chunks and further parts not counted."""
        bits = self.pixel_format >> 16 & 0xFF
        if self.padding_x:
            pixels = ((self.width * bits + 7) // 8 + self.padding_x) * self.height
        else:
            pixels = (self.width * self.height * bits + 7) // 8
        return pixels + self.padding_y

    @cached_property
    def payload_bytes(self) -> int | None:
        """Bytes of the whole payload; None if the leader does not contain it."""
        if self.parts:
            return sum(part.length for part in self.parts)
        return self.image_bytes if self.is_image and not self.has_chunks else None

    def encode(self) -> bytes:
        """Return the bytes after the header of an image or multi-part leader."""
        if self.parts:
            head = self.COMMON.pack(0, self.payload_type, self.timestamp)
            return head + b"".join(part.encode() for part in self.parts)
        return self.IMAGE.pack(0, 0, self.payload_type, self.timestamp, *self._geometry())

    def _geometry(self) -> tuple[int, ...]:
        return (
            self.pixel_format,
            self.width,
            self.height,
            self.offset_x,
            self.offset_y,
            self.padding_x,
            self.padding_y,
        )

    @classmethod
    def decode(cls, body: bytes | memoryview) -> Leader:
        """Read what follows the header. Raises RemoteProtocolError.

        Of kinds that are no image only type and timestamp are read.
        """
        if len(body) < 4:
            raise RemoteProtocolError(f"GVSP leader of {len(body)} bytes")
        payload_type = struct.unpack_from(">H", body, 2)[0]
        kind = payload_type & 0x3FFF
        if kind == PayloadKind.H264:
            return cls(payload_type)
        if len(body) < cls.COMMON.size:
            raise RemoteProtocolError(f"GVSP leader of {len(body)} bytes, need {cls.COMMON.size}")
        timestamp = cls.COMMON.unpack_from(body)[2]
        if kind == PayloadKind.MULTI_PART:
            return cls._of_parts(payload_type, timestamp, body)
        if kind not in (PayloadKind.IMAGE, PayloadKind.EXTENDED_CHUNK, PayloadKind.MULTI_ZONE):
            return cls(payload_type, timestamp)
        offset = 16 if kind == PayloadKind.MULTI_ZONE else 12
        if len(body) < offset + cls.IMAGE_FIELDS.size:
            raise RemoteProtocolError(
                f"GVSP image leader of {len(body)} bytes, need {offset + cls.IMAGE_FIELDS.size}"
            )
        return cls(payload_type, timestamp, *cls.IMAGE_FIELDS.unpack_from(body, offset))

    @classmethod
    def _of_parts(cls, payload_type: int, timestamp: int, body: bytes | memoryview) -> Leader:
        count = (len(body) - cls.COMMON.size) // Part.FORMAT.size
        parts = tuple(Part.decode(body, cls.COMMON.size + index * Part.FORMAT.size) for index in range(count))
        image = next((part for part in parts if part.is_image), None)
        if image is None:
            return cls(payload_type, timestamp, parts=parts)
        return cls(payload_type, timestamp, image.pixel_format, *image.geometry, parts=parts)


@dataclass(frozen=True)
class Part:
    """One part of a multi-part block."""

    FORMAT: ClassVar[struct.Struct] = struct.Struct(">H6sI2xBBIHHIIIIHH4x")
    IMAGE_TYPES: ClassVar[tuple[int, ...]] = (1, 5)
    "2D image, 3D image: the whole of its pixels is in one part."

    data_type: int
    length: int
    "Bytes."
    pixel_format: int
    geometry: tuple[int, int, int, int, int, int]
    "Width, height, offset x, offset y, padding x, padding y."
    source: int = 0
    purpose: int = 0
    region: int = 0

    @property
    def is_image(self) -> bool:
        """Whether it is an image of its own."""
        return self.data_type in self.IMAGE_TYPES

    def encode(self) -> bytes:
        """Return the 48 bytes."""
        return self.FORMAT.pack(
            self.data_type,
            self.length.to_bytes(6, "big"),
            self.pixel_format,
            self.source,
            0,
            0,
            self.purpose,
            self.region,
            *self.geometry,
        )

    @classmethod
    def decode(cls, body: bytes | memoryview, offset: int) -> Part:
        """Read 48 bytes at `offset`."""
        data_type, length, code, source, _, _, purpose, region, *geometry = cls.FORMAT.unpack_from(
            body, offset
        )
        width, height, x, y, padding_x, padding_y = geometry
        return cls(
            data_type,
            int.from_bytes(length, "big"),
            code,
            (width, height, x, y, padding_x, padding_y),
            source,
            purpose,
            region,
        )


@dataclass(frozen=True)
class Trailer:
    """The end of a block."""

    COMMON: ClassVar[struct.Struct] = struct.Struct(">HH")

    payload_type: int = PayloadKind.IMAGE
    height: int = 0
    "Lines that were sent; 0 if the device does not report it."
    payload_bytes: int | None = None
    "Bytes of the whole payload, of blocks with chunks."

    def encode(self) -> bytes:
        """Return the bytes after the header."""
        body = self.COMMON.pack(0, self.payload_type)
        if self.payload_type & 0x3FFF != PayloadKind.MULTI_PART:
            body += struct.pack(">I", self.height)
        if self.payload_bytes is not None:
            body += struct.pack(">II", self.payload_bytes, 0)
        return body

    @classmethod
    def decode(cls, body: bytes | memoryview) -> Trailer:
        """Read what follows the header. Raises RemoteProtocolError."""
        if len(body) < cls.COMMON.size:
            raise RemoteProtocolError(f"GVSP trailer of {len(body)} bytes, need {cls.COMMON.size}")
        payload_type = cls.COMMON.unpack_from(body)[1]
        kind = payload_type & 0x3FFF
        words = struct.unpack_from(f">{(len(body) - 4) // 4}I", body, 4)
        if kind == PayloadKind.IMAGE:
            height = words[0] if words else 0
            size = words[1] if payload_type & CHUNK_BIT and len(words) > 1 else None
            return cls(payload_type, height, size)
        if kind == PayloadKind.CHUNK:
            return cls(payload_type, 0, words[0] if words else None)
        if kind == PayloadKind.EXTENDED_CHUNK and len(words) > 1:
            return cls(payload_type, words[1], words[0])
        return cls(payload_type)


@dataclass(frozen=True)
class PartPosition:
    """The header of the data in a multi-part payload packet."""

    SIZE: ClassVar[int] = 8

    part: int
    offset: int
    "Bytes from the start of the whole payload."
    last: bool = False

    def encode(self) -> bytes:
        """Return the eight bytes."""
        return bytes((self.part, 0x40 if self.last else 0)) + self.offset.to_bytes(6, "big")

    @classmethod
    def decode(cls, body: bytes | memoryview) -> PartPosition:
        """Read eight bytes. Raises RemoteProtocolError."""
        if len(body) < cls.SIZE:
            raise RemoteProtocolError(f"GVSP multi-part packet of {len(body)} bytes, need {cls.SIZE}")
        return cls(body[0], int.from_bytes(bytes(body[2:8]), "big"), bool(body[1] & 0x40))


def payload_stride(packet_size: int, *, extended: bool = False) -> int:
    """Return the image bytes in a full packet, for the `packet_size` that SCPS holds."""
    header = PacketHeader.EXTENDED.size if extended else PacketHeader.STANDARD.size
    return packet_size - IP_UDP_BYTES - header
