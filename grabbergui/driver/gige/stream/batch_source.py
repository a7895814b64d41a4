"""Packets of a stream in batches: `BatchSource` reads its UDP socket, or several at one port. Linux.

It lets packets gather as long as that delays no frame, and has two readers that take turns. `MessageSlots`
takes whatever waits, up to 2 MiB with one system call, and the assembler copies the packets into frames.
Where the kernel joins packets to long datagrams, `InPlaceReader` takes those of a block in progress, one
datagram a call, without that copy. It expects them in order.
"""

from __future__ import annotations

import logging
import socket
import time
from collections.abc import Sequence

from grabbergui.core.frame_queue import StreamStatistics
from grabbergui.driver.gige.stream.assembler import BlockAssembler
from grabbergui.driver.gige.stream.block import Places
from grabbergui.driver.gige.stream.datagram_source import DatagramSource
from grabbergui.driver.gige.stream.in_place import InPlaceReader
from grabbergui.driver.gige.stream.pace import Pace
from grabbergui.driver.gige.stream.packet_origin import PacketOrigin
from grabbergui.driver.gige.stream.recvmmsg import (
    FOREIGN,
    SLOTS,
    MessageSlots,
    hand_over_joined,
    join_packets,
)
from grabbergui.driver.gige.stream.sockets import buffer_bytes

log = logging.getLogger(__name__)

ANSWER_PAUSE = 0.001
"Seconds that packets may gather while a block waits for lost ones."
OVERRUN = 0.03
"""Seconds of work without once emptying the buffer, with more incomplete frames than complete ones, after
which all waiting packets are discarded: a full buffer makes holes in every frame, and holes cost time."""
BATCHES = 8
"Reads before timers and finished frames have their turn."
SKIPS = 256
"Calls to discard packets, at most: more arrive meanwhile."
LONG = 24_000
"Bytes of a datagram from which on a call for it alone costs less than copying it."
LARGE = 1 << 20
"Bytes of a frame from which on this holds, too, for the calls that its leader and trailer take."
MOST_DISORDER = 0.25
"Share of the reads in place that may bring other packets than expected, as these cost more than others."
DISORDER_PAUSE = 0.25
"Seconds for which packets are not received in place after that."
SHORT_DATAGRAMS = 3
"Datagrams between the joined ones of two blocks, at most: a last packet, the trailer, the leader."


class BatchSource(DatagramSource):
    """Feeds an assembler from a socket, or several at one port, in batches. One thread."""

    def __init__(
        self, receiver: socket.socket, origin: PacketOrigin, more: Sequence[socket.socket] = ()
    ) -> None:
        """`more` are further sockets at the same port, which become the source's own."""
        super().__init__()
        self._more = more
        sockets = [receiver, *more]
        self._descriptors = [each.fileno() for each in sockets]
        for each in sockets:
            join_packets(each)
        self._slots = MessageSlots(origin)
        self._in_place = InPlaceReader(origin)
        self._pace = Pace(sum(map(buffer_bytes, sockets)), SLOTS * BATCHES)
        self._wait = self._waits.waiter(sockets)
        "Waits for at most the given seconds and returns the descriptors of sockets with packets."
        self._drained = True
        "Whether the last read emptied the buffer."
        self._flowing = False
        "Whether the last read found packets."
        self._busy_since: float | None = None
        "The thread's CPU time when reads began to leave packets behind; None since one left none."
        self._lost_by_then = 0
        "Incomplete less complete frames at that time."
        self._overrun_logged = False
        self._newest = 0
        "Index of the socket that the last packets were read from."
        self._held = 0
        "Slots with packets that the assembler has yet to get: of several sockets, each of which holds few."
        self._usual_length = 0.0
        "Bytes of a datagram with payload, where the kernel joins packets to long ones."
        self._between_blocks = True
        "Whether short datagrams are expected: the trailer of one block, the leader of the next."
        self._singles = 0
        "Datagrams read one by one since the last that was received in place."
        self._disorder = 0.0
        "Share of the recent reads in place that brought other packets than expected."
        self._in_place_from = 0.0
        "Time before which nothing is received in place."

    def close(self) -> None:
        """Close the further sockets."""
        super().close()
        for each in self._more:
            each.close()

    def receive(self, assembler: BlockAssembler, timeout: float) -> None:
        """Wait for packets, let more gather if that delays no frame, then take all.

        Packets that arrive faster than we take them are discarded.
        """
        if not self._drained and self._overrun(assembler.statistics):
            assembler.note_overrun()
            self._skip()
        paused = 0.0
        if self._drained:
            in_progress = assembler.block_in_progress
            if in_progress and self._flowing:
                paused = self._gather(assembler, timeout)
            if not paused and not self._wait(timeout):
                self._flowing = False
                return
            if not in_progress:
                self._pace.woke(time.monotonic())
                paused = self._gather(assembler, timeout)
        before = assembler.statistics.packets
        now = self._take_all(assembler, time.monotonic())
        packets = assembler.statistics.packets - before
        self._flowing = packets > 0
        self._pace.took(packets, now, more=assembler.block_in_progress, ended=assembler.has_finished)

    def _gather(self, assembler: BlockAssembler, timeout: float) -> float:
        """Let packets gather if that delays no frame; return the seconds waited."""
        begun = time.monotonic()
        pause = min(self._pace.pause(assembler.expected(), assembler.stride, begun), timeout)
        if assembler.block_waits:
            pause = min(pause, ANSWER_PAUSE)
        if pause <= 0:
            return 0.0
        self._waits.rest(pause)
        waited = time.monotonic() - begun
        self._pace.slept(pause, waited)
        return waited

    def _overrun(self, statistics: StreamStatistics) -> bool:
        """Return whether packets arrive faster than we take them (by CPU time, as other programs run too)."""
        worked, lost = time.thread_time(), statistics.incomplete - statistics.frames
        if self._busy_since is not None and worked - self._busy_since <= OVERRUN:
            return False
        overrun = self._busy_since is not None and lost > self._lost_by_then
        self._busy_since, self._lost_by_then = worked, lost
        return overrun

    def _skip(self) -> None:
        """Discard waiting packets, so that the next frames are complete again."""
        self._held = 0
        for descriptor in self._descriptors:
            for _ in range(SKIPS):
                if self._slots.skip(descriptor) < self._slots.count:
                    break
        self._drained = True
        if not self._overrun_logged:
            self._overrun_logged = True
            log.warning(
                "packets arrive faster than this machine takes them: waiting packets are discarded;"
                " larger packets or a lower frame rate help"
            )

    def _take_all(self, assembler: BlockAssembler, now: float) -> float:
        """Take all waiting packets, or as many as `BATCHES` reads bring; return the time of the last read."""
        self._drained = True
        for index in self._waiting():
            now = self._drain(index, assembler, now)
        if self._drained:
            self._busy_since = None
        self._take_held(assembler, now)
        return now

    def _waiting(self) -> list[int]:
        """Return which sockets to read, in the order in which the kernel fills them; some may be empty."""
        count = len(self._descriptors)
        if count == 1:
            return [0]
        ready = [self._descriptors.index(descriptor) for descriptor in self._wait(0.0)]
        return sorted(ready, key=lambda index: (index - self._newest) % count)

    def _drain(self, index: int, assembler: BlockAssembler, now: float) -> float:
        """Read all packets of one socket; return the time of the last read. The last stay in the slots."""
        for _ in range(BATCHES):
            in_place = self._can_receive_in_place(assembler, now)
            if in_place and (places := assembler.next_places()) is not None:
                now, emptied = self._read_in_place(places, assembler, now)
            else:
                one = in_place and self._between_blocks and self._singles < SHORT_DATAGRAMS
                now, emptied = self._read_into_slots(index, assembler, one=one)
            if emptied:
                return now
            if in_place and assembler.has_finished:
                break
        self._drained = False
        return now

    def _can_receive_in_place(self, assembler: BlockAssembler, now: float) -> bool:
        large = self._usual_length >= LONG and assembler.payload_size >= LARGE
        return large and len(self._descriptors) == 1 and now >= self._in_place_from

    def _read_in_place(self, places: Places, assembler: BlockAssembler, now: float) -> tuple[float, bool]:
        """Read packets of the block in progress; return the time, and whether the socket is empty."""
        received = self._in_place.receive(self._descriptors[0], places, assembler, now)
        self._between_blocks, self._singles = True, 0
        if received.messages:
            self._usual_length += (received.bytes / received.messages - self._usual_length) / 8
            self._disorder += ((not received.in_order) - self._disorder) / 8
            if self._disorder > MOST_DISORDER:
                self._disorder, self._in_place_from = 0.0, now + DISORDER_PAUSE
        return time.monotonic(), received.emptied

    def _read_into_slots(self, index: int, assembler: BlockAssembler, *, one: bool) -> tuple[float, bool]:
        """Read any packets, or only one datagram; return as `_read_in_place`. They may stay in the slots."""
        end = self._held + 1 if one else self._slots.count
        received = self._slots.receive(self._descriptors[index], self._held, end)
        now = time.monotonic()
        emptied = received < end - self._held
        self._held += received
        self._singles += received if one else 0
        if received:
            self._newest = index
        if not emptied:
            self._take_held(assembler, now)
        return now, emptied

    def _take_held(self, assembler: BlockAssembler, now: float) -> None:
        """Give the packets in the slots to the assembler, runs of datagrams of equal length at once."""
        received, self._held = self._held, 0
        if not received:
            return
        for run in self._slots.runs(received, now):
            if run.length == FOREIGN:
                assembler.ignore(run.end - run.begin)
                continue
            rows = self._slots.rows(run)
            if rows is not None:
                assembler.receive_rows(rows.array, now, rows.at)
                continue
            for slot in range(run.begin, run.end):
                datagram = self._slots.datagram(slot, run.length)
                hand_over_joined(assembler, datagram, run.packet_length, now)
        longest = self._slots.fit(received)
        self._between_blocks = longest < LONG or not assembler.block_in_progress
        self._usual_length = max(self._usual_length, longest)
