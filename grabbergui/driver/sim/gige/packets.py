"""Frames as GVSP datagrams: the packets of a block."""

from __future__ import annotations

import bisect
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.component import ComponentKind, PayloadType
from grabbergui.driver.gige.gvcp import Status
from grabbergui.driver.gige.gvsp import (
    CHUNK_BIT,
    IP_UDP_BYTES,
    GendcPosition,
    Leader,
    PartPosition,
    PartType,
    PayloadKind,
    PayloadPart,
    Trailer,
    payload_stride,
)
from grabbergui.driver.gige.packet_header import FLAG_RESEND, PacketFormat, PacketHeader
from grabbergui.driver.sim.contents import FILE_NAME, Piece, pieces
from grabbergui.driver.sim.model import FramePlan

_KINDS = {
    PayloadType.IMAGE: PayloadKind.IMAGE,
    PayloadType.CHUNK: PayloadKind.CHUNK,
    PayloadType.RAW_DATA: PayloadKind.RAW,
    PayloadType.FILE: PayloadKind.FILE,
    PayloadType.JPEG: PayloadKind.JPEG,
    PayloadType.JPEG2000: PayloadKind.JPEG2000,
    PayloadType.H264: PayloadKind.H264,
    PayloadType.MULTI_PART: PayloadKind.MULTI_PART,
    PayloadType.GENDC: PayloadKind.GENDC,
}
_FORMATS = {
    PayloadType.H264: PacketFormat.H264,
    PayloadType.MULTI_PART: PacketFormat.MULTI_PART,
    PayloadType.GENDC: PacketFormat.GENDC,
}
_POSITION_BYTES = {
    PacketFormat.H264: 8,
    PacketFormat.MULTI_PART: PartPosition.SIZE,
    PacketFormat.GENDC: GendcPosition.FORMAT.size,
}
_PART_TYPES = {
    ComponentKind.RANGE: PartType.IMAGE_3D,
    ComponentKind.CONFIDENCE: PartType.CONFIDENCE,
}


@dataclass
class FramePackets:
    """A frame cut into packets: 0 is the leader, 1 to n the payload, n + 1 the trailer."""

    plan: FramePlan
    payload: NDArray[np.uint8]
    "The frame's bytes."
    packet_size: int
    "As SCPS counts."
    extended: bool = False
    "64-bit block ids."
    height_in_trailer: bool = False
    "As a line-scan camera does, which knows the number of lines only at the end."
    sent: int = 0
    "Packets that were sent already, or lost on purpose; later ones cannot be sent again yet."

    @property
    def block_id(self) -> int:
        """The frame's id on the wire."""
        return self.plan.frame_id if self.extended else (self.plan.frame_id - 1) % 0xFFFF + 1

    @property
    def stride(self) -> int:
        """Payload bytes of a full packet."""
        return payload_stride(self.packet_size, extended=self.extended)

    @property
    def payload_packets(self) -> int:
        """Number of payload packets."""
        return len(self.starts)

    @property
    def trailer_id(self) -> int:
        """The last packet's id."""
        return self.payload_packets + 1

    @cached_property
    def headers(self) -> NDArray[np.uint8]:
        """Headers of the payload packets, (n, bytes), with the position of the data if the format has one."""
        first = PacketHeader(self._format, self.block_id, 1, extended=self.extended).encode()
        headers = np.tile(np.frombuffer(first, np.uint8), (self.payload_packets, 1))
        # The packet id is the last three bytes, or four of which 24 bits are always enough.
        ids = np.arange(1, self.payload_packets + 1, dtype=np.uint32)
        headers[:, -3] = ids >> 16
        headers[:, -2] = ids >> 8 & 0xFF
        headers[:, -1] = ids & 0xFF
        positions = self._positions()
        return np.concatenate((headers, positions), axis=1) if positions is not None else headers

    @cached_property
    def starts(self) -> NDArray[np.int64]:
        """Offset of each packet's data in the payload; a part of a multi-part block begins with a packet."""
        room = self.stride - _POSITION_BYTES.get(self._format, 0)
        return np.concatenate([np.arange(begin, end, room, dtype=np.int64) for begin, end in self._runs()])

    @cached_property
    def sizes(self) -> NDArray[np.int64]:
        """Payload bytes of each packet: full except for the last packet of a run."""
        room = self.stride - _POSITION_BYTES.get(self._format, 0)
        ends = np.concatenate([np.full(-(-(end - begin) // room), end) for begin, end in self._runs()])
        return np.minimum(ends - self.starts, room)

    def leader(self) -> bytes:
        """Return the leader's datagram."""
        settings, kind = self.plan.settings, self.plan.settings.payload_type
        body = Leader(self._payload_type, self.plan.timestamp_ns, size=len(self.payload))
        if kind is PayloadType.FILE:
            body = replace(body, file_name=FILE_NAME)
        elif kind is PayloadType.MULTI_PART:
            body = replace(body, parts=tuple(self._part(piece) for piece in self._pieces))
        elif kind is PayloadType.IMAGE:
            body = Leader(
                self._payload_type,
                self.plan.timestamp_ns,
                settings.pixel_format.code,
                settings.width,
                0 if self.height_in_trailer else settings.height,
                settings.offset_x,
                settings.offset_y,
            )
        header = PacketHeader(
            PacketFormat.LEADER, self.block_id, 0, extended=self.extended, parts=len(body.parts)
        )
        return header.encode() + body.encode()

    def trailer(self) -> bytes:
        """Return the trailer's datagram."""
        alone = self.plan.settings.payload_type is PayloadType.CHUNK
        size = len(self.payload) if alone or self._payload_type & CHUNK_BIT else None
        body = Trailer(self._payload_type, self.plan.settings.height, size)
        return self._header(PacketFormat.TRAILER, self.trailer_id) + body.encode()

    def packet(self, packet_id: int) -> bytes:
        """Return any packet's datagram, marked as resent."""
        if packet_id == 0:
            return self._marked(self.leader())
        if packet_id == self.trailer_id:
            return self._marked(self.trailer())
        start, size = int(self.starts[packet_id - 1]), int(self.sizes[packet_id - 1])
        header = self.headers[packet_id - 1].tobytes()
        return self._marked(header + self.payload[start : start + size].tobytes())

    @cached_property
    def _pieces(self) -> tuple[Piece, ...]:
        return pieces(self.plan.settings, tuple(self.plan.chunk_values))

    def _runs(self) -> list[tuple[int, int]]:
        """Return begin and end of each run, which is divided into full packets and a last one."""
        if self.plan.settings.payload_type is PayloadType.MULTI_PART:
            return [(piece.begin, piece.begin + piece.length) for piece in self._pieces]
        return [(0, len(self.payload))]

    def _positions(self) -> NDArray[np.uint8] | None:
        """Return the position of each packet's data, shape (n, 8 or 16)."""
        if self._format is PacketFormat.GENDC:
            last = self.payload_packets - 1
            rows = [
                GendcPosition(
                    int(size),
                    int(start),
                    GendcPosition.DESCRIPTOR if start == 0 else 0,
                    GendcPosition.FIRST * (index == 0) | GendcPosition.LAST * (index == last),
                ).encode()
                for index, (start, size) in enumerate(zip(self.starts, self.sizes, strict=True))
            ]
        elif self._format is PacketFormat.MULTI_PART:
            begins = [piece.begin for piece in self._pieces]
            ends = {piece.begin + piece.length for piece in self._pieces}
            rows = [
                PartPosition(
                    bisect.bisect_right(begins, start) - 1, int(start), int(start + size) in ends
                ).encode()
                for start, size in zip(self.starts, self.sizes, strict=True)
            ]
        elif self._format is PacketFormat.H264:
            rows = [self.plan.timestamp_ns.to_bytes(8, "big")] * self.payload_packets
        else:
            return None
        return np.frombuffer(b"".join(rows), np.uint8).reshape(len(rows), -1)

    def _part(self, piece: Piece) -> PayloadPart:
        settings = self.plan.settings
        shape = (settings.width, settings.height, settings.offset_x, settings.offset_y, 0, 0)
        if piece.kind is ComponentKind.METADATA:
            return PayloadPart(PartType.CHUNK, piece.length, 0, (0, 0, 0, 0, 0, 0))
        data_type = _PART_TYPES.get(piece.kind, PartType.IMAGE_2D)
        return PayloadPart(data_type, piece.length, piece.pixel_format.code, shape, purpose=piece.kind)

    @property
    def _format(self) -> PacketFormat:
        return _FORMATS.get(self.plan.settings.payload_type, PacketFormat.PAYLOAD)

    @property
    def _payload_type(self) -> int:
        kind = self.plan.settings.payload_type
        appended = kind in (PayloadType.IMAGE, PayloadType.JPEG, PayloadType.JPEG2000)
        return _KINDS[kind] | (CHUNK_BIT if appended and self.plan.chunk_values else 0)

    def _header(self, packet_format: PacketFormat, packet_id: int) -> bytes:
        return PacketHeader(packet_format, self.block_id, packet_id, extended=self.extended).encode()

    def _marked(self, datagram: bytes) -> bytes:
        marked = bytearray(datagram)
        marked[0:2] = int(Status.PACKET_RESEND).to_bytes(2, "big")
        if self.extended:
            marked[3] |= FLAG_RESEND
        return bytes(marked)


def unavailable(block_id: int, packet_id: int, extended: bool, status: Status) -> bytes:
    """Return the datagram that says that a packet cannot be sent again, or not yet."""
    return PacketHeader(PacketFormat.PAYLOAD, block_id, packet_id, status, extended).encode()


def test_packet(size: int) -> bytes:
    """Return a datagram for trying a packet size: block id 0, zeros to fill it up."""
    header = PacketHeader(PacketFormat.PAYLOAD, 0, 0).encode()
    return header.ljust(size - IP_UDP_BYTES, b"\0")
