"""Packets to blocks, gaps to requests: the stream channel as a machine without I/O.

It reads no clock and opens no socket; times are seconds of any monotonic clock. Its driver feeds datagrams,
sends what `resend_requests()` gives, and takes what `finished()` gives. Memory is bounded: a handful of open
blocks, each in a buffer of the caller's pool. One thread.
"""

from __future__ import annotations

import logging
from collections import OrderedDict, deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.errors import RemoteProtocolError
from grabbergui.core.grabber import StreamStatistics
from grabbergui.driver.gige.block import NEVER, Block, ResendPolicy, distance, runs
from grabbergui.driver.gige.gvcp import PacketResend, Status
from grabbergui.driver.gige.gvsp import (
    CHUNK_BIT,
    FLAG_RESEND,
    Leader,
    PacketFormat,
    PacketHeader,
    PartPosition,
    PayloadKind,
    Trailer,
)

log = logging.getLogger(__name__)

RESTART_DISTANCE = 100
"A block id that jumps back so far, or this far times a hundred ahead, belongs to a new stream."
REMEMBERED = 16
"Finished blocks whose late packets are still recognised."
GONE = (Status.PACKET_UNAVAILABLE, Status.PACKET_AND_PREVIOUS_REMOVED, Status.PACKET_REMOVED)
"The device says that it cannot resend."


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


@dataclass(frozen=True)
class Landing:
    """Where the payload of the next packets belongs, if nothing is lost: full packets of one block only."""

    block: Block
    first: int
    "Packet id of the first."
    count: int
    stride: int
    "Bytes of each."
    address: int
    "Of the memory that the first belongs to."

    @property
    def extended(self) -> bool:
        """Whether the packets have extended headers."""
        return self.block.extended


class BlockAssembler:
    """One stream channel's packets."""

    def __init__(
        self,
        stride: int,
        payload_size: int,
        take_buffer: Callable[[], NDArray[np.uint8] | None],
        policy: ResendPolicy | None = None,
        *,
        deliver_incomplete: bool = False,
    ) -> None:
        """`stride`: image bytes in a full packet; `payload_size`: bytes of a buffer, the largest payload."""
        self.stride = stride
        self.payload_size = payload_size
        self.policy = policy or ResendPolicy()
        self.statistics = StreamStatistics()
        "Counters; the rates in it stay 0."
        self._take_buffer = take_buffer
        self._deliver_incomplete = deliver_incomplete
        self._open: list[Block] = []
        "In the order of their ids."
        self._began: dict[int, float] = {}
        self._recent: OrderedDict[int, NDArray[np.uint8]] = OrderedDict()
        self._last_finished: int | None = None
        self._late_leader: int | None = None
        self._previous_leader: Leader | None = None
        self._finished: deque[FinishedBlock] = deque()
        self._requests: deque[PacketResend] = deque()
        self._due = NEVER
        self._told: set[str] = set()

    # -- packets ---------------------------------------------------------------------------------
    def receive(self, datagram: bytes | memoryview, now: float) -> None:
        """Take one datagram; its payload is copied into the block's buffer. Never raises."""
        try:
            header = PacketHeader.decode(datagram)
            if header.block_id == 0:
                return  # a test packet
            self._receive(header, memoryview(datagram)[header.size :], now)
        except RemoteProtocolError as error:
            self.statistics.packets_ignored += 1
            self._tell_once("a malformed stream packet", str(error))

    def landing(self, limit: int) -> Landing | None:
        """Where up to `limit` packets may be received directly; None where only `receive` will do.

        To be used before anything else is received. What lands there counts only once `landed` says so.
        """
        if not self._open:
            return None
        block = self._open[-1]
        leader = block.leader
        if leader is None or block.buffer is None or block.refused or leader.kind != PayloadKind.IMAGE:
            return None
        first = block.highest + 1
        count = min(limit, leader.image_bytes // self.stride - first + 1)
        if count <= 0:
            return None
        address = block.buffer.ctypes.data + (first - 1) * self.stride
        return Landing(block, first, count, self.stride, address)

    def landed(self, landing: Landing, count: int, now: float) -> None:
        """The first `count` packets of a landing came as expected."""
        if not count:
            return
        block = landing.block
        block.mark_run(landing.first, count, now)
        block.extent = max(block.extent, (landing.first - 1 + count) * landing.stride)
        self.statistics.packets += count
        if block.complete(self.stride):
            self._finish_ready()

    def _receive(self, header: PacketHeader, body: memoryview, now: float) -> None:
        block = self._block_of(header, now)
        if block is None:
            return
        self.statistics.packets += 1
        if header.failed:
            if header.status in GONE:
                block.give_up_on(header.packet_id, self.policy)
            return
        if block.holds(header.packet_id):
            self.statistics.packets_duplicate += 1
            return
        if header.packet_id > self.payload_size // 16 + 64:
            raise RemoteProtocolError(f"packet_id {header.packet_id} in a block of {self.payload_size} bytes")
        previous = block.highest
        self._store(block, header, body)
        was_asked_for = block.mark(header.packet_id, now)
        if was_asked_for or header.flags & FLAG_RESEND or header.status == Status.PACKET_RESEND:
            self.statistics.packets_resent += 1
        if header.packet_id > previous + 1:
            self._notice_gap(block, now)
        if block.complete(self.stride):
            self._finish_ready()

    def _store(self, block: Block, header: PacketHeader, body: memoryview) -> None:
        if header.format == PacketFormat.PAYLOAD:
            self._check_stride(block, header.packet_id, len(body))
            self._place(block, (header.packet_id - 1) * self.stride, body)
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
        needed = (
            max(leader.image_bytes, leader.payload_bytes or 0) if leader.is_picture else self.payload_size + 1
        )
        if needed > self.payload_size:
            block.refused = True
            self._tell_once(
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

    def _place(self, block: Block, offset: int, data: memoryview) -> None:
        end = offset + len(data)
        if offset < 0 or end > self.payload_size:
            raise RemoteProtocolError(f"data up to byte {end} of a payload of {self.payload_size}")
        if block.buffer is not None and not block.refused:
            block.buffer[offset:end] = data
        block.extent = max(block.extent, end)

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

    # -- blocks ----------------------------------------------------------------------------------
    def _block_of(self, header: PacketHeader, now: float) -> Block | None:
        for block in reversed(self._open):
            if block.block_id == header.block_id:
                return block
        if header.block_id in self._recent:
            self._note_late(header)
            return None
        last = self._last_finished
        if last is not None:
            steps = distance(last, header.block_id, header.extended)
            if steps <= -RESTART_DISTANCE or steps > 100 * RESTART_DISTANCE or self._restarted(header):
                self._restart()
            elif steps <= 0:
                self.statistics.packets_ignored += 1
                return None
        return self._begin(header, now)

    def _note_late(self, header: PacketHeader) -> None:
        """A packet of a block that is finished: its trailer, a duplicate, or too late."""
        received = self._recent[header.block_id]
        self.statistics.packets += 1
        if header.packet_id < len(received) and not header.failed:
            self.statistics.packets_duplicate += int(received[header.packet_id])
            received[header.packet_id] = 1

    def _restarted(self, header: PacketHeader) -> bool:
        """Whether ids began anew not far back: two leaders in a row say so."""
        if header.format not in (PacketFormat.LEADER, PacketFormat.ALL_IN):
            return False
        assert self._last_finished is not None
        if distance(self._last_finished, header.block_id, header.extended) > 0:
            self._late_leader = None
            return False
        previous, self._late_leader = self._late_leader, header.block_id
        return previous is not None and distance(previous, header.block_id, header.extended) == 1

    def _restart(self) -> None:
        self.flush()
        self._recent.clear()
        self._last_finished = self._late_leader = None

    def _begin(self, header: PacketHeader, now: float) -> Block:
        buffer = self._take_buffer()
        if buffer is None:
            self.statistics.underruns += 1
        packets = -(-self.payload_size // self.stride) + 2
        block = Block(header.block_id, header.extended, buffer, packets, now)
        if self._open and self._open[0].extended != header.extended:
            self.flush()
        index = len(self._open)
        while index and distance(self._open[index - 1].block_id, block.block_id, block.extended) < 0:
            index -= 1
        self._open.insert(index, block)
        self._began[block.block_id] = now
        if len(self._open) > self.policy.max_blocks:
            self._finish(self._open[0])
            self._finish_ready()
        self._due = min(self._due, now + self.policy.reorder_wait)
        if len(self._open) > 1:
            self._notice_gap(self._open[0], now)
        return block

    def _finish_ready(self) -> None:
        """Finish complete blocks in order; one that waits for packets holds back those after it."""
        while self._open and self._open[0].complete(self.stride):
            self._finish(self._open[0])

    def _finish(self, block: Block) -> None:
        self._open.remove(block)
        began = self._began.pop(block.block_id)
        self._remember(block)
        if block.buffer is None:
            return
        leader = block.leader
        complete = block.complete(self.stride) or self._all_arrived(block)
        if not complete:
            self.statistics.incomplete += 1
            self.statistics.packets_missing += len(block.missing(self._last_packet(block)))
            if not self._deliver_incomplete:
                return
            leader = leader or self._previous_leader
        if leader is None or block.refused or not leader.is_picture:
            return
        self._previous_leader = leader
        self._finished.append(self._result(block, leader, complete, began))

    def _all_arrived(self, block: Block) -> bool:
        """Chunks end where the trailer says; where it was lost, a short last packet says the same."""
        leader = block.leader
        return (
            leader is not None
            and not block.refused
            and block.last_id is None
            and leader.has_chunks
            and block.ended_short
            and block.extent >= leader.image_bytes
            and block.count == block.highest + 1
        )

    def _result(self, block: Block, leader: Leader, complete: bool, began: float) -> FinishedBlock:
        assert block.buffer is not None
        begin, end = 0, block.extent
        if leader.parts:
            before = 0
            for part in leader.parts:
                if part.is_picture:
                    begin, end = before, min(before + part.length, self.payload_size)
                    break
                before += part.length
        elif block.trailer is not None and block.trailer.payload_bytes:
            end = min(block.trailer.payload_bytes, self.payload_size)
        height = leader.height
        lines = block.trailer.height if block.trailer is not None else 0
        if 0 < lines < height and complete:
            height = lines
        missing_bytes = 0
        if not complete:
            end = min(max(end, begin + leader.image_bytes), self.payload_size)
            missing_bytes = self._blank_missing(block, end)
        return FinishedBlock(
            block.block_id, leader, block.buffer[begin:end], height, missing_bytes, complete, began
        )

    def _blank_missing(self, block: Block, end: int) -> int:
        """Zero what did not arrive, so that no earlier picture shines through; how many bytes that was."""
        assert block.buffer is not None
        blanked = 0
        if block.leader is None or not block.leader.parts:
            packets = -(-end // self.stride)
            came = np.zeros(packets + 1, np.uint8)
            known = block.received[: packets + 1]
            came[: len(known)] = known
            for first, last in runs(np.flatnonzero(came[1:] == 0)):
                begin, stop = first * self.stride, min((last + 1) * self.stride, end)
                block.buffer[begin:stop] = 0
                blanked += stop - begin
        return blanked

    def _remember(self, block: Block) -> None:
        last = self._last_finished
        if last is not None and (steps := distance(last, block.block_id, block.extended)) > 1:
            self.statistics.lost += steps - 1
        self._last_finished = block.block_id
        self._late_leader = None
        self._recent[block.block_id] = block.received
        while len(self._recent) > REMEMBERED:
            self._recent.popitem(last=False)

    def flush(self) -> None:
        """Finish every open block as it is."""
        while self._open:
            self._finish(self._open[0])

    # -- time ------------------------------------------------------------------------------------
    def timer(self) -> float:
        """When `handle_timer` wants to be called next; infinity where nothing is open."""
        return self._due

    def handle_timer(self, now: float) -> None:
        """Ask for what is missing and give up what will not come."""
        if now < self._due:
            return
        while self._open and now >= self._last_hope(self._open[0]):
            self._finish(self._open[0])
            self._finish_ready()
        for block in self._open:
            if block.next_check <= now:
                self._ask(block, now)
        self._due = min((self._next_look(block) for block in self._open), default=NEVER)
        if self._open:
            self._due = min(self._due, self._last_hope(self._open[0]))

    def _notice_gap(self, block: Block, now: float) -> None:
        if self.policy.enabled:
            block.next_check = min(block.next_check, now + self.policy.initial_wait)
            self._due = min(self._due, block.next_check)

    def _ask(self, block: Block, now: float) -> None:
        silent = now >= block.last_packet_at + self.policy.tail_wait
        overtaken = block is not self._open[-1]
        if silent:
            block.tail_checked = block.last_packet_at
        missing = block.missing(self._last_packet(block) if silent or overtaken else block.highest)
        for first, last in runs(block.to_ask(missing, self.policy, now)):
            self._requests.append(PacketResend(block.block_id, first, last, 0, block.extended))

    def _last_packet(self, block: Block) -> int:
        """Packet id of the trailer, as far as it can be known."""
        packets = block.payload_packets(self.stride)
        if packets is None:
            packets = -(-self.payload_size // self.stride)
        return packets + 1 if block.last_id is None else block.last_id

    def _last_hope(self, block: Block) -> float:
        """When a block that nothing more comes of is finished."""
        overtaken = block is not self._open[-1]
        if block.only_leader and not overtaken:
            return NEVER
        asking = self.policy.enabled and block.next_check != NEVER
        patience = self.policy.reorder_wait if overtaken and not asking else self.policy.give_up
        return block.last_packet_at + patience

    def _next_look(self, block: Block) -> float:
        """When to look for packets to ask for."""
        if self.policy.enabled and not block.only_leader and block.last_packet_at > block.tail_checked:
            # The end of the last block may be lost, with nothing after it to show the gap.
            block.next_check = min(block.next_check, block.last_packet_at + self.policy.tail_wait)
        return block.next_check

    def resend_requests(self) -> Iterator[PacketResend]:
        """Commands to send, each once."""
        while self._requests:
            yield self._requests.popleft()

    def finished(self) -> Iterator[FinishedBlock]:
        """Blocks to deliver, in order, each once."""
        while self._finished:
            yield self._finished.popleft()

    def _tell_once(self, what: str, details: str) -> None:
        if what not in self._told:
            self._told.add(what)
            log.warning("%s: %s", what, details)
