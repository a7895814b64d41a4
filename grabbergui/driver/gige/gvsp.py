"""GVSP, the stream protocol of GigE Vision: leaders, trailers, and the positions of payload data.

A block (one frame) is a leader, payload packets and a trailer, numbered by packet_id from 0; `packet_header`
has the header of each. Integers are big-endian. No I/O; `stream.assembler` assembles packets.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property
from typing import ClassVar

from grabbergui.core.device_text import text_field
from grabbergui.core.errors import RemoteProtocolError
from grabbergui.driver.gige.packet_header import PacketHeader

IP_UDP_BYTES = 28
"IP and UDP headers, which SCPS counts too."
CHUNK_BIT = 0x4000
"In the payload type: chunks are appended. The rest is the kind, see `kind_in`."


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


def kind_in(payload_type: int) -> int:
    """Return the `PayloadKind` in a payload type, or a number that is none: from 0x8000 on a vendor's."""
    return payload_type & ~CHUNK_BIT


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


_SIZE_AT: dict[int, int] = {
    PayloadKind.RAW: 12,
    PayloadKind.FILE: 12,
    PayloadKind.JPEG: 12,
    PayloadKind.JPEG2000: 12,
    PayloadKind.H264: 4,
    PayloadKind.GENDC: 12,
}
"Offset in the leader of the data's 64-bit size, for kinds that have it."
_IMAGE_AT: dict[int, int] = {
    PayloadKind.IMAGE: 12,
    PayloadKind.EXTENDED_CHUNK: 12,
    PayloadKind.MULTI_ZONE: 16,  # behind the directions of its zones
}
"Offset in the leader of the pixel format and the geometry, for kinds that have them."
_RESERVED: dict[int, int] = {PayloadKind.JPEG: 12, PayloadKind.JPEG2000: 12, PayloadKind.GENDC: 8}
"Bytes behind that size."
POSITIONED = frozenset((PayloadKind.H264, PayloadKind.MULTI_ZONE, PayloadKind.MULTI_PART, PayloadKind.GENDC))
"Kinds whose payload packets have an additional header, most with the data's position."


@dataclass(frozen=True)
class Leader:
    """First packet of a block. Sizes are those of the image, or of a multi-part block's first image."""

    IMAGE: ClassVar[struct.Struct] = struct.Struct(">IIIIIHH")
    COMMON: ClassVar[struct.Struct] = struct.Struct(">HHQ")
    "At the beginning of most leaders: reserved, payload type, timestamp."

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
    parts: tuple[PayloadPart, ...] = ()
    size: int = 0
    "Bytes of raw data, a file, a compressed image or a container; 0 if the leader does not contain it."
    file_name: str = ""

    @cached_property
    def kind(self) -> int:
        """A `PayloadKind`, or a number that is none."""
        return kind_in(self.payload_type)

    @property
    def kind_name(self) -> str:
        """The content of the block as display text."""
        return _KIND_NAMES.get(self.kind, "an unknown kind of data")

    @property
    def has_chunks(self) -> bool:
        """Whether chunks are in the payload, after the image or alone."""
        chunks = (PayloadKind.CHUNK, PayloadKind.EXTENDED_CHUNK)
        return bool(self.payload_type & CHUNK_BIT) or self.kind in chunks

    @property
    def is_image(self) -> bool:
        """Whether the layout of the pixels is known, apart from the number of lines."""
        return bool(self.width and self.pixel_format)

    @property
    def is_known(self) -> bool:
        """Whether the block can become a frame."""
        return self.is_image or self.kind == PayloadKind.CHUNK or self.kind in _SIZE_AT or bool(self.parts)

    @cached_property
    def image_bytes(self) -> int:
        """Bytes of the image with its padding, without chunks and further parts."""
        if self.padding_x:
            pixels = (self.line_bytes + self.padding_x) * self.height
        else:
            pixels = (self.width * self.height * self._bits + 7) // 8
        return pixels + self.padding_y

    @property
    def line_bytes(self) -> int:
        """Bytes of one line without its padding."""
        return (self.width * self._bits + 7) // 8

    @property
    def _bits(self) -> int:
        return self.pixel_format >> 16 & 0xFF

    @cached_property
    def payload_bytes(self) -> int | None:
        """Bytes of the whole payload; None if the leader does not contain it."""
        if self.parts:
            return sum(part.length for part in self.parts)
        if self.has_chunks:
            return None
        # The leader of a line-scan camera has no height; the trailer does.
        return self.image_bytes or None if self.is_image else self.size or None

    def encode(self) -> bytes:
        """Return the bytes after the header."""
        if self.kind == PayloadKind.H264:
            return self.COMMON.pack(0, self.payload_type, self.size).ljust(32, b"\0")
        head = self.COMMON.pack(0, self.payload_type, self.timestamp)
        if self.parts:
            return head + b"".join(part.encode() for part in self.parts)
        if self.kind == PayloadKind.CHUNK:
            return head
        if self.kind in _SIZE_AT:
            name = self.file_name.encode() + b"\0" if self.kind == PayloadKind.FILE else b""
            return head + self.size.to_bytes(8, "big") + name + bytes(_RESERVED.get(self.kind, 0))
        head = head.ljust(_IMAGE_AT.get(self.kind, len(head)), b"\0")
        offset, padding = (self.offset_x, self.offset_y), (self.padding_x, self.padding_y)
        return head + self.IMAGE.pack(self.pixel_format, self.width, self.height, *offset, *padding)

    @classmethod
    def decode(cls, body: bytes | memoryview) -> Leader:
        """Read what follows the header. Raises RemoteProtocolError.

        For unknown kinds only type and timestamp are read.
        """
        if len(body) < 4:
            raise RemoteProtocolError(f"GVSP leader of {len(body)} bytes")
        payload_type = struct.unpack_from(">H", body, 2)[0]
        kind = kind_in(payload_type)
        if kind == PayloadKind.H264:  # the timestamp is in the payload packets
            return cls(payload_type, size=_size(body, kind))
        if len(body) < cls.COMMON.size:
            raise RemoteProtocolError(f"GVSP leader of {len(body)} bytes, need {cls.COMMON.size}")
        timestamp = cls.COMMON.unpack_from(body)[2]
        if kind == PayloadKind.MULTI_PART:
            return cls._of_parts(payload_type, timestamp, body)
        if kind in _SIZE_AT:
            name = text_field(bytes(body[20:])) if kind == PayloadKind.FILE else ""
            return cls(payload_type, timestamp, size=_size(body, kind), file_name=name)
        offset = _IMAGE_AT.get(kind)
        if offset is None:
            return cls(payload_type, timestamp)
        if len(body) < offset + cls.IMAGE.size:
            raise RemoteProtocolError(
                f"GVSP image leader of {len(body)} bytes, need {offset + cls.IMAGE.size}"
            )
        return cls(payload_type, timestamp, *cls.IMAGE.unpack_from(body, offset))

    @classmethod
    def _of_parts(cls, payload_type: int, timestamp: int, body: bytes | memoryview) -> Leader:
        count = (len(body) - cls.COMMON.size) // PayloadPart.FORMAT.size
        parts = tuple(
            PayloadPart.decode(body, cls.COMMON.size + index * PayloadPart.FORMAT.size)
            for index in range(count)
        )
        image = next((part for part in parts if part.is_image), None)
        if image is None:
            return cls(payload_type, timestamp, parts=parts)
        return cls(payload_type, timestamp, image.pixel_format, *image.geometry, parts=parts)


def _size(body: bytes | memoryview, kind: int) -> int:
    at = _SIZE_AT[kind]
    if len(body) < at + 8:
        raise RemoteProtocolError(f"GVSP leader of {len(body)} bytes for {_KIND_NAMES[kind]}, need {at + 8}")
    return int.from_bytes(body[at : at + 8], "big")


class PartType(IntEnum):
    """Content of a part of a multi-part block."""

    IMAGE_2D = 1
    IMAGE_3D = 5
    CONFIDENCE = 9
    CHUNK = 10
    JPEG = 11
    JPEG2000 = 12


@dataclass(frozen=True)
class PayloadPart:
    """One part of a multi-part block."""

    FORMAT: ClassVar[struct.Struct] = struct.Struct(">H6sI2xB5xHHIIIIHH4x")
    IMAGE_TYPES: ClassVar[tuple[int, ...]] = (PartType.IMAGE_2D, PartType.IMAGE_3D)
    "Types whose pixels are all in one part."

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
        """Whether it is a whole image."""
        return self.data_type in self.IMAGE_TYPES

    def encode(self) -> bytes:
        """Return the 48 bytes."""
        return self.FORMAT.pack(
            self.data_type,
            self.length.to_bytes(6, "big"),
            self.pixel_format,
            self.source,
            self.purpose,
            self.region,
            *self.geometry,
        )

    @classmethod
    def decode(cls, body: bytes | memoryview, offset: int) -> PayloadPart:
        """Read 48 bytes at `offset`."""
        fields = cls.FORMAT.unpack_from(body, offset)
        data_type, length, code, source, purpose, region = fields[:6]
        size = int.from_bytes(length, "big")
        return cls(data_type, size, code, fields[6:], source, purpose, region)


@dataclass(frozen=True)
class Trailer:
    """Last packet of a block."""

    COMMON: ClassVar[struct.Struct] = struct.Struct(">HH")

    payload_type: int = PayloadKind.IMAGE
    height: int = 0
    "Lines that were sent; 0 if the device does not report it."
    payload_bytes: int | None = None
    "Bytes of the whole payload, for blocks with chunks."

    def encode(self) -> bytes:
        """Return the bytes after the header."""
        body, kind = self.COMMON.pack(0, self.payload_type), kind_in(self.payload_type)
        if kind == PayloadKind.CHUNK:
            return body + struct.pack(">I", self.payload_bytes or 0)
        if kind == PayloadKind.EXTENDED_CHUNK:
            return body + struct.pack(">III", self.payload_bytes or 0, self.height, 0)
        if kind in (PayloadKind.IMAGE, PayloadKind.MULTI_ZONE):
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
        kind = kind_in(payload_type)
        words = struct.unpack_from(f">{(len(body) - 4) // 4}I", body, 4)
        if kind in (PayloadKind.IMAGE, PayloadKind.MULTI_ZONE):
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


@dataclass(frozen=True)
class GendcPosition:
    """The header of the data in a GenDC payload packet."""

    FORMAT: ClassVar[struct.Struct] = struct.Struct(">IQBBH")
    DESCRIPTOR: ClassVar[int] = 0xC0
    "Data flag: the descriptor is in this packet."
    FIRST, LAST = 0x80, 0x40
    "Flow flags: the first and the last packet of the flow."

    size: int
    "Bytes of data."
    offset: int
    "Bytes from the start of the flow; a single flow is the whole container."
    data_flags: int = 0
    flow_flags: int = 0
    flow: int = 0

    def encode(self) -> bytes:
        """Return the sixteen bytes."""
        return self.FORMAT.pack(self.size, self.offset, self.data_flags, self.flow_flags, self.flow)

    @classmethod
    def decode(cls, body: bytes | memoryview) -> GendcPosition:
        """Read sixteen bytes. Raises RemoteProtocolError."""
        if len(body) < cls.FORMAT.size:
            raise RemoteProtocolError(f"GVSP GenDC packet of {len(body)} bytes, need {cls.FORMAT.size}")
        position = cls(*cls.FORMAT.unpack_from(body))
        if position.size > len(body) - cls.FORMAT.size:
            raise RemoteProtocolError(
                f"GVSP GenDC packet announces {position.size} bytes, has {len(body) - cls.FORMAT.size}"
            )
        return position


def payload_stride(packet_size: int, *, extended: bool = False) -> int:
    """Return the image bytes in a full packet with the `packet_size` in SCPS."""
    header = PacketHeader.EXTENDED.size if extended else PacketHeader.STANDARD.size
    return packet_size - IP_UDP_BYTES - header
