"""Memory that the kernel shares with us and fills with packets: a packet socket with a ring. Linux.

A packet socket with a ring (`packet(7)`, PACKET_RX_RING, TPACKET_V2) has each packet written into a slot of
fixed length while it arrives; the process only reads the slots. This needs CAP_NET_RAW, and receives packets
before any firewall. The socket listens on all interfaces, so that a route may change and an interface may
vanish and return; a filter in the kernel admits only the packets of one stream.

The kernel takes 10 to 20 ms to make a ring, and as long to free it. So `SpareRing` keeps one over a pause of
the stream, as for a change of PixelFormat.
"""

from __future__ import annotations

import contextlib
import mmap
import os
import socket
import struct
import threading

import numpy as np
from numpy.typing import NDArray

from grabbergui.driver.gige.gvsp import IP_UDP_BYTES
from grabbergui.driver.gige.stream.sockets import NOTHING, Instruction, attach

AF_PACKET = 17
"The socket module names it on Linux only."
SOL_PACKET, PACKET_RX_RING, PACKET_VERSION, TPACKET_V2 = 263, 5, 10, 1
ETH_P_IP = 0x0800
OURS = 1
"TP_STATUS_USER: the slot holds a packet, and belongs to us until 0 is written."
IP_AT = 80
"Bytes of a slot before the IP header: `struct tpacket2_hdr`, `struct sockaddr_ll` and what aligns them."
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
KEPT = 1.0
"Seconds for which a ring waits for the next stream."
MOST_SPARE = 4
"How many times larger than needed a kept ring may be: the processor's cache holds less of a large one."

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

    def serves(self, wanted: Geometry) -> bool:
        """Return whether a ring of these sizes serves a stream that wants others."""
        return self.slot == wanted.slot and wanted.slots <= self.slots <= MOST_SPARE * wanted.slots


class Ring:
    """A packet socket and its slots, which are taken and returned in order. It admits nothing at first."""

    def __init__(self, size: Geometry) -> None:
        """Raises OSError, PermissionError without CAP_NET_RAW."""
        self.size = size
        # With a protocol it listens to all interfaces at once; what comes before the ring is discarded.
        self.socket = socket.socket(AF_PACKET, socket.SOCK_DGRAM, socket.htons(ETH_P_IP))
        try:
            attach(self.socket, NOTHING)
            self.socket.setsockopt(SOL_PACKET, PACKET_VERSION, TPACKET_V2)
            geometry = struct.pack("=4I", size.block, size.blocks, size.slot, size.slots)
            self.socket.setsockopt(SOL_PACKET, PACKET_RX_RING, geometry)
            self._memory = mmap.mmap(self.socket.fileno(), size.bytes)
        except BaseException:
            self.socket.close()
            raise
        self.slots = np.frombuffer(self._memory, np.uint8).reshape(size.slots, size.slot)
        self._headers = self.slots[:, : _HEADER.itemsize].view(_HEADER)[:, 0]
        self.statuses = self._headers["status"]
        self._ip_headers = self.slots[:, IP_AT : IP_AT + 8].view(">u8")[:, 0]
        self.at = 0
        "Index of the next slot."

    @property
    def has_packet(self) -> bool:
        """Whether the next slot holds a packet."""
        return bool(self.statuses[self.at] & OURS)

    def admit(self, program: list[Instruction]) -> None:
        """Let the ring receive what a filter admits, in place of its last one. Raises OSError."""
        attach(self.socket, program)

    def full_slots(self) -> int:
        """Return how many slots from the next one on hold packets: `AT_ONCE` at most, to the array's end."""
        statuses = self.statuses[self.at : self.at + AT_ONCE]
        end = FIRST_LOOK
        while end < len(statuses) and statuses[end - 1] & OURS:
            end *= 4
        empty = (statuses[:end] & OURS) == 0
        first = int(empty.argmax())
        return first if empty[first] else len(empty)

    def lengths(self, taken: slice) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
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

    def give_back(self, count: int) -> None:
        """Return the next slots to the kernel."""
        self.statuses[self.at : self.at + count] = 0
        self.at = (self.at + count) % len(self.slots)

    def discard(self) -> None:
        """Return all full slots, up to the first empty one, as processors may fill slots out of order."""
        for _ in range(len(self.slots) // AT_ONCE + 2):
            count = self.full_slots()
            if not count:
                return
            self.give_back(count)

    def free(self) -> None:
        """Free the memory on a thread; the ring must not be used any more. May be called twice."""
        if self.socket.fileno() < 0:
            return
        memory = (self.socket.detach(), self._memory)
        del self.statuses, self._headers, self._ip_headers, self.slots, self._memory
        threading.Thread(target=_free, args=memory, name="free-ring", daemon=True).start()


def _free(descriptor: int, memory: mmap.mmap) -> None:
    """Free a ring; the kernel waits 10 to 30 ms until no processor uses it."""
    os.close(descriptor)
    with contextlib.suppress(BufferError):  # a view is left; the memory is unmapped with it
        memory.close()


class SpareRing:
    """Keeps the ring of a stream for the next one, for `KEPT` seconds at most. Any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._ring: Ring | None = None
        self._end: threading.Timer | None = None

    def keep(self, ring: Ring) -> None:
        """Keep a ring that is no longer read."""
        self.free()
        try:
            ring.admit(NOTHING)
        except OSError:  # the system has no memory for a filter
            ring.free()
            return
        with self._lock:
            self._ring = ring
            self._end = threading.Timer(KEPT, self.free)
            self._end.name, self._end.daemon = "spare-ring", True
            self._end.start()

    def take(self, wanted: Geometry) -> Ring:
        """Return the kept ring, empty, if it serves; else a new one. Raises as `Ring`."""
        ring = self._let_go()
        if ring is not None and ring.size.serves(wanted):
            ring.discard()  # what came between the stream's end and `keep`
            return ring
        if ring is not None:
            ring.free()
        return Ring(wanted)

    def free(self) -> None:
        """Free the kept ring, if there is one."""
        ring = self._let_go()
        if ring is not None:
            ring.free()

    def _let_go(self) -> Ring | None:
        with self._lock:
            ring, end = self._ring, self._end
            self._ring = self._end = None
        if end is not None:
            end.cancel()
        return ring
