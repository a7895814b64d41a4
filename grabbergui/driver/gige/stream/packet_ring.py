"""Packets from memory that the kernel shares with us, without a system call for receiving them. Linux.

A packet socket with a ring (`packet(7)`, PACKET_RX_RING, TPACKET_V2) has each packet written into a slot of
fixed length while it arrives; the process only reads the slots. This needs CAP_NET_RAW, and receives packets
before any firewall. The socket listens on all interfaces, so that a route may change and an interface may
vanish and return; a filter in the kernel admits only the stream's packets.

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
import mmap
import os
import platform
import socket
import struct
import sys
import threading
import time
from collections.abc import Callable
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from grabbergui.driver.gige.discovery import Interface
from grabbergui.driver.gige.gvsp import IP_UDP_BYTES
from grabbergui.driver.gige.stream.assembler import BlockAssembler
from grabbergui.driver.gige.stream.batches import PacedSource
from grabbergui.driver.gige.stream.receiver import DatagramSource, Pace
from grabbergui.driver.gige.stream.recvmmsg import DONT_WAIT
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


AF_PACKET = 17
"The socket module names it on Linux only."
SOL_PACKET, PACKET_RX_RING, PACKET_VERSION, TPACKET_V2 = 263, 5, 10, 1
ETH_P_IP = 0x0800
OURS = 1
"TP_STATUS_USER: the slot holds a packet, and belongs to us until 0 is written."
IP_AT = 80
"Bytes of a slot before the IP header: `struct tpacket2_hdr`, `struct sockaddr_ll` and what aligns them."
PAYLOAD_AT = IP_AT + IP_UDP_BYTES
ALIGNMENT = 512
"Of a slot: few pages then hold a whole number of slots, and the ring is one array."
PAGE = 4096
BLOCK_BYTES = 1 << 18
"Contiguous memory of the kernel, at most. Slots do not span two blocks."
LEAST_BYTES, MOST_BYTES = 8 << 20, 64 << 20
AT_ONCE = 1024
"Packets taken before their slots are returned."
FIRST_LOOK = 16
"Slots looked at first; the range grows while all of them are full."
PROOF = 16
"Packets through the ring after which the UDP socket receives trailers only."
SILENCE = 0.5
"Seconds without a packet after which the UDP socket receives again."
MOST_DISCARDED = 1 << 16
"Packets discarded at a time, should more arrive meanwhile."
GRACE = 0.02
"Seconds in which a packet that reached the UDP socket must be in the ring, too."

_HEADER = np.dtype(
    [
        ("status", "<u4"),
        ("length", "<u4"),
        ("captured", "<u4"),
        ("link", "<u2"),
        ("network", "<u2"),
    ]
)
"The beginning of `struct tpacket2_hdr`."
_IP_LENGTH_SHIFT, _IP_LENGTH_MASK = np.uint64(32), np.uint64(0xFFFF)
_IP_KIND = np.uint64(0xFF00_0000_0000_3FFF)
"Version, header length, fragmentation in an IP header's first eight bytes."
_IP_PLAIN = np.uint64(0x4500_0000_0000_0000)


def usable(interface: Interface, packet_size: int) -> bool:
    """Return whether packets of this size arrive whole, on a processor that keeps the order of stores."""
    known = sys.platform == "linux" and platform.machine() == "x86_64"
    return known and packet_size <= interface.mtu


class Geometry:
    """Sizes of a ring whose slots are the rows of one array."""

    def __init__(self, packet_size: int, wanted: int) -> None:
        """Choose them for `wanted` bytes of packets, each of `packet_size` bytes from its IP header on."""
        self.slot = -(-(IP_AT + packet_size) // ALIGNMENT) * ALIGNMENT
        pages = self.slot // int(np.gcd(self.slot, PAGE)) * PAGE
        self.block = max(BLOCK_BYTES // pages, 1) * pages
        packets = -(-min(max(wanted, LEAST_BYTES), MOST_BYTES) // packet_size)
        self.blocks = -(-packets * self.slot // self.block)
        self.slots = self.blocks * self.block // self.slot
        self.bytes = self.blocks * self.block


class PacketRing(PacedSource):
    """Feeds an assembler from a ring; if the ring does not see the stream, from the source in reserve."""

    def __init__(
        self,
        receiver: socket.socket,
        device_ip: str,
        reserve: Callable[[], DatagramSource],
        *,
        packet_size: int,
        wanted: int,
    ) -> None:
        """Make a ring for `wanted` bytes of packets, to receive in place of the bound socket `receiver`.

        `packet_size` counts the headers of IP and UDP. `reserve` makes a source that reads `receiver`. Raises
        OSError, PermissionError without CAP_NET_RAW.
        """
        self._receiver = receiver
        self._device_ip = device_ip
        self._make_reserve = reserve
        self._reserve: DatagramSource | None = None
        size = Geometry(packet_size, wanted)
        # With a protocol it listens to all interfaces at once; what comes before the ring is discarded.
        self._socket = socket.socket(AF_PACKET, socket.SOCK_DGRAM, socket.htons(ETH_P_IP))
        try:
            attach(self._socket, stream_filter(device_ip, *receiver.getsockname()[:2]))
            self._socket.setsockopt(SOL_PACKET, PACKET_VERSION, TPACKET_V2)
            geometry = struct.pack("=4I", size.block, size.blocks, size.slot, size.slots)
            self._socket.setsockopt(SOL_PACKET, PACKET_RX_RING, geometry)
            self._memory = mmap.mmap(self._socket.fileno(), size.bytes)
            _empty(receiver)  # test packets that the ring has not seen
        except BaseException:
            self._socket.close()
            raise
        self._slots = np.frombuffer(self._memory, np.uint8).reshape(size.slots, size.slot)
        self._headers = self._slots[:, : _HEADER.itemsize].view(_HEADER)[:, 0]
        self._statuses = self._headers["status"]
        self._ip_headers = self._slots[:, IP_AT : IP_AT + 8].view(">u8")[:, 0]
        self.unsuitable = False
        "Whether the stream has packets that no ring can take: fragments, joined ones, or longer ones."
        self._at = 0
        "Index of the next slot."
        self._proved: int | None = 0
        "Packets through the ring since the UDP socket receives all, too; None while it does not."
        self._last_packet = time.monotonic()
        pace = Pace(int(size.slots * kernel_bytes(packet_size)), size.slots)
        super().__init__(pace, [self._socket])
        self._wait_for_trailer = self._waits.waiter([receiver])
        self._wait_for_both = self._waits.waiter([self._socket, receiver])

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
        """Release the memory."""
        super().close()
        self._release()
        if self._reserve is not None:
            self._reserve.close()

    @property
    def failed(self) -> bool:
        """Whether the reserve took over."""
        return self._reserve is not None

    @property
    def _trailers_only(self) -> bool:
        return self._proved is None and not self.failed

    # -- the ring --------------------------------------------------------------------------------
    def _take_all(self, assembler: BlockAssembler, timeout: float) -> float:
        if timeout and not self._statuses[self._at] & OURS and not self._await_packets(timeout):
            return time.monotonic()
        now = time.monotonic()
        for _ in range(len(self._slots) // AT_ONCE + 2):
            count = self._full_slots()
            if not count:
                return now
            if not self._take(assembler, count, now):
                return now
            self._statuses[self._at : self._at + count] = 0
            self._at = (self._at + count) % len(self._slots)
            self._note_packets(count, now)
            if count < AT_ONCE and self._at:
                return now
            now = time.monotonic()
        self._drained = False
        return now

    def _full_slots(self) -> int:
        """Return how many slots from the next one on hold packets, up to the end of the array."""
        statuses = self._statuses[self._at : self._at + AT_ONCE]
        end = FIRST_LOOK
        while end < len(statuses) and statuses[end - 1] & OURS:
            end *= 4
        empty = (statuses[:end] & OURS) == 0
        first = int(empty.argmax())
        return first if empty[first] else len(empty)

    def _take(self, assembler: BlockAssembler, count: int, now: float) -> bool:
        """Give packets to the assembler, those of equal length at once; return False if some are no packets.

        The ring has failed then.
        """
        taken = slice(self._at, self._at + count)
        lengths, odd = self._lengths(taken)
        if odd.any():
            # While the UDP socket receives too, it has all of them.
            count = 0 if self._proved is not None else int(odd.argmax())
        slots = self._slots[taken]
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

    def _lengths(self, taken: slice) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
        """Return the length of each UDP payload, and which slots do not hold exactly one packet."""
        headers, words = self._headers[taken], self._ip_headers[taken].astype(np.uint64)
        captured = headers["captured"]
        # Not the captured length: Ethernet pads short packets.
        ends = (words >> _IP_LENGTH_SHIFT & _IP_LENGTH_MASK).astype(np.intp)
        odd = (words & _IP_KIND) != _IP_PLAIN
        odd |= captured < headers["length"]
        odd |= headers["network"] != IP_AT
        odd |= (ends < IP_UDP_BYTES) | (ends > captured)
        return ends - IP_UDP_BYTES, odd

    def _discard(self) -> None:
        # Up to the first empty slot, as processors may fill slots out of order.
        for _ in range(len(self._slots) // AT_ONCE + 2):
            count = self._full_slots()
            if not count:
                return
            self._statuses[self._at : self._at + count] = 0
            self._at = (self._at + count) % len(self._slots)

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
            missed = ready and self._socket.fileno() not in ready and self._socket_has_stream()
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
        self._release()
        self._reserve = self._make_reserve()

    def _release(self) -> None:
        if self._socket.fileno() < 0:
            return
        ring = (self._socket.detach(), self._memory)
        del self._statuses, self._headers, self._ip_headers, self._slots, self._memory
        threading.Thread(target=_free, args=ring, name="free-ring", daemon=True).start()


def _free(descriptor: int, memory: mmap.mmap) -> None:
    """Free a ring; the kernel waits 10 to 30 ms until no processor uses it."""
    os.close(descriptor)
    with contextlib.suppress(BufferError):  # a view is left; the memory is unmapped with it
        memory.close()


def _empty(receiver: socket.socket) -> None:
    """Discard what a socket has received."""
    with contextlib.suppress(BlockingIOError):
        for _ in range(MOST_DISCARDED):
            receiver.recv(1, DONT_WAIT)
