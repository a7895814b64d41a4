"""One packet's contents into its block, and what they say of it."""

from __future__ import annotations

import logging

from grabbergui.core.errors import RemoteProtocolError
from grabbergui.core.grabber import StreamStatistics
from grabbergui.driver.gige.block import Block
from grabbergui.driver.gige.gvsp import (
    CHUNK_BIT,
    Leader,
    PacketFormat,
    PacketHeader,
    PartPosition,
    Trailer,
)

log = logging.getLogger(__name__)


class BlockFiller:
    """Fills the blocks of one stream."""

    def __init__(self, stride: int, payload_size: int, statistics: StreamStatistics) -> None:
        self._statistics = statistics
        self.stride = stride
        "Image bytes in a full packet: what was announced, until a packet shows otherwise."
        self.payload_size = payload_size
        self._told: set[str] = set()

    def store(self, block: Block, header: PacketHeader, body: memoryview) -> None:
        """Put what a packet carries where it belongs. Raises RemoteProtocolError."""
        if header.format == PacketFormat.PAYLOAD:
            self._check_stride(block, header.packet_id, len(body))
            offset = (header.packet_id - 1) * self.stride
            self._place(block, offset, self._without_padding(offset, body))
            block.ended_short = block.ended_short or len(body) < self.stride
        elif header.format == PacketFormat.LEADER:
            self._take_leader(block, body)
        elif header.format == PacketFormat.TRAILER:
            self._take_trailer(block, header.packet_id, body)
        elif header.format in (PacketFormat.MULTI_PART, PacketFormat.MULTI_ZONE):
            self._place(block, PartPosition.decode(body).offset, body[PartPosition.SIZE :])
        elif header.format == PacketFormat.ALL_IN:
            self._take_all_in(block, body)
        else:
            raise RemoteProtocolError(f"a packet of format {header.format}, which carries no picture")

    def _take_leader(self, block: Block, body: memoryview) -> None:
        leader = Leader.decode(body)
        if not leader.is_picture:
            block.refused = True
            self.tell_once(
                f"the camera sends {leader.kind_name} (payload type 0x{leader.payload_type:04X})",
                "nothing of that can be shown; let the camera send plain images",
            )
        elif max(leader.image_bytes, leader.payload_bytes or 0) > self.payload_size:
            block.refused = True
            self.tell_once(
                "the camera sends what does not fit",
                f"payload type 0x{leader.payload_type:04X}, {leader.width}x{leader.height}, pixel format"
                f" 0x{leader.pixel_format:08X}; PayloadSize says {self.payload_size} bytes",
            )
        block.leader = leader

    def _take_trailer(self, block: Block, packet_id: int, body: memoryview) -> None:
        trailer = Trailer.decode(body)
        if packet_id < max(block.highest, 1):
            raise RemoteProtocolError(f"trailer with packet_id {packet_id} after packet {block.highest}")
        block.trailer, block.last_id = trailer, packet_id

    def _take_all_in(self, block: Block, body: memoryview) -> None:
        leader_size = Leader.IMAGE.size
        trailer_size = 16 if len(body) > 2 and body[2] << 8 & CHUNK_BIT else 8
        self._take_leader(block, body[:leader_size])
        block.trailer = Trailer.decode(body[leader_size : leader_size + trailer_size])
        block.last_id = 0
        self._place(block, 0, body[leader_size + trailer_size :])

    def _without_padding(self, offset: int, body: memoryview) -> memoryview:
        """Some cameras fill the last packet up to the size of the others, beyond the end of the payload."""
        room = self.payload_size - offset
        if not 0 < room < len(body):
            return body
        self._statistics.packets_clipped += 1
        return body[:room]

    def _place(self, block: Block, offset: int, data: memoryview) -> None:
        if offset < 0 or offset + len(data) > self.payload_size:
            raise RemoteProtocolError(
                f"data up to byte {offset + len(data)} of a payload of {self.payload_size}"
            )
        block.place(offset, data)

    def _check_stride(self, block: Block, packet_id: int, length: int) -> None:
        """A device may send other sizes than its register says; a picture's first packet tells."""
        leader = block.leader
        if (
            packet_id == 1
            and leader is not None
            and 0 < length < leader.image_bytes
            and length != self.stride
        ):
            log.info("packets carry %d bytes instead of %d", length, self.stride)
            self.stride = length
        elif not 0 < length <= self.stride:
            raise RemoteProtocolError(
                f"a packet with {length} bytes of payload, {self.stride} are a full one"
            )

    def tell_once(self, what: str, details: str) -> None:
        """Log a fault that may come with every packet."""
        if what not in self._told:
            self._told.add(what)
            log.warning("%s: %s", what, details)
