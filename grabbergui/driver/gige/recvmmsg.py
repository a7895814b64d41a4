"""Many datagrams with one system call, and many packets in one datagram. Linux.

`recvmmsg` takes all that waits at the socket. With UDP_GRO the kernel also joins equally long packets that
follow each other to one datagram of up to 64 KB, and says how long each of them was. Either way packets of
equal length become the rows of an array, which the assembler takes whole.
"""

from __future__ import annotations

import socket
import time
from collections.abc import Sequence

from grabbergui.driver.gige.block_assembler import BlockAssembler
from grabbergui.driver.gige.message_slots import (
    FOREIGN,
    SLOTS,
    MessageSlots,
    Stretch,
    available,
    join_packets,
)
from grabbergui.driver.gige.pace import Pace
from grabbergui.driver.gige.paced_source import PacedSource
from grabbergui.driver.gige.readiness import waiter
from grabbergui.driver.gige.stream_socket import buffer_bytes

__all__ = ["BatchSource", "available"]

BATCHES = 8
"Calls before timers and finished frames are looked after."
SKIPS = 256
"Calls that throw away at most: more comes meanwhile."


class BatchSource(PacedSource):
    """Feeds an assembler from a socket, or from several at one port, by batches. One thread."""

    def __init__(self, receiver: socket.socket, device_ip: str, more: Sequence[socket.socket] = ()) -> None:
        """`more` are further sockets at the same port, which become the source's own."""
        self._more = more
        sockets = [receiver, *more]
        self._descriptors = [each.fileno() for each in sockets]
        self._wait = waiter(sockets)
        for each in sockets:
            join_packets(each)
        self._slots = MessageSlots(device_ip)
        super().__init__(Pace(sum(map(buffer_bytes, sockets)), SLOTS * BATCHES))
        self._newest = 0
        "Which socket the last packets came from."

    def _take_all(self, assembler: BlockAssembler, timeout: float) -> float:
        """See PacedSource."""
        waiting = self._waiting(timeout)
        now = time.monotonic()
        for index in waiting:
            now = self._drain(index, assembler)
        return now

    def close(self) -> None:
        """Close the further sockets."""
        for each in self._more:
            each.close()

    def _discard(self) -> None:
        """See PacedSource."""
        for descriptor in self._descriptors:
            for _ in range(SKIPS):
                if self._slots.skip(descriptor) < self._slots.count:
                    break

    def _waiting(self, timeout: float) -> list[int]:
        """Which sockets to read, in the order in which packets are given to them; some may be empty."""
        count = len(self._descriptors)
        if count == 1 and not timeout:
            return [0]
        ready = [self._descriptors.index(descriptor) for descriptor in self._wait(timeout)]
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
