"""One block while its packets arrive: which came, which are missing, which were asked for."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.errors import RemoteProtocolError
from grabbergui.core.grabber import StreamStatistics
from grabbergui.driver.gige.gvsp import (
    CHUNK_BIT,
    Leader,
    PacketFormat,
    PacketHeader,
    PartPosition,
    PayloadKind,
    Trailer,
)

NEVER = float("inf")
Ids = slice | NDArray[np.intp]
"Packet ids: `slice` where they are consecutive, which is faster."
NO_IDS = np.zeros(0, np.intp)

SCATTERED = 4
"Packets in a row, in the mean, below which they are placed one by one: numpy does that in one step."


class RequestLog:
    """Which packets of a block were asked for, and when. Empty, and free of cost, where none was."""

    def __init__(self) -> None:
        self.tries = np.zeros(0, np.uint8)
        "Requests for each packet, by packet id."
        self.missed_at = np.zeros(0)
        "When it did not come in its turn; minus infinity where that was not noticed."
        self.first_at = np.zeros(0)
        "When the first request left."
        self.again_at = np.zeros(0)
        "When it is time for the next."
        self.next_check = NEVER
        "When it is time for the first of those not asked for yet, or for a further try."
        self.checked = -NEVER
        "When it was last looked which it is time for."
        self.tail_checked = -NEVER
        "The block's `last_packet_at` when its end was last looked at."

    def make_room(self, packets: int) -> None:
        """Hold at least so many packets."""
        if len(self.tries) < packets:
            known = len(self.tries)
            self.tries = _grown(self.tries, packets - 1)
            self.missed_at = _grown(self.missed_at, packets - 1)
            self.missed_at[known:] = -NEVER
            self.first_at = _grown(self.first_at, packets - 1)
            self.again_at = _grown(self.again_at, packets - 1)

    def note(self, ids: NDArray[np.intp], now: float, wait: float) -> None:
        """These packets are asked for; each try waits twice as long as the one before."""
        tries = self.tries[ids]
        self.first_at[ids] = np.where(tries == 0, now, self.first_at[ids])
        self.again_at[ids] = now + np.ldexp(wait, tries)
        self.tries[ids] = tries + 1


class Block:
    """The packets of one block. Packet ids: 0 the leader, then payload, last the trailer."""

    def __init__(
        self, block_id: int, extended: bool, buffer: NDArray[np.uint8] | None, packets: int, now: float
    ):
        self.block_id = block_id
        self.extended = extended
        self.buffer = buffer
        "None where no buffer was free: the block is only counted."
        self.began = now
        "When its first packet came."
        self.leader: Leader | None = None
        self.trailer: Trailer | None = None
        self.last_id: int | None = None
        "Packet id of the trailer, once it came."
        self.refused = False
        "Whether it is no picture, or larger than the buffer: nothing of it is kept or asked for."
        self.received = np.zeros(packets, np.uint8)
        "1 for each packet that came, by packet id."
        self.count = 0
        "How many came."
        self.highest = -1
        "Highest packet id that came."
        self.extent = 0
        "End of the data that came, in bytes from the start of the payload."
        self.ended_short = False
        "Whether the packet at `extent` was shorter than a full one, so nothing follows it."
        self.last_packet_at = now
        self.asked = RequestLog()

    def holds(self, packet_id: int) -> bool:
        """Whether a packet came already."""
        return packet_id < len(self.received) and bool(self.received[packet_id])

    def make_room(self, packets: int) -> None:
        """Note so many packets at least."""
        if packets > len(self.received):
            self.received = _grown(self.received, packets - 1)

    def mark(self, ids: Ids, count: int, highest: int, now: float) -> None:
        """Note that `count` packets came, none of them before, up to `highest`, for which there is room."""
        self.received[ids] = 1
        self.count += count
        self.highest = max(self.highest, highest)
        self.last_packet_at = now

    def place(self, offset: int, data: memoryview) -> None:
        """Put data into the payload, `offset` bytes from its start."""
        end = offset + len(data)
        if self.buffer is not None and not self.refused:
            self.buffer[offset:end] = data
        self.extent = max(self.extent, end)

    def place_in_turn(self, first: int, rows: NDArray[np.uint8]) -> None:
        """Put full payload packets from `first` on into the payload, one a row. The last must fit."""
        begin, end = (first - 1) * rows.shape[1], (first - 1 + len(rows)) * rows.shape[1]
        if self.buffer is not None and not self.refused:
            self.buffer[begin:end].reshape(rows.shape)[...] = rows
        self.extent = max(self.extent, end)

    def place_rows(
        self, ids: NDArray[np.intp], highest: int, rows: NDArray[np.uint8], at: NDArray[np.intp] | None
    ) -> None:
        """Put full payload packets where their ids say, one a row, or the i-th from row `at[i]`.

        The `highest` of them must fit.
        """
        end = highest * rows.shape[1]
        if self.buffer is not None and not self.refused:
            lines = self.buffer[:end].reshape(-1, rows.shape[1])
            breaks = ids[1:] - ids[:-1] != 1
            if at is not None:
                breaks |= at[1:] - at[:-1] != 1
            begins = [0, *(breaks.nonzero()[0] + 1).tolist()]
            if SCATTERED * len(begins) > len(ids):
                lines[ids - 1] = rows if at is None else rows[at]
            else:
                for begin, stop in zip(begins, [*begins[1:], len(ids)], strict=True):
                    line, row = int(ids[begin]) - 1, begin if at is None else int(at[begin])
                    lines[line : line + stop - begin] = rows[row : row + stop - begin]
        self.extent = max(self.extent, end)

    def payload_packets(self, stride: int) -> int | None:
        """How many payload packets make up the block, where that is known."""
        if self.last_id is not None:
            return self.last_id - 1
        leader = self.leader
        if leader is None or self.refused:  # a leader that was refused may announce any number
            return None
        if leader.kind == PayloadKind.MULTI_PART or leader.payload_bytes is None:
            return None
        return -(-leader.payload_bytes // stride)

    def complete(self, stride: int) -> bool:
        """Whether all that matters came; a trailer that says nothing new is not waited for."""
        if self.leader is None or self.refused:
            return False
        if self.last_id is not None:
            return self.count == self.last_id + 1
        packets = self.payload_packets(stride)
        return packets is not None and self.count == packets + 1 and self.highest == packets

    def all_arrived(self) -> bool:
        """Chunks end where the trailer says; where it was lost, a short last packet says the same."""
        leader = self.leader
        return (
            leader is not None
            and not self.refused
            and self.last_id is None
            and leader.has_chunks
            and self.ended_short
            and self.extent >= leader.image_bytes
            and self.count == self.highest + 1
        )

    def packet_period(self, now: float) -> float:
        """Seconds from packet to packet, in the mean."""
        return (now - self.began) / max(self.highest, 1)

    def missing(self, end: int) -> NDArray[np.intp]:
        """Ids up to and including `end` of packets that did not come."""
        if end >= len(self.received):
            self.received = _grown(self.received, end)
        ids: NDArray[np.intp] = np.flatnonzero(self.received[: end + 1] == 0)
        return ids

    @property
    def only_leader(self) -> bool:
        """Some devices send it when acquisition starts, long before the rest."""
        return self.count == 1 and self.leader is not None and self.trailer is None


def _grown(array: NDArray[Any], index: int) -> NDArray[Any]:
    """A copy with room for `index`."""
    larger = np.zeros(max(index + 1, 2 * len(array)), array.dtype)
    larger[: len(array)] = array
    return larger


def runs(ids: NDArray[np.intp]) -> Iterator[tuple[int, int]]:
    """Sorted ids as (first, last) of consecutive ones."""
    if len(ids):
        breaks = np.flatnonzero(np.diff(ids) != 1)
        firsts = ids[np.concatenate([[0], breaks + 1])]
        lasts = ids[np.concatenate([breaks, [len(ids) - 1]])]
        yield from zip(firsts.tolist(), lasts.tolist(), strict=True)


def ends(ids: NDArray[np.intp]) -> NDArray[np.intp]:
    """Of each of sorted ids, which id is the first behind it that is not one of them."""
    breaks = (ids[1:] - ids[:-1] != 1).nonzero()[0]
    if len(breaks) == len(ids) - 1:  # as mostly
        return ids + 1
    lasts = np.append(breaks, len(ids) - 1)
    return np.repeat(ids[lasts] + 1, np.diff(lasts, prepend=-1))


def distance(older: int, newer: int, extended: bool) -> int:
    """How many blocks `newer` is after `older`; negative where it is before.

    Standard ids go from 65535 to 1, so there are 65535 of them.
    """
    if extended:
        return newer - older
    steps = (newer - older) % 0xFFFF
    return steps - 0xFFFF if steps > 0x7FFF else steps


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


@dataclass(frozen=True)
class FinishedBlock:
    """A block, complete or given up."""

    block_id: int
    leader: Leader
    payload: NDArray[np.uint8]
    "In the caller's buffer: the whole payload, or of a multi-part block its first picture."
    height: int
    "Lines that were really sent."
    missing_bytes: int
    complete: bool
    began: float
    "When its first packet came."


def finish(block: Block, leader: Leader, stride: int, *, complete: bool) -> FinishedBlock:
    """The result of a block that has a buffer. `leader` is its own or, where that was lost, another's.

    What did not arrive is zeros.
    """
    assert block.buffer is not None
    size = len(block.buffer)
    begin, end = _extent(block, leader, size)
    height = leader.height
    lines = block.trailer.height if block.trailer is not None else 0
    if 0 < lines < height and complete:
        height = lines
    missing_bytes = 0
    if not complete:
        end = min(max(end, begin + leader.image_bytes), size)
        missing_bytes = _blank_missing(block, block.buffer[:end], stride)
    payload = block.buffer[begin:end]
    return FinishedBlock(block.block_id, leader, payload, height, missing_bytes, complete, block.began)


def _extent(block: Block, leader: Leader, size: int) -> tuple[int, int]:
    """Where in the buffer the result begins and ends."""
    before = 0
    for part in leader.parts:
        if part.is_picture:
            return before, min(before + part.length, size)
        before += part.length
    if block.trailer is not None and block.trailer.payload_bytes and not leader.parts:
        return 0, min(block.trailer.payload_bytes, size)
    return 0, block.extent


def _blank_missing(block: Block, payload: NDArray[np.uint8], stride: int) -> int:
    """Zero what did not arrive, so that no earlier picture shines through; how many bytes that was."""
    if block.leader is not None and block.leader.parts:
        return 0
    blanked = 0
    packets = -(-len(payload) // stride)
    came = np.zeros(packets + 1, np.uint8)
    known = block.received[: packets + 1]
    came[: len(known)] = known
    for first, last in runs(np.flatnonzero(came[1:] == 0)):
        hole = payload[first * stride : (last + 1) * stride]
        hole[:] = 0
        blanked += len(hole)
    return blanked
