"""Packets to blocks, gaps to requests: the stream channel as a machine without I/O.

It reads no clock and opens no socket; times are seconds of any monotonic clock. Its driver feeds datagrams,
sends what `resend_requests()` gives, and takes what `finished()` gives. Memory is bounded: so many open
blocks as the policy allows, each in a buffer of the caller's pool. One thread.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.errors import RemoteProtocolError
from grabbergui.core.grabber import StreamStatistics
from grabbergui.driver.gige.gvcp import PacketResend, Status
from grabbergui.driver.gige.gvsp import Leader, PacketFormat, PacketHeader
from grabbergui.driver.gige.stream.block import (
    NEVER,
    NO_IDS,
    Block,
    BlockFiller,
    FinishedBlock,
    Ids,
    distance,
    finish,
)
from grabbergui.driver.gige.stream.block_history import BlockHistory, Meaning
from grabbergui.driver.gige.stream.packet_runs import in_turn, packet_runs
from grabbergui.driver.gige.stream.resend import Resender, ResendPolicy

GONE = (Status.PACKET_UNAVAILABLE, Status.PACKET_AND_PREVIOUS_REMOVED, Status.PACKET_REMOVED)
"The device says that it cannot resend."


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
        self.payload_size = payload_size
        self.policy = policy or ResendPolicy()
        self.statistics = StreamStatistics()
        "Counters; the rates in it stay 0."
        self._filler = BlockFiller(stride, payload_size, self.statistics)
        self._take_buffer = take_buffer
        self._deliver_incomplete = deliver_incomplete
        self._open: list[Block] = []
        "In the order of their ids."
        self._history = BlockHistory(self.statistics)
        self._resender = Resender(self.policy)
        self._previous_leader: Leader | None = None
        self._last_length = 0
        "Payload packets of the last picture."
        self._finished: deque[FinishedBlock] = deque()

    @property
    def stride(self) -> int:
        """Image bytes in a full packet."""
        return self._filler.stride

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
            self._filler.tell_once("a malformed stream packet", str(error))

    def receive_rows(self, rows: NDArray[np.uint8], now: float, at: NDArray[np.intp] | None = None) -> None:
        """Take datagrams of equal length, one a row of (n, length): as `receive` one by one, but faster.

        `at` says in which rows they are, in their order; None: in all.
        """
        if rows.shape[1] < PacketHeader.STANDARD.size:
            self._receive_singly(rows, at, now)
            return
        if at is None and in_turn(rows) and self._receive_in_turn(rows, now):
            return
        for run in packet_runs(rows if at is None else rows[at, : PacketHeader.EXTENDED.size]):
            if at is None:
                self._receive_run(rows[run.begin : run.end], None, run.ids, run.marked, now)
            else:
                self._receive_run(rows, at[run.begin : run.end], run.ids, run.marked, now)

    def _receive_singly(self, rows: NDArray[np.uint8], at: NDArray[np.intp] | None, now: float) -> None:
        for row in rows if at is None else rows[at]:
            self.receive(memoryview(row), now)

    def _receive_in_turn(self, rows: NDArray[np.uint8], now: float) -> bool:
        """Take packets that follow each other, as nearly all do on a good network.

        Returns False, and does nothing, where they are anything but full payload packets of an open block
        that come for the first time.
        """
        header = PacketHeader.decode(rows[0, : PacketHeader.EXTENDED.size].tobytes())
        block = self._open_block(header.block_id)
        bodies = rows[:, header.size :]
        first, end = header.packet_id, header.packet_id + len(rows)
        if (
            block is None
            or header.format != PacketFormat.PAYLOAD
            or header.status != Status.SUCCESS
            or header.sent_again
            or first == 0
            or bodies.shape[1] != self.stride
            or (end - 1) * self.stride > self.payload_size
            or block.received[first:end].any()
        ):
            return False
        self.statistics.packets += len(rows)
        block.make_room(end)
        block.place_in_turn(first, bodies)
        self._note_arrival(block, slice(first, end), len(rows), end - 1, False, now)
        return True

    def _receive_run(
        self,
        rows: NDArray[np.uint8],
        at: NDArray[np.intp] | None,
        ids: NDArray[np.intp],
        marked: NDArray[np.bool_],
        now: float,
    ) -> None:
        """Take packets of one kind: full payload packets of a block at once, anything else one by one."""
        if len(ids) == 1:
            self._receive_singly(rows, at, now)
            return
        first = rows[0 if at is None else int(at[0]), : PacketHeader.EXTENDED.size]
        header = PacketHeader.decode(first.tobytes())
        block = self._open_block(header.block_id)
        bodies = rows[:, header.size :]
        in_order = bool((ids[1:] > ids[:-1]).all())
        lowest, highest = (int(ids[0]), int(ids[-1])) if in_order else (int(ids.min()), int(ids.max()))
        if (
            header.format != PacketFormat.PAYLOAD
            or header.status not in (Status.SUCCESS, Status.PACKET_RESEND)
            or lowest == 0
            or bodies.shape[1] != self.stride
            or highest * self.stride > self.payload_size
        ):
            self._receive_singly(rows, at, now)
            return
        if block is None:
            # The first packet begins it, or belongs to none that is under way.
            self.receive(memoryview(rows[0 if at is None else int(at[0])]), now)
            at = (np.arange(len(rows)) if at is None else at)[1:]
            if self._open_block(header.block_id) is None:
                self._receive_singly(rows, at, now)
            else:
                self._receive_run(rows, at, ids[1:], marked[1:], now)
            return
        block.make_room(highest + 1)
        consecutive = in_order and highest - lowest + 1 == len(ids)
        places: Ids = slice(lowest, highest + 1) if consecutive else ids
        doubles = block.received[places].astype(bool)
        if not in_order and np.bincount(ids - lowest).max() > 1:
            later = np.ones(len(ids), np.bool_)
            later[np.unique(ids, return_index=True)[1]] = False
            doubles |= later
        if doubles.any():
            at = np.arange(len(rows)) if at is None else at
            if not doubles.all():
                self._receive_run(rows, at[~doubles], ids[~doubles], marked[~doubles], now)
            self._receive_singly(rows, at[doubles], now)
            return
        self.statistics.packets += len(ids)
        block.place_rows(ids, highest, bodies, at)
        self._note_arrival(block, places, len(ids), highest, marked, now)

    def _receive(self, header: PacketHeader, body: memoryview, now: float) -> None:
        block = self._block_of(header, now)
        if block is None:
            return
        self.statistics.packets += 1
        if header.failed:
            if header.status in GONE:
                self._resender.refused(block, header.packet_id)
            return
        if block.holds(header.packet_id):
            self.statistics.packets_duplicate += 1
            self._resender.doubled(block, header.packet_id)
            return
        if header.packet_id > self.payload_size // 16 + 64:
            raise RemoteProtocolError(f"packet_id {header.packet_id} in a block of {self.payload_size} bytes")
        self._filler.store(block, header, body)
        block.make_room(header.packet_id + 1)
        only = slice(header.packet_id, header.packet_id + 1)
        self._note_arrival(block, only, 1, header.packet_id, header.sent_again, now)

    def _note_arrival(
        self,
        block: Block,
        ids: Ids,
        count: int,
        highest: int,
        marked: NDArray[np.bool_] | bool,
        now: float,
    ) -> None:
        """Note packets that are stored already; `highest` is the highest id of `count`."""
        self.statistics.packets_resent += self._resender.came(block, ids, now, marked)
        expected = block.highest + 1
        block.mark(ids, count, highest, now)
        if self.policy.enabled and highest >= expected and not block.refused:
            if isinstance(ids, slice):
                gaps = np.arange(expected, ids.start) if ids.start > expected else NO_IDS
            else:
                gaps = expected + (block.received[expected:highest] == 0).nonzero()[0]
            if len(gaps):
                self._resender.missed(block, gaps, now)
        if block.complete(self.stride):
            self._finish_ready()

    # -- blocks ----------------------------------------------------------------------------------
    def _open_block(self, block_id: int) -> Block | None:
        for block in reversed(self._open):
            if block.block_id == block_id:
                return block
        return None

    def _block_of(self, header: PacketHeader, now: float) -> Block | None:
        """The open block of a packet, which may be its first; None where there is nothing to be done."""
        block = self._open_block(header.block_id)
        if block is not None:
            return block
        meaning = self._history.meaning(header)
        if meaning is Meaning.LATE:
            return None
        if meaning is Meaning.STALE:
            self.statistics.packets_ignored += 1
            return None
        if meaning is Meaning.RESTART:
            self.flush()
            self._history.forget()
        return self._begin(header, now)

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
        for overtaken in self._open[:index]:
            if not overtaken.complete(self.stride):  # its end may be lost
                look = now + self._resender.initial_wait
                overtaken.asked.next_check = min(overtaken.asked.next_check, look)
        self._open.insert(index, block)
        if len(self._open) > self.policy.max_blocks:
            self._finish(self._open[0])
            self._finish_ready()
        return block

    def _finish_ready(self) -> None:
        """Finish complete blocks in order; one that waits for packets holds back those after it."""
        while self._open and self._open[0].complete(self.stride):
            self._finish(self._open[0])

    def _finish(self, block: Block) -> None:
        self._open.remove(block)
        self._history.add(block)
        if block.buffer is None:
            return
        leader = block.leader
        complete = block.complete(self.stride) or block.all_arrived()
        if not complete:
            self.statistics.incomplete += 1
            self.statistics.packets_missing += len(block.missing(self._last_packet(block)))
            if not self._deliver_incomplete:
                return
            leader = leader or self._previous_leader
        if leader is None or block.refused or not leader.is_picture:
            return
        self._previous_leader = leader
        self._last_length = block.payload_packets(self.stride) or self._last_length
        self._finished.append(finish(block, leader, self.stride, complete=complete))

    def flush(self) -> None:
        """Finish every open block as it is."""
        while self._open:
            self._finish(self._open[0])

    def finished(self) -> Iterator[FinishedBlock]:
        """Blocks to deliver, in order, each once."""
        while self._finished:
            yield self._finished.popleft()

    @property
    def block_under_way(self) -> bool:
        """Whether more is to come of the newest block."""
        return bool(self._open) and self.expected() > 0

    @property
    def block_waits(self) -> bool:
        """Whether a block waits for packets that were lost, while a later one comes."""
        return len(self._open) > 1

    def expected(self) -> int:
        """How many packets are still to come until the newest block ends, or between blocks the next.

        One that does not tell its length will be as long as the last. 0 where nothing is known.
        """
        if not self._open:
            return self._last_length
        block = self._open[-1]
        packets = block.payload_packets(self.stride)
        return max((self._last_length if packets is None else packets) - block.highest, 0)

    # -- time ------------------------------------------------------------------------------------
    def timer(self) -> float:
        """When `handle_timer` wants to be called next; infinity where nothing is open."""
        if not self._open:
            return NEVER
        return min(self._last_hope(self._open[0]), *map(self._next_look, self._open))

    def handle_timer(self, now: float) -> None:
        """Ask for what is missing and give up what will not come."""
        while self._open and now >= self._last_hope(self._open[0]):
            self._finish(self._open[0])
            self._finish_ready()
        for block in self._open:
            if self._next_look(block) <= now:
                self._ask(block, now)

    def resend_requests(self) -> Iterator[PacketResend]:
        """Commands to send, each once."""
        return self._resender.requests()

    def _ask(self, block: Block, now: float) -> None:
        silent = now >= block.last_packet_at + self.policy.tail_wait
        overtaken = block is not self._open[-1]
        if silent:
            block.asked.tail_checked = block.last_packet_at
        missing = block.missing(self._last_packet(block) if silent or overtaken else block.highest)
        self._resender.ask(block, missing, now)

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
        asking = self.policy.enabled and block.asked.next_check != NEVER
        patience = self.policy.reorder_wait if overtaken and not asking else self.policy.give_up
        return block.last_packet_at + patience

    def _next_look(self, block: Block) -> float:
        """When to look for packets to ask for."""
        if not self.policy.enabled or block.refused:
            return NEVER
        asked = block.asked
        look = asked.next_check
        if self._comes(block):
            look = max(look, asked.checked + self.policy.look_again)
        if not block.only_leader and block.last_packet_at > asked.tail_checked:
            # The end of the last block may be lost, with nothing after it to show the gap.
            look = min(look, block.last_packet_at + self.policy.tail_wait)
        return look

    def _comes(self, block: Block) -> bool:
        """Whether more packets of a block are to come without being asked for."""
        return block is self._open[-1] and self.expected() > 0
