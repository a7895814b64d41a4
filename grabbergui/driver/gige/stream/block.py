"""One block (GVSP's word for what becomes a frame) from its first packet to the result that is delivered."""

from __future__ import annotations

import logging
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.errors import RemoteProtocolError
from grabbergui.driver.gige.gvsp import (
    CHUNK_BIT,
    Leader,
    PacketFormat,
    PacketHeader,
    PartPosition,
    PayloadKind,
    Trailer,
)
from grabbergui.driver.gige.stream.packet_runs import Ids, PacketRun, id_runs
from grabbergui.driver.gige.stream.resend import RequestLog, grown

log = logging.getLogger(__name__)

SCATTERED = 4
"Mean length of runs of packets below which packets are copied by one indexed assignment, not run by run."


@dataclass
class Layout:
    """Sizes that all blocks of a stream share."""

    stride: int
    "Image bytes in a full packet: as announced, until a packet shows otherwise."
    payload_size: int
    "Bytes of a buffer, the largest payload."
    _reported: set[str] = field(default_factory=set)

    @property
    def max_payload_packets(self) -> int:
        """Payload packets of the largest block."""
        return -(-self.payload_size // self.stride)

    def warn_once(self, fault: str, details: str) -> None:
        """Log a fault that may recur with every packet, once in a stream."""
        if fault not in self._reported:
            self._reported.add(fault)
            log.warning("%s: %s", fault, details)


class Block:
    """The packets of one block. Packet ids: 0 is the leader, then payload packets, the trailer is last.

    `store` and `store_rows` copy packets into the buffer, `note_received` keeps account of them. When no more
    are expected, `close` and `extract_payload` make the result: `leader`, `payload`, `height`, `complete`,
    `missing_bytes`.
    """

    def __init__(
        self, header: PacketHeader, layout: Layout, buffer: NDArray[np.uint8] | None, now: float
    ) -> None:
        """Begin the block of a packet; `buffer` is None where none was free: the block is only counted."""
        self.block_id = header.block_id
        self.extended = header.extended
        self.layout = layout
        self.buffer = buffer
        self.first_packet_at = now
        self.last_packet_at = now
        self.leader: Leader | None = None
        "In the result of an incomplete block perhaps that of the block before."
        self.trailer: Trailer | None = None
        self.trailer_id: int | None = None
        "Packet id of the trailer, once received."
        self.refused = False
        "Whether it is no image, or larger than the buffer: none of it is stored or requested."
        self.received = np.zeros(layout.max_payload_packets + 2, np.uint8)
        "1 for each packet received, by packet id."
        self.received_count = 0
        self.highest = -1
        "Highest packet id received."
        self.extent = 0
        "End of the data received, in bytes from the start of the payload."
        self.ended_short = False
        "Whether the packet at `extent` was shorter than a full one, so nothing follows it."
        self.clipped = 0
        "Packets with padding beyond the end of the payload."
        self.requests = RequestLog()
        self.complete = False
        "Whether every byte arrived; set by `close`."
        self.payload: NDArray[np.uint8] = np.zeros(0, np.uint8)
        "In `buffer`: the whole payload, or the first image of a multi-part block; set by `extract_payload`."
        self.height = 0
        "Lines that the camera sent; set by `extract_payload`."
        self.missing_bytes = 0
        "Bytes of `payload` that did not arrive and are zero; set by `extract_payload`."

    # -- storing ---------------------------------------------------------------------------------
    def store(self, header: PacketHeader, body: memoryview) -> None:
        """Copy a packet's content to where it belongs. Raises RemoteProtocolError."""
        if header.format == PacketFormat.PAYLOAD:
            self._check_length(header.packet_id, len(body))
            offset = (header.packet_id - 1) * self.layout.stride
            self._place(offset, self._without_padding(offset, body))
            self.ended_short = self.ended_short or len(body) < self.layout.stride
        elif header.format == PacketFormat.LEADER:
            self._take_leader(body)
        elif header.format == PacketFormat.TRAILER:
            trailer = Trailer.decode(body)
            if header.packet_id < max(self.highest, 1):
                raise RemoteProtocolError(
                    f"trailer with packet_id {header.packet_id} after packet {self.highest}"
                )
            self.trailer, self.trailer_id = trailer, header.packet_id
        elif header.format in (PacketFormat.MULTI_PART, PacketFormat.MULTI_ZONE):
            self._place(PartPosition.decode(body).offset, body[PartPosition.SIZE :])
        elif header.format == PacketFormat.ALL_IN:
            self._take_all_in(body)
        else:
            raise RemoteProtocolError(f"a packet of format {header.format}, which carries no image")

    def store_rows(self, run: PacketRun, rows: NDArray[np.uint8], at: NDArray[np.intp]) -> None:
        """Copy full payload packets, the i-th of the run from `rows[at[i]]`. The highest must fit."""
        ids, stride = run.ids, rows.shape[1]
        end = run.highest * stride
        self.extent = max(self.extent, end)
        if self.buffer is None or self.refused:
            return
        lines = self.buffer[:end].reshape(-1, stride)
        if run.consecutive and at[-1] - at[0] == len(at) - 1:
            lines[ids[0] - 1 :] = rows[at[0] : at[-1] + 1]
            return
        breaks = ((ids[1:] - ids[:-1] != 1) | (at[1:] - at[:-1] != 1)).nonzero()[0]
        begins = [0, *(breaks + 1).tolist()]
        if SCATTERED * len(begins) > len(ids):
            lines[ids - 1] = rows[at]
            return
        for begin, stop in zip(begins, [*begins[1:], len(ids)], strict=True):
            line, row, count = int(ids[begin]) - 1, int(at[begin]), stop - begin
            lines[line : line + count] = rows[row : row + count]

    def _take_leader(self, body: memoryview) -> None:
        self.leader = leader = Leader.decode(body)
        if not leader.is_image:
            self.refused = True
            self.layout.warn_once(
                f"the camera sends {leader.kind_name} (payload type 0x{leader.payload_type:04X})",
                "it cannot be shown; let the camera send plain images",
            )
        elif max(leader.image_bytes, leader.payload_bytes or 0) > self.layout.payload_size:
            self.refused = True
            self.layout.warn_once(
                "the camera sends a frame that does not fit",
                f"payload type 0x{leader.payload_type:04X}, {leader.width}x{leader.height}, pixel format"
                f" 0x{leader.pixel_format:08X}; PayloadSize is {self.layout.payload_size} bytes",
            )

    def _take_all_in(self, body: memoryview) -> None:
        leader_size = Leader.IMAGE.size
        trailer_size = 16 if len(body) > 2 and body[2] << 8 & CHUNK_BIT else 8
        self._take_leader(body[:leader_size])
        self.trailer = Trailer.decode(body[leader_size : leader_size + trailer_size])
        self.trailer_id = 0
        self._place(0, body[leader_size + trailer_size :])

    def _check_length(self, packet_id: int, length: int) -> None:
        """Learn the stride from an image's first packet: it may differ from the register's value."""
        stride, leader = self.layout.stride, self.leader
        if packet_id == 1 and leader is not None and 0 < length < leader.image_bytes and length != stride:
            log.info("packets carry %d bytes instead of %d", length, stride)
            self.layout.stride = length
        elif not 0 < length <= stride:
            raise RemoteProtocolError(f"a packet with {length} bytes of payload, {stride} are a full one")

    def _without_padding(self, offset: int, body: memoryview) -> memoryview:
        """Some cameras pad the last packet to the size of the others, beyond the end of the payload."""
        room = self.layout.payload_size - offset
        if not 0 < room < len(body):
            return body
        self.clipped += 1
        return body[:room]

    def _place(self, offset: int, data: memoryview) -> None:
        end = offset + len(data)
        if offset < 0 or end > self.layout.payload_size:
            raise RemoteProtocolError(f"data up to byte {end} of a payload of {self.layout.payload_size}")
        if self.buffer is not None and not self.refused:
            self.buffer[offset:end] = data
        self.extent = max(self.extent, end)

    # -- account ---------------------------------------------------------------------------------
    def has(self, packet_id: int) -> bool:
        """Whether a packet was received."""
        return packet_id < len(self.received) and bool(self.received[packet_id])

    def make_room(self, packets: int) -> None:
        """Let `received` cover at least so many packets."""
        if packets > len(self.received):
            self.received = grown(self.received, packets)

    def note_received(self, ids: Ids, count: int, highest: int, now: float) -> None:
        """Note `count` packets, none received before; `received` covers the `highest` of them."""
        self.received[ids] = 1
        self.received_count += count
        self.highest = max(self.highest, highest)
        self.last_packet_at = now

    def missing(self, end: int) -> NDArray[np.intp]:
        """Ids up to and including `end` of packets not received."""
        self.make_room(end + 1)
        ids: NDArray[np.intp] = np.flatnonzero(self.received[: end + 1] == 0)
        return ids

    @property
    def only_leader(self) -> bool:
        """Whether only the leader was received: some devices send it when acquisition starts."""
        return self.received_count == 1 and self.leader is not None and self.trailer is None

    def payload_packets(self) -> int | None:
        """Number of the block's payload packets; None while unknown."""
        if self.trailer_id is not None:
            return self.trailer_id - 1
        leader = self.leader
        if leader is None or self.refused:  # a refused leader may announce any number
            return None
        if leader.kind == PayloadKind.MULTI_PART or leader.payload_bytes is None:
            return None
        return -(-leader.payload_bytes // self.layout.stride)

    def last_packet_id(self) -> int:
        """Packet id of the trailer, at most, while neither leader nor trailer says it."""
        if self.trailer_id is not None:
            return self.trailer_id
        packets = self.payload_packets()
        return (self.layout.max_payload_packets if packets is None else packets) + 1

    def all_received(self) -> bool:
        """Whether all that matters was received; only the trailer may lack, where it has nothing to add."""
        if self.leader is None or self.refused:
            return False
        if self.trailer_id is not None:
            return self.received_count == self.trailer_id + 1
        packets = self.payload_packets()
        return packets is not None and self.received_count == packets + 1 and self.highest == packets

    def _ends_without_trailer(self) -> bool:
        """Return whether a short last packet shows where chunks end, as a lost trailer would have."""
        leader = self.leader
        return (
            leader is not None
            and not self.refused
            and self.trailer_id is None
            and leader.has_chunks
            and self.ended_short
            and self.extent >= leader.image_bytes
            and self.received_count == self.highest + 1
        )

    def packet_period(self, now: float) -> float:
        """Mean seconds from packet to packet."""
        return (now - self.first_packet_at) / max(self.highest, 1)

    # -- result ----------------------------------------------------------------------------------
    def close(self) -> None:
        """Decide whether the block is complete; no packet is stored afterwards."""
        self.complete = self.all_received() or self._ends_without_trailer()

    def extract_payload(self, leader: Leader) -> None:
        """Make `payload` of a closed block that has a buffer; `leader` is its own, or if lost a similar one.

        What did not arrive is zero, so that no earlier image shows through.
        """
        assert self.buffer is not None
        begin, end = self._payload_extent(leader, len(self.buffer))
        self.height = leader.height
        lines = self.trailer.height if self.trailer is not None else 0
        if self.complete and 0 < lines < leader.height:
            self.height = lines
        if not self.complete:
            end = min(max(end, begin + leader.image_bytes), len(self.buffer))
            if self.leader is None or not self.leader.parts:
                self.missing_bytes = self._blank_missing(self.buffer[:end])
        self.leader, self.payload = leader, self.buffer[begin:end]

    def _payload_extent(self, leader: Leader, size: int) -> tuple[int, int]:
        """Return where in the buffer the result begins and ends."""
        before = 0
        for part in leader.parts:
            if part.is_image:
                return before, min(before + part.length, size)
            before += part.length
        if self.trailer is not None and self.trailer.payload_bytes and not leader.parts:
            return 0, min(self.trailer.payload_bytes, size)
        return 0, self.extent

    def _blank_missing(self, payload: NDArray[np.uint8]) -> int:
        """Zero the packets that did not arrive; return how many bytes these are."""
        stride = self.layout.stride
        packets = -(-len(payload) // stride)
        received = np.zeros(packets + 1, np.uint8)
        known: NDArray[Any] = self.received[: packets + 1]
        received[: len(known)] = known
        blanked = 0
        for first, last in id_runs(np.flatnonzero(received[1:] == 0)):
            hole = payload[first * stride : (last + 1) * stride]
            hole[:] = 0
            blanked += len(hole)
        return blanked
