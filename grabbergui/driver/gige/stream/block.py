"""One block (GVSP's word for what becomes a frame) from its first packet to the result that is delivered."""

from __future__ import annotations

import logging
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.errors import RemoteProtocolError
from grabbergui.driver.gige.gvsp import (
    CHUNK_BIT,
    POSITIONED,
    GendcPosition,
    Leader,
    PartPosition,
    PayloadKind,
    Trailer,
    kind_in,
)
from grabbergui.driver.gige.packet_header import EXTENDED, STANDARD, PacketFormat, PacketHeader
from grabbergui.driver.gige.stream.block_buffer import BlockBuffer
from grabbergui.driver.gige.stream.block_layout import BlockLayout
from grabbergui.driver.gige.stream.gendc_flows import Flows
from grabbergui.driver.gige.stream.id_runs import id_runs
from grabbergui.driver.gige.stream.packet_sorting import Ids, PacketRun
from grabbergui.driver.gige.stream.resend import NEVER, BlockRequests, Resender, grown

log = logging.getLogger(__name__)

LEAST_STRIDE = 64
"Image bytes in a full packet, at least: a list of packets takes memory and time by their number."
TAIL = 8
"Packets requested behind the last that arrived, of a block whose end is unknown."
_ALL_IN_SIZES: dict[int, tuple[int, int]] = {
    PayloadKind.IMAGE: (36, 8),
    PayloadKind.RAW: (20, 4),
    PayloadKind.CHUNK: (12, 8),
    PayloadKind.EXTENDED_CHUNK: (36, 16),
    PayloadKind.JPEG: (32, 4),
    PayloadKind.JPEG2000: (32, 4),
}
"Bytes of leader and trailer in an all-in packet, without chunks."


@dataclass(frozen=True)
class Places:
    """Where a block's next packets belong if they arrive in order."""

    first: int
    "Id of the next packet; those from there on are missing."
    header_size: int
    "Bytes of a packet's header."
    lines: NDArray[np.uint8]
    "The data of all full packets, shape (packets, stride): of the packet with id 1 in the first line."

    @property
    def packet_length(self) -> int:
        """Bytes of a full packet."""
        return self.header_size + int(self.lines.shape[1])


class Block:
    """The packets of one block. Packet ids: 0 is the leader, then payload packets, the trailer is last.

    The assembler enters it once for each packet or batch: `take`, `take_in_order`, `take_placed` and
    `take_run` copy the data, account for the packets, and note the gaps before them, which `request` asks
    for. When no more packets are expected, `close` and `extract_payload` set the result: `leader`, `payload`,
    `height`, `complete`, `missing_bytes`.
    """

    def __init__(
        self,
        header: PacketHeader,
        layout: BlockLayout,
        resender: Resender,
        memory: NDArray[np.uint8] | None,
        now: float,
    ) -> None:
        """Begin the block of a packet. `memory` is None if none was free: the block is then only counted."""
        self.block_id = header.block_id
        self.extended = header.extended
        self.layout = layout
        self._stride = layout.stride
        "That of the packets stored so far."
        self._data = BlockBuffer(memory, layout.payload_size)
        self.received = np.zeros(layout.max_payload_packets + 2, np.uint8)
        "1 for each packet received, by packet id."
        self.received_count = 0
        self.highest = -1
        "Highest packet id received."
        self.first_packet_at = now
        self.last_packet_at = now
        self._policy = resender.policy
        self._requests = BlockRequests(resender)
        self._checked_at = -NEVER
        "Time of the last check for packets to request."
        self._tail_checked = -NEVER
        "`last_packet_at` when the block's end was last checked."
        self.leader: Leader | None = None
        "For an incomplete block this may be the leader of the previous block."
        self.trailer: Trailer | None = None
        self.trailer_id: int | None = None
        "Packet id of the trailer, once received."
        self.refused = False
        "True if the block is no image or exceeds the buffer: nothing is stored, no resend is requested."
        self._ended_short = False
        "Whether a packet was shorter than a full one, so nothing follows it."
        self.complete = False
        "Whether every byte arrived; set by `close`."
        self.payload: NDArray[np.uint8] = np.zeros(0, np.uint8)
        "In the block's memory: the whole payload; set by `extract_payload`."
        self.height = 0
        "Lines that the camera sent; set by `extract_payload`."
        self.missing_bytes = 0
        "Bytes of `payload` that did not arrive and are zero; set by `extract_payload`."
        self.timestamp = 0
        "Device ticks of an H.264 image, which its leader does not have."
        self._flows: Flows | None = None
        "Flows of a GenDC container; None for other payloads."

    @property
    def counted_only(self) -> bool:
        """Whether no buffer was free when the block began."""
        return self._data.memory is None

    @property
    def clipped(self) -> int:
        """Packets with padding beyond the end of the payload."""
        return self._data.clipped

    def take(self, header: PacketHeader, body: memoryview, now: float) -> int:
        """Take a packet that was not received before; return how many of one were resent.

        Raises RemoteProtocolError.
        """
        self._store(header, body)
        packet_id = header.packet_id
        self._make_room(packet_id + 1)
        return self._note(slice(packet_id, packet_id + 1), 1, packet_id, header.sent_again, now)

    def take_in_order(self, first: int, bodies: NDArray[np.uint8], now: float) -> int:
        """Take new full payload packets that follow each other from the `first` id on; the last must fit.

        Returns how many were resent.
        """
        self._data.place_in_order(first, bodies)
        return self._note_in_order(first, len(bodies), now)

    def take_placed(self, first: int, count: int, now: float) -> int:
        """Take new full packets whose data is in its `next_places` already; return how many were resent."""
        self._data.extent = max(self._data.extent, (first + count - 1) * self.layout.stride)
        return self._note_in_order(first, count, now)

    def take_run(self, run: PacketRun, rows: NDArray[np.uint8], at: NDArray[np.intp], now: float) -> int:
        """Take new full payload packets, the i-th of the run from `rows[at[i]]`; the highest must fit.

        Returns how many were resent.
        """
        self._data.place_run(run, rows, at)
        return self._note(run.places(), len(at), run.highest, run.resent, now)

    def _note_in_order(self, first: int, count: int, now: float) -> int:
        end = first + count
        self._make_room(end)
        return self._note(slice(first, end), count, end - 1, False, now)

    def _note(self, ids: Ids, count: int, highest: int, resent: NDArray[np.bool_] | bool, now: float) -> int:
        """Account for `count` new packets up to `highest`, and for the gaps before them."""
        answers = self._requests.note_received(ids, len(self.received), now, resent)
        expected = self.highest + 1
        self.received[ids] = 1
        self.received_count += count
        self.last_packet_at = now
        if highest < expected:
            return answers
        self.highest = highest
        if self._policy.enabled and not self.refused:
            begin = ids.start if isinstance(ids, slice) else highest
            if begin > expected:
                missing = expected + (self.received[expected:begin] == 0).nonzero()[0]
                if len(missing):
                    self._requests.note_missing(missing, len(self.received), highest, self._period(now), now)
        return answers

    def _period(self, now: float) -> float:
        """Return the mean time between packets in seconds."""
        return (now - self.first_packet_at) / max(self.highest, 1)

    def _make_room(self, packets: int) -> None:
        """Grow `received` to at least `packets` entries."""
        if packets > len(self.received):
            self.received = grown(self.received, packets)

    def has(self, packet_id: int) -> bool:
        """Return whether a packet was received."""
        return packet_id < len(self.received) and bool(self.received[packet_id])

    def has_any(self, first: int, end: int) -> bool:
        """Return whether one of the packets from `first` up to `end` was received."""
        return bool(self.received[first:end].any())

    def new_of(self, run: PacketRun) -> NDArray[np.bool_] | None:
        """Return which packets of a run were not received before; None if that is so for all."""
        self._make_room(run.highest + 1)
        if run.increasing and not self.received[run.places()].any():
            return None
        new: NDArray[np.bool_] = (self.received[run.ids] == 0) & run.first_occurrences()
        return new

    def missing(self, end: int) -> NDArray[np.intp]:
        """Return the ids of missing packets up to and including `end`."""
        self._make_room(end + 1)
        ids: NDArray[np.intp] = np.flatnonzero(self.received[: end + 1] == 0)
        return ids

    def note_duplicate(self, packet_id: int) -> None:
        """Note that a packet arrived again."""
        self._requests.note_duplicate(packet_id)

    def note_unavailable(self, packet_id: int) -> None:
        """Note that the device no longer has a packet: it is not requested again."""
        self._requests.note_unavailable(packet_id)

    def check_by(self, time: float) -> None:
        """Check for missing packets at this time at the latest."""
        self._requests.next_check = min(self._requests.next_check, time)

    def check_time(self, *, arriving: bool) -> float:
        """Return when to check for packets to request; with `arriving`, more arrive without a request."""
        if not self._policy.enabled or self.refused:
            return NEVER
        check = self._requests.next_check
        if arriving:
            check = max(check, self._checked_at + self._policy.look_again)
        if not self.only_leader and self.last_packet_at > self._tail_checked:
            # The end of the last block may be lost, with nothing after it to show the gap.
            check = min(check, self.last_packet_at + self._policy.tail_wait)
        return check

    def give_up_time(self, *, overtaken: bool) -> float:
        """Return when to finish the block if nothing more arrives; `overtaken`: a later block has begun."""
        if self.only_leader and not overtaken:
            return NEVER
        requesting = self._policy.enabled and self._requests.next_check != NEVER
        patience = self._policy.reorder_wait if overtaken and not requesting else self._policy.give_up
        return self.last_packet_at + patience

    def request(self, now: float, *, overtaken: bool) -> None:
        """Request the missing packets that are due."""
        silent = now >= self.last_packet_at + self._policy.tail_wait
        if silent:
            self._tail_checked = self.last_packet_at
        self._checked_at = now
        missing = self.missing(self.last_packet_id() if silent or overtaken else self.highest)
        self._requests.request_due(self.block_id, self.extended, missing, len(self.received), now)

    def next_places(self) -> Places | None:
        """Return where the next packets belong, as long as full packets of an image are expected."""
        packets, stride, memory = self.payload_packets(), self.layout.stride, self._data.memory
        if packets is None or memory is None or self.trailer_id is not None or self.highest < 0:
            return None
        full = min(packets, self.layout.payload_size // stride)
        if self.highest >= full:
            return None
        size = (EXTENDED if self.extended else STANDARD).itemsize
        return Places(self.highest + 1, size, memory[: full * stride].reshape(full, stride))

    def _store(self, header: PacketHeader, body: memoryview) -> None:
        """Copy a packet's content to where it belongs. Raises RemoteProtocolError."""
        packet_id = header.packet_id
        if header.format == PacketFormat.PAYLOAD:
            self._check_length(packet_id, len(body))
            offset = self._offset_of(packet_id)
            self._data.place(offset, body)
            if len(body) < self.layout.stride:
                self._ended_short = True
                self._data.leave(offset + len(body), offset + self.layout.stride)
        elif packet_id != 0 and header.format in (PacketFormat.LEADER, PacketFormat.ALL_IN):
            raise RemoteProtocolError(f"a leader with packet_id {packet_id}, its id is 0")
        elif header.format == PacketFormat.LEADER:
            self._take_leader(body)
        elif header.format == PacketFormat.TRAILER:
            self._take_trailer(packet_id, body)
        elif header.format in (PacketFormat.MULTI_PART, PacketFormat.MULTI_ZONE):
            position = PartPosition.decode(body)
            self._data.place_piece(packet_id, self._offset_in_block(position), body[PartPosition.SIZE :])
        elif header.format == PacketFormat.GENDC:
            self._take_gendc(packet_id, body)
        elif header.format == PacketFormat.H264:
            # Packets may be short, so each has a slot of its own until all are joined.
            self.timestamp = int.from_bytes(body[:8], "big")
            self._data.place_piece(packet_id, self._offset_of(packet_id), body[8:])
        elif header.format == PacketFormat.ALL_IN:
            self._take_all_in(body)
        else:
            raise RemoteProtocolError(f"a packet of format {header.format}, which carries no image")

    def _take_leader(self, body: memoryview) -> None:
        self.leader = leader = Leader.decode(body)
        if not leader.is_known:
            self._refuse(
                f"the camera sends {leader.kind_name} (payload type 0x{leader.payload_type:04X})",
                "no frame can be made of it; let the camera send images, by ComponentEnable, PayloadType or"
                " a plain PixelFormat",
            )
        elif max(leader.image_bytes, leader.payload_bytes or 0) > self.layout.payload_size:
            needed = max(leader.image_bytes, leader.payload_bytes or 0)
            size = f"{leader.width}x{leader.height}, pixel format 0x{leader.pixel_format:08X}"
            self._refuse(
                "the camera sends a frame that does not fit",
                f"payload type 0x{leader.payload_type:04X}, {size if leader.is_image else leader.kind_name},"
                f" {leader.payload_bytes or leader.image_bytes} bytes; PayloadSize is"
                f" {self.layout.payload_size} bytes: stop the stream and start it again; if that does not"
                f" help, the camera reports it wrongly: open it with payload_size={needed}",
            )

    def _refuse(self, fault: str, details: str) -> None:
        """Store and request nothing more of the block."""
        self.refused = True
        self._data.writable = False
        self.layout.refusal = f"{fault}: {details}"
        self.layout.warn_once(fault, details)

    def _take_trailer(self, packet_id: int, body: memoryview) -> None:
        trailer = Trailer.decode(body)
        if packet_id < max(self.highest, 1):
            raise RemoteProtocolError(f"trailer with packet_id {packet_id} after packet {self.highest}")
        self.trailer, self.trailer_id = trailer, packet_id
        offset = self._offset_of(packet_id)
        self._data.leave(offset, offset + self.layout.stride)

    def _take_gendc(self, packet_id: int, body: memoryview) -> None:
        piece = GendcPosition.decode(body)
        data = body[GendcPosition.FORMAT.size :][: piece.size]
        if self.refused:
            return
        if self._flows is None:
            self._flows = Flows(self.layout.payload_size)
        try:
            for known_id, offset, placed in self._flows.take(packet_id, piece, data):
                self._data.place_piece(known_id, offset, placed)
        except RemoteProtocolError as error:
            self._refuse("a GenDC container", str(error))

    def _offset_of(self, packet_id: int) -> int:
        """Return where the data of a packet without a position of its own belongs."""
        return (packet_id - 1) * self.layout.stride

    def _offset_in_block(self, position: PartPosition) -> int:
        parts = self.leader.parts if self.leader is not None else ()
        start = sum(part.length for part in parts[: position.part])
        if position.offset < start:
            self.layout.relative_parts = True
        return position.offset + (start if self.layout.relative_parts else 0)

    def _take_all_in(self, body: memoryview) -> None:
        payload_type = int.from_bytes(body[2:4], "big")
        sizes = _ALL_IN_SIZES.get(kind_in(payload_type))
        if sizes is None:
            raise RemoteProtocolError(f"an all-in packet of payload type 0x{payload_type:04X}")
        leader_size, trailer_size = sizes
        if payload_type & CHUNK_BIT:
            trailer_size += 8
        self._take_leader(body[:leader_size])
        self.trailer = Trailer.decode(body[leader_size : leader_size + trailer_size])
        self.trailer_id = 0
        self._data.place(0, body[leader_size + trailer_size :])

    def _check_length(self, packet_id: int, length: int) -> None:
        """Learn the stride from an image's first packet: it may differ from the register's value."""
        stride, leader = self.layout.stride, self.leader
        size = 0 if leader is None else max(leader.payload_bytes or 0, leader.image_bytes)
        if packet_id == 1 and LEAST_STRIDE <= length < size and length != stride:
            log.info("packets carry %d bytes instead of %d", length, stride)
            self.layout.stride = length
            if not self._data.extent:
                self._stride = length
        elif not 0 < length <= stride:
            raise RemoteProtocolError(f"a packet with {length} bytes of payload, {stride} are a full one")

    @property
    def only_leader(self) -> bool:
        """Whether only the leader was received: some devices send one when acquisition starts."""
        return self.received_count == 1 and self.leader is not None and self.trailer is None

    def payload_packets(self) -> int | None:
        """Return the number of the block's payload packets; None while unknown."""
        if self.trailer_id is not None:
            return self.trailer_id - 1
        leader = self.leader
        if leader is None or self.refused:  # a refused leader may announce any number
            return None
        if leader.kind in POSITIONED or leader.payload_bytes is None:
            return None
        return -(-leader.payload_bytes // self.layout.stride)

    def last_packet_id(self) -> int:
        """Return the trailer's packet id, or an upper bound until leader or trailer determine it."""
        if self.trailer_id is not None:
            return self.trailer_id
        packets, leader, stride = self.payload_packets(), self.leader, self.layout.stride
        if packets is None:
            packets = self.layout.max_payload_packets
            if leader is not None and leader.payload_bytes:
                # Each packet has a header of its own, and a part begins with a packet.
                length = min(leader.payload_bytes, self.layout.payload_size)
                packets = -(-length // max(stride - GendcPosition.FORMAT.size, 1)) + len(leader.parts)
            elif leader is not None and not leader.is_image:
                # Data of any length, such as chunks or a compressed image: look a little beyond what arrived.
                packets = min(packets, max(self.highest + TAIL, -(-leader.size // stride)))
        return packets + 1

    def all_received(self) -> bool:
        """Return whether the block is complete; a trailer without information of its own may be missing."""
        if self.leader is None or self.refused:
            return False
        if self.trailer_id is not None:
            return self.received_count == self.trailer_id + 1 > self.highest
        packets = self.payload_packets()
        return packets is not None and self.received_count == packets + 1 and self.highest == packets

    def _ends_without_trailer(self) -> bool:
        """Return whether a short last packet shows where chunks end, as a lost trailer would have."""
        leader = self.leader
        return (
            leader is not None
            and not self.refused
            and self.trailer_id is None
            and leader.payload_bytes is None
            and leader.kind not in POSITIONED
            and self._ended_short
            and self._data.extent >= leader.image_bytes
            and self.received_count == self.highest + 1
        )

    def close(self) -> None:
        """Decide whether the block is complete; no packet is stored afterwards."""
        if self._stride != self.layout.stride:  # packets are in wrong places
            self.refused = True
        foreign = self._data.has_pieces and self.leader is not None and self.leader.kind not in POSITIONED
        self.complete = not foreign and (self.all_received() or self._ends_without_trailer())

    def extract_payload(self, leader: Leader) -> None:
        """Make `payload` of a closed block that has a buffer; `leader` is its own, or if lost a similar one.

        What did not arrive is zero, so that no earlier image shows through.
        """
        data, memory = self._data, self._data.memory
        assert memory is not None
        if leader.kind == PayloadKind.H264:
            data.join_pieces()
        end = self._payload_end(leader, len(memory))
        self.height = leader.height
        lines = self.trailer.height if self.trailer is not None else 0
        if not leader.height and leader.is_image:
            self.height = lines or end // max(leader.line_bytes, 1)
        elif self.complete and 0 < lines < leader.height:
            self.height = lines
        if not self.complete:
            end = min(max(end, leader.image_bytes, leader.payload_bytes or 0), len(memory))
            if leader.kind in POSITIONED or data.has_pieces:
                self.missing_bytes = data.blank_gaps(end)
            else:
                self.missing_bytes = data.blank(end, self._missing_places(end))
        elif leader.kind not in POSITIONED:
            data.blank(end)
        self.leader, self.payload = leader, memory[:end]

    def _payload_end(self, leader: Leader, size: int) -> int:
        """Return where in the buffer the payload ends."""
        extent = self._data.extent
        if self.trailer is not None and self.trailer.payload_bytes and not leader.parts:
            return min(self.trailer.payload_bytes, extent if self.complete else size)
        if leader.payload_bytes and not leader.is_image and self.complete:
            return min(leader.payload_bytes, extent)  # a last packet may be padded
        return extent

    def _missing_places(self, end: int) -> list[tuple[int, int]]:
        """Return begin and end of the places of missing packets, up to the byte `end` of the payload."""
        stride = self.layout.stride
        ids = self.missing(-(-end // stride))
        return [((first - 1) * stride, last * stride) for first, last in id_runs(ids[ids > 0])]  # 0: leader
