"""Many datagrams with one system call, and many packets in one datagram. Linux.

`recvmmsg` takes all that waits at the socket. With UDP_GRO the kernel also joins equally long packets that
follow each other to one datagram of up to 64 KB, and says how long each of them was. Either way packets of
equal length become the rows of an array, which the assembler takes whole.
"""

from __future__ import annotations

import select
import socket
import time

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

BATCHES = 8
"Calls before timers and finished frames are looked after."


class BatchSource(DatagramSource):
    """Feeds an assembler from a socket by batches. One thread."""

    def __init__(self, receiver: socket.socket, device_ip: str) -> None:
        join_packets(receiver)
        self._slots = MessageSlots(receiver, device_ip)
        self._pace = Pace(buffer_bytes(receiver), SLOTS * BATCHES)
        self._poll = select.poll()
        self._poll.register(receiver, select.POLLIN)
        self._drained = True
        "Whether the socket was empty when it was last looked at."

    def receive(self, assembler: BlockAssembler, timeout: float) -> None:
        """See DatagramSource."""
        if self._drained:
            pause = self._pace.pause(assembler.expected(), assembler.stride)
            if pause:
                time.sleep(pause)
            else:
                self._poll.poll(1000 * timeout)
        before = assembler.statistics.packets
        for _ in range(BATCHES):
            slots = self._slots.count
            received = self._slots.receive()
            now = time.monotonic()
            if received:
                self._take(assembler, received, now)
            self._drained = received < slots
            if self._drained:
                break
        packets = assembler.statistics.packets - before
        self._pace.took(packets, now, more=assembler.expected() > 0)

    def _take(self, assembler: BlockAssembler, received: int, now: float) -> None:
        """Give a batch to the assembler, stretches of equally long datagrams at once."""
        for stretch in self._slots.stretches(received):
            if stretch.length == FOREIGN:
                assembler.statistics.packets_ignored += stretch.end - stretch.begin
                continue
            rows = self._slots.rows(stretch)
            if rows is not None:
                assembler.receive_rows(rows, now)
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
