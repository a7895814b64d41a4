"""Many datagrams with one system call, and many packets in one datagram. Linux.

`recvmmsg` takes all that waits at the socket. With UDP_GRO the kernel also joins equally long packets that
follow each other to one datagram of up to 64 KB, and says how long each of them was. Either way packets of
equal length become the rows of an array, which the assembler takes whole.
"""

from __future__ import annotations

import logging
import select
import socket
import time
from collections.abc import Sequence

from grabbergui.core.grabber import StreamStatistics
from grabbergui.driver.gige.block_assembler import BlockAssembler
from grabbergui.driver.gige.datagram_source import DatagramSource
from grabbergui.driver.gige.message_slots import (
    FOREIGN,
    SLOTS,
    MessageSlots,
    Stretch,
    available,
    join_packets,
)
from grabbergui.driver.gige.pace import Pace
from grabbergui.driver.gige.stream_socket import buffer_bytes

__all__ = ["BatchSource", "available"]

log = logging.getLogger(__name__)

BATCHES = 8
"Calls before timers and finished frames are looked after."
ANSWER_PAUSE = 0.001
"Seconds that packets gather at most, where a block waits for some that were lost."
OVERRUN = 0.03
"""Seconds of work without once emptying the sockets, in which more frames were lost than came whole, after
which all that waits is thrown away: behind a full buffer frames have holes, which cost more time to take."""
SKIPS = 256
"Calls that throw away at most: more comes meanwhile."


class BatchSource(DatagramSource):
    """Feeds an assembler from a socket, or from several at one port, by batches. One thread."""

    def __init__(
        self, receiver: socket.socket, device_ip: str, more: Sequence[socket.socket] = ()
    ) -> None:
        """`more` are further sockets at the same port, which become the source's own."""
        self._more = more
        sockets = [receiver, *more]
        self._descriptors = [each.fileno() for each in sockets]
        self._poll = select.poll()
        for each in sockets:
            join_packets(each)
            self._poll.register(each, select.POLLIN)
        self._slots = MessageSlots(device_ip)
        self._pace = Pace(sum(map(buffer_bytes, sockets)), SLOTS * BATCHES)
        self._drained = True
        "Whether the sockets were empty when they were last looked at."
        self._newest = 0
        "Which socket the last packets came from."
        self._busy_since = 0.0
        "The thread's CPU time when they were last found empty, or last judged whether too much comes, and"
        self._lost_by_then = 0
        "how many frames more were incomplete than whole by then."
        self._told = False
        "Whether it was told that packets were skipped."
        self._flowing = False
        "Whether anything came when the sockets were last looked at."

    def receive(self, assembler: BlockAssembler, timeout: float) -> None:
        """See DatagramSource."""
        before = assembler.statistics.packets
        if self._overrun(assembler.statistics):
            self._skip()
        paused = self._drained and self._flowing and self._gather(assembler, timeout)
        waiting = self._waiting(timeout if self._drained and not paused else 0.0)
        now = time.monotonic()
        self._drained = True
        for index in waiting:
            now = self._drain(index, assembler)
        packets = assembler.statistics.packets - before
        self._flowing = packets > 0
        self._pace.took(packets, now, more=assembler.block_under_way)

    def close(self) -> None:
        """Close the further sockets."""
        for each in self._more:
            each.close()

    def _overrun(self, statistics: StreamStatistics) -> bool:
        """Whether packets come faster than they can be taken. By CPU time: others may have had the rest."""
        worked = time.thread_time()
        if not self._drained and worked - self._busy_since <= OVERRUN:
            return False
        lost = statistics.incomplete - statistics.frames
        overrun = not self._drained and lost > self._lost_by_then
        self._busy_since, self._lost_by_then = worked, lost
        return overrun

    def _skip(self) -> None:
        """Throw away what waits: the oldest, and what comes next is whole again."""
        for descriptor in self._descriptors:
            for _ in range(SKIPS):
                if self._slots.skip(descriptor) < self._slots.count:
                    break
        self._drained = True
        if not self._told:
            self._told = True
            log.warning(
                "packets come faster than this machine takes them: those that waited are skipped;"
                " larger packets or a lower frame rate help"
            )

    def _gather(self, assembler: BlockAssembler, timeout: float) -> bool:
        """Let packets gather for a while, where that delays no picture; whether there was time to."""
        begun = time.monotonic()
        pause = min(self._pace.pause(assembler.expected(), assembler.stride, begun), timeout)
        if assembler.block_waits:
            pause = min(pause, ANSWER_PAUSE)
        if not pause:
            return False
        time.sleep(pause)
        self._pace.slept(pause, time.monotonic() - begun)
        return True

    def _waiting(self, timeout: float) -> list[int]:
        """Which sockets to read, in the order in which packets are given to them; some may be empty."""
        count = len(self._descriptors)
        if count == 1 and not timeout:
            return [0]
        ready = [self._descriptors.index(descriptor) for descriptor, _ in self._poll.poll(1000 * timeout)]
        return sorted(ready, key=lambda index: (index - self._newest) % count)

    def _drain(self, index: int, assembler: BlockAssembler) -> float:
        """Take what waits at one socket; when it was last looked at."""
        for _ in range(BATCHES):
            slots = self._slots.count
            received = self._slots.receive(self._descriptors[index])
            now = time.monotonic()
            if received:
                self._newest = index
                self._take(assembler, received, now)
            if received < slots:
                return now
        self._drained = False
        return now

    def _take(self, assembler: BlockAssembler, received: int, now: float) -> None:
        """Give a batch to the assembler, stretches of equally long datagrams at once."""
        for stretch in self._slots.stretches(received):
            if stretch.length == FOREIGN:
                assembler.statistics.packets_ignored += stretch.end - stretch.begin
                continue
            rows = self._slots.rows(stretch)
            if rows is not None:
                assembler.receive_rows(rows.array, now, rows.at)
            else:
                self._take_apart(assembler, stretch, now)
        self._slots.fit(received)

    def _take_apart(self, assembler: BlockAssembler, stretch: Stretch, now: float) -> None:
        """Joined packets of which the last is shorter, or that are longer than a slot."""
        for slot in range(stretch.begin, stretch.end):
            datagram = self._slots.datagram(slot, stretch.length)
            whole = stretch.length - stretch.length % stretch.packet_length
            assembler.receive_rows(datagram[:whole].reshape(-1, stretch.packet_length), now)
            if whole < stretch.length:
                assembler.receive(datagram[whole:].data, now)
