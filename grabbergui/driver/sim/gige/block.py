"""One frame as GVSP packets: where each one's bytes lie and which header it has."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from grabbergui.driver.gige.gvcp import Status
from grabbergui.driver.gige.gvsp import (
    CHUNK_BIT,
    FLAG_RESEND,
    Leader,
    PacketFormat,
    PacketHeader,
    PayloadKind,
    Trailer,
    payload_stride,
)
from grabbergui.driver.sim.model import FramePlan


@dataclass
class Block:
    """A frame cut into packets: 0 is the leader, 1 to n the payload, n + 1 the trailer."""

    plan: FramePlan
    payload: NDArray[np.uint8]
    "The frame's bytes."
    packet_size: int
    "As SCPS counts."
    extended: bool = False
    "64-bit block ids."
    sent: int = 0
    "Packets that left already, or were lost on purpose: what is after them cannot be sent again yet."

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
        """How many packets carry payload."""
        return -(-len(self.payload) // self.stride)

    @property
    def trailer_id(self) -> int:
        """The last packet's id."""
        return self.payload_packets + 1

    @cached_property
    def headers(self) -> NDArray[np.uint8]:
        """(n, 8 or 20): the headers of the payload packets."""
        first = PacketHeader(PacketFormat.PAYLOAD, self.block_id, 1, extended=self.extended).encode()
        headers = np.tile(np.frombuffer(first, np.uint8), (self.payload_packets, 1))
        # The packet id is the last three bytes, or four of which 24 bits are always enough.
        ids = np.arange(1, self.payload_packets + 1, dtype=np.uint32)
        headers[:, -3] = ids >> 16
        headers[:, -2] = ids >> 8 & 0xFF
        headers[:, -1] = ids & 0xFF
        return headers

    @cached_property
    def starts(self) -> NDArray[np.int64]:
        """Where each payload packet's bytes begin."""
        return np.arange(self.payload_packets, dtype=np.int64) * self.stride

    @cached_property
    def sizes(self) -> NDArray[np.int64]:
        """How many payload bytes each packet has: full ones, but the last."""
        return np.minimum(len(self.payload) - self.starts, self.stride)

    def leader(self) -> bytes:
        """The leader's datagram."""
        settings = self.plan.settings
        body = Leader(
            self._payload_type,
            self.plan.timestamp_ns,
            settings.pixel_format.code,
            settings.width,
            settings.height,
            settings.offset_x,
            settings.offset_y,
        )
        return self._header(PacketFormat.LEADER, 0) + body.encode()

    def trailer(self) -> bytes:
        """The trailer's datagram."""
        size = len(self.payload) if self.plan.chunk_values else None
        body = Trailer(self._payload_type, self.plan.settings.height, size)
        return self._header(PacketFormat.TRAILER, self.trailer_id) + body.encode()

    def packet(self, packet_id: int) -> bytes:
        """Any packet's datagram, marked as sent again."""
        if packet_id == 0:
            return self._marked(self.leader())
        if packet_id == self.trailer_id:
            return self._marked(self.trailer())
        start = (packet_id - 1) * self.stride
        header = self.headers[packet_id - 1].tobytes()
        return self._marked(header + self.payload[start : start + self.stride].tobytes())

    @property
    def _payload_type(self) -> int:
        return PayloadKind.IMAGE | (CHUNK_BIT if self.plan.chunk_values else 0)

    def _header(self, packet_format: PacketFormat, packet_id: int) -> bytes:
        return PacketHeader(packet_format, self.block_id, packet_id, extended=self.extended).encode()

    def _marked(self, datagram: bytes) -> bytes:
        marked = bytearray(datagram)
        marked[0:2] = int(Status.PACKET_RESEND).to_bytes(2, "big")
        if self.extended:
            marked[3] |= FLAG_RESEND
        return bytes(marked)


def unavailable(block_id: int, packet_id: int, extended: bool, status: Status) -> bytes:
    """The datagram that says that a packet cannot be sent again, or not yet."""
    return PacketHeader(PacketFormat.PAYLOAD, block_id, packet_id, status, extended).encode()


def test_packet(size: int) -> bytes:
    """A datagram for trying a packet size: block id 0, zeros to fill it up."""
    header = PacketHeader(PacketFormat.PAYLOAD, 0, 0).encode()
    return header.ljust(size - 28, b"\0")
