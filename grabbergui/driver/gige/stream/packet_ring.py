"""Packets from a ring that the kernel fills, without a system call for receiving them. Linux.

The UDP socket stays open to reserve its port, and shows the ends of blocks: a filter leaves it their
trailers, so that a pause in which packets gather ends with the block.

A ring does not see every packet that a UDP socket receives whole: fragments, packets joined on their way,
multicast from this host, packets unpacked by IPsec. So after each silence the UDP socket receives everything,
until the ring has proved that it sees the stream. Where the ring fails, the UDP socket takes over for the
rest of the stream.
"""

from __future__ import annotations

import contextlib
import logging
import platform
import socket
import sys
import time
from collections.abc import Callable
from enum import Enum

from grabbergui.driver.gige.discovery import Interface
from grabbergui.driver.gige.gvsp import IP_UDP_BYTES
from grabbergui.driver.gige.stream.assembler import BlockAssembler
from grabbergui.driver.gige.stream.batches import PacedSource
from grabbergui.driver.gige.stream.receiver import DatagramSource, Pace
from grabbergui.driver.gige.stream.recvmmsg import DONT_WAIT
from grabbergui.driver.gige.stream.ring_memory import AT_ONCE, IP_AT, Geometry, SpareRing
from grabbergui.driver.gige.stream.sockets import (
    TRAILERS,
    attach,
    detach,
    kernel_bytes,
    stream_filter,
)

log = logging.getLogger(__name__)


class RingUse(Enum):
    """Whether a stream is received through a packet ring."""

    AUTO = "auto"
    "If this process may and the packets allow it."
    ALWAYS = "1"
    "As `AUTO`, with a warning if this process may not."
    NEVER = "0"


PAYLOAD_AT = IP_AT + IP_UDP_BYTES
PROOF = 16
"Packets through the ring after which the UDP socket receives trailers only."
SILENCE = 0.5
"Seconds without a packet after which the UDP socket receives again."
MOST_DISCARDED = 1 << 16
"Packets discarded at a time, should more arrive meanwhile."
GRACE = 0.02
"Seconds in which a packet that reached the UDP socket must be in the ring, too."


def usable(interface: Interface, packet_size: int) -> bool:
    """Return whether packets of this size arrive whole, on a processor that keeps the order of stores."""
    known = sys.platform == "linux" and platform.machine() == "x86_64"
    return known and packet_size <= interface.mtu


class PacketRing(PacedSource):
    """Feeds an assembler from a ring; if the ring does not see the stream, from the source in reserve."""

    def __init__(
        self,
        receiver: socket.socket,
        device_ip: str,
        reserve: Callable[[], DatagramSource],
        spare: SpareRing,
        *,
        packet_size: int,
        wanted: int,
    ) -> None:
        """Read a ring for `wanted` bytes of packets, in place of the bound socket `receiver`.

        `packet_size` counts the headers of IP and UDP. `reserve` makes a source that reads `receiver`. The
        ring comes from `spare`, and returns to it at the end. Raises OSError, PermissionError without
        CAP_NET_RAW.
        """
        self._receiver = receiver
        self._device_ip = device_ip
        self._make_reserve = reserve
        self._reserve: DatagramSource | None = None
        self._spare = spare
        self._ring = spare.take(Geometry(packet_size, wanted))
        self.unsuitable = False
        "Whether the stream has packets that no ring can take: fragments, joined ones, or longer ones."
        self._proved: int | None = 0
        "Packets through the ring since the UDP socket receives all, too; None while it does not."
        self._last_packet = time.monotonic()
        slots = self._ring.size.slots
        try:
            self._ring.admit(stream_filter(device_ip, *receiver.getsockname()[:2]))
            _empty(receiver)  # test packets that the ring has not seen
            super().__init__(Pace(int(slots * kernel_bytes(packet_size)), slots), [self._ring.socket])
        except BaseException:
            self._ring.free()
            raise
        self._wait_for_trailer = self._waits.waiter([receiver])
        self._wait_for_both = self._waits.waiter([self._ring.socket, receiver])

    def receive(self, assembler: BlockAssembler, timeout: float) -> None:
        """Take packets from the ring, or once it has failed, from the reserve."""
        if self._reserve is not None:
            self._reserve.realtime = self.realtime
            self._reserve.receive(assembler, timeout)
            return
        super().receive(assembler, timeout)
        if self._trailers_only and self._flowing and not assembler.block_in_progress:
            _empty(self._receiver)

    def wake(self) -> None:
        """Let `receive` return, also that of the reserve."""
        super().wake()
        if self._reserve is not None:
            self._reserve.wake()

    def close(self) -> None:
        """Leave the ring to the next stream."""
        super().close()
        if self._reserve is not None:
            self._reserve.close()
        else:
            self._spare.keep(self._ring)

    @property
    def failed(self) -> bool:
        """Whether the reserve took over."""
        return self._reserve is not None

    @property
    def _trailers_only(self) -> bool:
        return self._proved is None and not self.failed

    # -- the ring --------------------------------------------------------------------------------
    def _take_all(self, assembler: BlockAssembler, timeout: float) -> float:
        ring = self._ring
        if timeout and not ring.has_packet and not self._await_packets(timeout):
            return time.monotonic()
        now = time.monotonic()
        for _ in range(len(ring.slots) // AT_ONCE + 2):
            count = ring.full_slots()
            if not count or not self._take(assembler, count, now):
                return now
            ring.give_back(count)
            self._note_packets(count, now)
            if count < AT_ONCE and ring.at:
                return now
            now = time.monotonic()
        self._drained = False
        return now

    def _take(self, assembler: BlockAssembler, count: int, now: float) -> bool:
        """Give packets to the assembler, those of equal length at once; return False if some are no packets.

        The ring has failed then.
        """
        taken = slice(self._ring.at, self._ring.at + count)
        lengths, odd = self._ring.lengths(taken)
        if odd.any():
            # While the UDP socket receives too, it has all of them.
            count = 0 if self._proved is not None else int(odd.argmax())
        slots = self._ring.slots[taken]
        breaks = ((lengths[1:count] != lengths[: max(count - 1, 0)]).nonzero()[0] + 1).tolist()
        for begin, end in zip([0, *breaks], [*breaks, count], strict=True):
            if begin < end:
                assembler.receive_rows(slots[begin:end, PAYLOAD_AT : PAYLOAD_AT + int(lengths[begin])], now)
        if count == len(odd):
            return True
        del slots
        self.unsuitable = True
        self._fail("packets are fragments, joined, or longer than announced")
        return False

    def _discard(self) -> None:
        self._ring.discard()

    # -- the UDP socket --------------------------------------------------------------------------
    def _rest(self, seconds: float) -> bool:
        """Wait until the block ends, which its trailer in the UDP socket shows, for whole milliseconds."""
        if self._trailers_only and seconds >= 0.001:
            whole = int(1000 * seconds) / 1000
            if self._wait_for_trailer(whole):
                _empty(self._receiver)
                return False
            seconds -= whole
        return super()._rest(seconds)

    def _await_packets(self, timeout: float) -> bool:
        """Wait at most `timeout` seconds for a packet; return False if the ring has failed."""
        if self._proved == 0:
            ready = self._wait_for_both(timeout)
            missed = ready and self._ring.socket.fileno() not in ready and self._socket_has_stream()
            if missed and not self._wait(GRACE):
                self._fail("it does not see packets that the UDP socket receives")
                return False
            return True
        if not self._wait(timeout) and time.monotonic() - self._last_packet > SILENCE:
            self._listen_again()
        return True

    def _socket_has_stream(self) -> bool:
        """Return whether the UDP socket holds a packet from the device; discard those of others before it."""
        with contextlib.suppress(BlockingIOError):
            for _ in range(MOST_DISCARDED):
                _, (source, _) = self._receiver.recvfrom(1, DONT_WAIT | socket.MSG_PEEK)
                if source == self._device_ip:
                    return True
                self._receiver.recv(1, DONT_WAIT)
        return False

    def _note_packets(self, count: int, now: float) -> None:
        """Leave the UDP socket only trailers once the ring has taken enough packets."""
        self._last_packet = now
        if self._proved is not None:
            self._proved += count
            if self._proved >= PROOF:
                attach(self._receiver, TRAILERS)
                _empty(self._receiver)
                self._proved = None

    def _listen_again(self) -> None:
        """Let the UDP socket receive, too: a change of the network may hide the stream from the ring."""
        if self._proved is None:
            detach(self._receiver)
        _empty(self._receiver)
        self._proved = 0

    def _fail(self, why: str) -> None:
        log.info("packets are received by system calls, no longer through a packet ring: %s", why)
        if self._proved is None:
            _empty(self._receiver)
            detach(self._receiver)
        self._ring.free()
        self._reserve = self._make_reserve()


def _empty(receiver: socket.socket) -> None:
    """Discard what a socket has received."""
    with contextlib.suppress(BlockingIOError):
        for _ in range(MOST_DISCARDED):
            receiver.recv(1, DONT_WAIT)
