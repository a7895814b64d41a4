"""Packets to blocks, gaps to requests: the stream channel as a sans-I/O protocol.

It reads no clock and opens no socket; times are seconds of any monotonic clock. Its driver (`receiver`)
feeds datagrams, sends the `resend_requests()` and delivers the `finished()` blocks. A packet takes one of two
paths: `receive` takes any single packet, `receive_rows` takes many full payload packets at once and leaves
the rest to `receive`. Memory is bounded: there are at most as many open blocks as the policy allows, each in
a buffer of the caller's pool. All counters of a stream are kept here. One thread.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.errors import RemoteProtocolError
from grabbergui.core.frame_queue import StreamStatistics
from grabbergui.driver.gige.gvcp import PacketResend, Status, status_text
from grabbergui.driver.gige.gvsp import Leader
from grabbergui.driver.gige.packet_header import (
    EXTENDED,
    STANDARD,
    PacketFormat,
    PacketHeader,
    count_in_order,
)
from grabbergui.driver.gige.stream.block import Block, Places
from grabbergui.driver.gige.stream.block_history import BlockHistory, Meaning, distance
from grabbergui.driver.gige.stream.block_layout import BlockLayout
from grabbergui.driver.gige.stream.packet_sorting import PacketRun, packet_runs
from grabbergui.driver.gige.stream.resend import NEVER, Resender, ResendPolicy

UNAVAILABLE = (Status.PACKET_UNAVAILABLE, Status.PACKET_AND_PREVIOUS_REMOVED, Status.PACKET_REMOVED)
"The device cannot send the packet again."
FEW = 3
"Packets that are taken one by one: for more, arrays cost less."
_LATER = (Status.PACKET_NOT_YET_AVAILABLE, Status.PACKET_TEMPORARILY_UNAVAILABLE)
"It was asked too early: the packet comes, or is asked for again."


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
        channel: int = 0,
    ) -> None:
        """`stride`: image bytes in a full packet; `payload_size`: bytes of a buffer, the largest payload.

        `channel` is named by requests for lost packets.
        """
        self.policy = policy or ResendPolicy()
        self.statistics = StreamStatistics()
        "Counters; the rates in it stay 0."
        self._layout = BlockLayout(stride, payload_size)
        self._take_buffer = take_buffer
        self._deliver_incomplete = deliver_incomplete
        self._open: list[Block] = []
        "In the order of their ids."
        self._history = BlockHistory()
        self._resender = Resender(self.policy, channel)
        self._previous_leader: Leader | None = None
        self._previous_id = -1
        "Id of the block that this leader belongs to."
        self._previous_packets = 0
        "Payload packets of the last image."
        self._finished: deque[Block] = deque()

    @property
    def stride(self) -> int:
        """Image bytes in a full packet."""
        return self._layout.stride

    @property
    def payload_size(self) -> int:
        """Bytes of the largest payload."""
        return self._layout.payload_size

    def receive(self, datagram: bytes | memoryview, now: float) -> None:
        """Take one datagram; its payload is copied into the block's buffer. Never raises."""
        try:
            header = PacketHeader.decode(datagram)
            if header.block_id != 0:  # 0 is a test packet
                self._receive(header, memoryview(datagram)[header.size :], now)
        except RemoteProtocolError as error:
            self.statistics.packets_ignored += 1
            self._layout.warn_once("a malformed stream packet", str(error))

    def _receive(self, header: PacketHeader, body: memoryview, now: float) -> None:
        if header.format == PacketFormat.LEADER and self._repeats_id(header, body):
            self._layout.warn_once(
                f"the camera gives its frames one id ({header.block_id})",
                "they are told apart by their timestamps, and lost packets cannot be told from late ones",
            )
            self.flush()
            self._history.clear()
            block: Block | None = self._begin(header, now)
        else:
            block = self._block_of(header, now)
        if block is None:
            return
        self.statistics.packets += 1
        packet_id = header.packet_id
        if header.failed:
            if header.status in UNAVAILABLE:
                block.note_unavailable(packet_id)
            elif header.status not in _LATER:
                text = status_text(header.status)
                self._layout.warn_once(f"stream packets with {text}", "the camera could not send their data")
        elif block.has(packet_id):
            self.statistics.packets_duplicate += 1
            block.note_duplicate(packet_id)
        elif packet_id > self._layout.highest_id:
            raise RemoteProtocolError(
                f"packet_id {packet_id} in a block of {self._layout.payload_size} bytes"
            )
        else:
            self._note_taken(block, block.take(header, body, now))

    def receive_rows(self, rows: NDArray[np.uint8], now: float, at: NDArray[np.intp] | None = None) -> None:
        """Take datagrams of equal length, one per row of (n, length): like `receive` for each, but faster.

        `at` holds the indices of the rows to take in the order of arrival; None means all.
        """
        if at is None:
            if len(rows) <= FEW:
                for row in rows:
                    self.receive(row.data, now)
                return
            if self._receive_in_order(rows, now):
                return
            at = np.arange(len(rows))
        if rows.shape[1] < STANDARD.itemsize:
            self._receive_singly(rows, at, now)
            return
        for run in packet_runs(rows[at, : EXTENDED.itemsize]):
            self._receive_run(rows, at[run.begin : run.end], run, now)

    def _receive_in_order(self, rows: NDArray[np.uint8], now: float) -> bool:
        """Take packets that follow each other, as nearly all do on a good network.

        Returns False, and does nothing, unless they are new full payload packets of an open block.
        """
        if rows.shape[1] < STANDARD.itemsize or count_in_order(rows) < len(rows):
            return False
        found = self._find_new(rows, rows.shape[1])
        if found is None:
            return False
        block, first = found
        self.statistics.packets += len(rows)
        self._note_taken(block, block.take_in_order(first, rows[:, -self.stride :], now))
        return True

    def next_places(self) -> Places | None:
        """Return where the next packets belong if they arrive in order; None where that is not known."""
        return self._open[-1].next_places() if self._open else None

    def receive_in_place(self, headers: NDArray[np.uint8], places: Places, now: float) -> int:
        """Take full packets whose data is in their `next_places` already, by their headers, shape (n, size).

        Returns how many of them, from the first on, are the next packets; the others are not taken.
        """
        headers = headers[: count_in_order(headers)]
        found = self._find_new(headers, places.packet_length) if len(headers) else None
        if found is None or found != (self._open[-1], places.first):
            return 0
        block, first = found
        self.statistics.packets += len(headers)
        self._note_taken(block, block.take_placed(first, len(headers), now))
        return len(headers)

    def _find_new(self, headers: NDArray[np.uint8], packet_length: int) -> tuple[Block, int] | None:
        """Return the open block and the first id of packets in order; None unless all are new and full."""
        header = PacketHeader.decode(headers[0, : EXTENDED.itemsize].tobytes())
        block = self._open_block(header.block_id)
        first, end = header.packet_id, header.packet_id + len(headers)
        if (
            block is None
            or header.format != PacketFormat.PAYLOAD
            or header.status != Status.SUCCESS
            or first == 0
            or packet_length - header.size != self.stride
            or (end - 1) * self.stride > self._layout.payload_size
            or block.has_any(first, end)
        ):
            return None
        return block, first

    def _receive_singly(self, rows: NDArray[np.uint8], at: NDArray[np.intp], now: float) -> None:
        for row in at.tolist():
            self.receive(memoryview(rows[row]), now)

    def _receive_run(self, rows: NDArray[np.uint8], at: NDArray[np.intp], run: PacketRun, now: float) -> None:
        """Take full payload packets of one block at once, anything else one by one."""
        if len(at) == 1:
            self._receive_singly(rows, at, now)
            return
        header = PacketHeader.decode(rows[at[0], : EXTENDED.itemsize].tobytes())
        bodies = rows[:, header.size :]
        full_packets = (
            header.format == PacketFormat.PAYLOAD
            and header.status in (Status.SUCCESS, Status.PACKET_RESEND)
            and bodies.shape[1] == self.stride
            and run.highest * self.stride <= self._layout.payload_size
            and run.lowest > 0
        )
        block = self._open_block(header.block_id)
        if full_packets and block is None:  # the first packet begins a block, or belongs to a finished one
            self._receive_singly(rows, at[:1], now)
            at, run = at[1:], run.chosen(slice(1, None))
            block = self._open_block(header.block_id)
        if not full_packets or block is None:
            self._receive_singly(rows, at, now)
            return
        new = block.new_of(run)
        if new is None:
            self._take_run(block, bodies, at, run, now)
            return
        if new.any():
            self._take_run(block, bodies, at[new], run.chosen(new), now)
        self._receive_singly(rows, at[~new], now)  # duplicates

    def _take_run(
        self, block: Block, bodies: NDArray[np.uint8], at: NDArray[np.intp], run: PacketRun, now: float
    ) -> None:
        self.statistics.packets += len(at)
        self._note_taken(block, block.take_run(run, bodies, at, now))

    def _note_taken(self, block: Block, resent: int) -> None:
        """Count packets that a block took, and finish it if it has all."""
        self.statistics.packets_resent += resent
        if block.all_received():
            self._finish_ready()

    def _open_block(self, block_id: int) -> Block | None:
        for block in reversed(self._open):
            if block.block_id == block_id:
                return block
        return None

    def _block_of(self, header: PacketHeader, now: float) -> Block | None:
        """Return the open block of a packet, which may be its first; None for a late or stale packet."""
        block = self._open_block(header.block_id)
        if block is not None:
            return block
        meaning = self._history.meaning(header)
        if meaning is Meaning.LATE:
            self.statistics.packets += 1
            self.statistics.packets_duplicate += self._history.note_late(header)
            return None
        if meaning is Meaning.STALE:
            self.statistics.packets_ignored += 1
            return None
        if meaning is Meaning.RESTART:
            self.flush()
            self._history.clear()
        return self._begin(header, now)

    def _repeats_id(self, header: PacketHeader, body: memoryview) -> bool:
        """Return whether a leader has the id of the block before it, and another timestamp."""
        block = self._open_block(header.block_id)
        before = block.leader if block is not None else self._previous_leader
        if before is None or (block is None and header.block_id != self._previous_id):
            return False
        try:
            timestamp = Leader.decode(body).timestamp
        except RemoteProtocolError:
            return False
        return bool(timestamp) and timestamp != before.timestamp

    def _begin(self, header: PacketHeader, now: float) -> Block:
        buffer = self._take_buffer()
        if buffer is None:
            self.statistics.underruns += 1
        block = Block(header, self._layout, self._resender, buffer, now)
        if self._open and self._open[0].extended != header.extended:
            self.flush()
        index = len(self._open)
        while index and distance(self._open[index - 1].block_id, block.block_id, block.extended) < 0:
            index -= 1
        for overtaken in self._open[:index]:
            if not overtaken.all_received():  # its end may be lost
                overtaken.check_by(now + self._resender.initial_wait)
        self._open.insert(index, block)
        if len(self._open) > self.policy.max_blocks:
            self._finish(self._open[0])
            self._finish_ready()
        return block

    def _finish_ready(self) -> None:
        """Finish complete blocks in order; one that waits for packets holds back those after it."""
        while self._open and self._open[0].all_received():
            self._finish(self._open[0])

    def _finish(self, block: Block) -> None:
        self._open.remove(block)
        self.statistics.lost += self._history.add(block.block_id, block.extended, block.received)
        self.statistics.packets_clipped += block.clipped
        if block.counted_only:
            return
        block.close()
        leader = block.leader
        if not block.complete:
            self.statistics.incomplete += 1
            self.statistics.packets_missing += len(block.missing(block.last_packet_id()))
            if not self._deliver_incomplete:
                return
            if leader is None and self._previous_leader is not None:
                leader = replace(self._previous_leader, timestamp=0)  # that of the block is lost
        if leader is None or block.refused or not leader.is_known:
            return
        self._previous_leader, self._previous_id = leader, block.block_id
        self._previous_packets = block.payload_packets() or self._previous_packets
        block.extract_payload(leader)
        self._finished.append(block)

    def flush(self) -> None:
        """Finish every open block as it is."""
        while self._open:
            self._finish(self._open[0])

    def finished(self) -> Iterator[Block]:
        """Yield the blocks to deliver, in order, each once; they are counted as they leave."""
        while self._finished:
            block = self._finished.popleft()
            if block.complete:
                self.statistics.frames += 1
                self.statistics.bytes += len(block.payload)
            yield block

    @property
    def refusal(self) -> str:
        """Why the last block that was refused made no frame; empty if none was."""
        return self._layout.refusal

    def ignore(self, packets: int) -> None:
        """Count packets that are not from the device."""
        self.statistics.packets_ignored += packets
        self.statistics.packets_foreign += packets

    def note_overrun(self) -> None:
        """Count that waiting packets were discarded, and finish the blocks that they belonged to.

        Requesting them again would only add to what arrives too fast.
        """
        self.statistics.overruns += 1
        self.flush()

    @property
    def has_finished(self) -> bool:
        """Whether blocks wait to be delivered."""
        return bool(self._finished)

    @property
    def block_in_progress(self) -> bool:
        """Whether more of the newest block is to arrive."""
        return bool(self._open) and self.expected() > 0

    @property
    def block_waits(self) -> bool:
        """Whether a block waits for lost packets while a later one arrives."""
        return len(self._open) > 1

    def expected(self) -> int:
        """Return how many packets arrive until the newest block ends, or between blocks the next.

        A block of unknown length is assumed to be as long as the last. 0 where nothing is known.
        """
        if not self._open:
            return self._previous_packets
        block = self._open[-1]
        packets = block.payload_packets()
        return max((self._previous_packets if packets is None else packets) - block.highest, 0)

    def timer(self) -> float:
        """Return when `handle_timer` wants to be called next; infinity where no block is open."""
        if not self._open:
            return NEVER
        return min(self._give_up_time(self._open[0]), *map(self._check_time, self._open))

    def handle_timer(self, now: float) -> None:
        """Request what is missing, and finish blocks that wait in vain."""
        while self._open and now >= self._give_up_time(self._open[0]):
            self._finish(self._open[0])
            self._finish_ready()
        for block in self._open:
            if self._check_time(block) <= now:
                block.request(now, overtaken=block is not self._open[-1])

    def resend_requests(self) -> Iterator[PacketResend]:
        """Yield commands to send, each once."""
        return self._resender.requests()

    def _give_up_time(self, block: Block) -> float:
        return block.give_up_time(overtaken=block is not self._open[-1])

    def _check_time(self, block: Block) -> float:
        return block.check_time(arriving=block is self._open[-1] and self.expected() > 0)
