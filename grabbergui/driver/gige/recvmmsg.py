"""Many datagrams with one system call, and many packets in one datagram. Linux.

`recvmmsg` takes all that waits at the socket. With UDP_GRO the kernel also joins equally long packets that
follow each other to one datagram of up to 64 KB, and says how long each of them was. Either way packets of
equal length become the rows of an array, which the assembler takes whole.
"""

from __future__ import annotations

import ctypes
import errno
import os
import select
import socket
import sys
import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grabbergui.driver.gige.block_assembler import BlockAssembler
from grabbergui.driver.gige.datagram_source import MAX_DATAGRAM, DatagramSource
from grabbergui.driver.gige.pace import Pace
from grabbergui.driver.gige.stream_socket import buffer_bytes

SLOTS = 512
"Datagrams a call, at most."
BATCH_BYTES = 1 << 20
"Of all slots together: so much fits into the processor's cache."
BATCHES = 8
"Calls before timers and finished frames are looked after."
SHRINK_AFTER = 64
"Datagrams shorter than a slot, in a row, after which slots are made smaller."
USUAL_DATAGRAM = 1500
SHORTEST_SLOT = 64
FOREIGN = -1
"Kind of a datagram that is not from our device. Other kinds: its length, and above that of joined packets."
LENGTH_BITS = 20
LENGTH_MASK = (1 << LENGTH_BITS) - 1
UDP_GRO = 104
"Linux 5.0: option of a socket, and type of the control message that tells the length of joined packets."

IOVEC = np.dtype([("base", np.uint64), ("length", np.uint64)])
MMSGHDR = np.dtype(
    {
        "names": [
            "name",
            "name_length",
            "iov",
            "iov_length",
            "control",
            "control_length",
            "flags",
            "received",
        ],
        "formats": [
            np.uint64,
            np.uint32,
            np.uint64,
            np.uint64,
            np.uint64,
            np.uint64,
            np.int32,
            np.uint32,
        ],
        "offsets": [0, 8, 16, 24, 32, 40, 48, 56],
        "itemsize": 64,
    }
)
"`struct mmsghdr` of 64-bit Linux."
CONTROL = np.dtype(
    {
        "names": ["length", "level", "type", "packet_length"],
        "formats": [np.uint64, np.int32, np.int32, np.int32],
        "offsets": [0, 8, 12, 16],
        "itemsize": 24,
    }
)
"`struct cmsghdr` with the number that UDP_GRO adds."
SOCKADDR_BYTES = 16


def available() -> bool:
    """Whether this system has it."""
    return sys.platform == "linux" and ctypes.sizeof(ctypes.c_void_p) == 8


class BatchSource(DatagramSource):
    """Feeds an assembler from a socket by batches. One thread."""

    def __init__(self, receiver: socket.socket, device_ip: str) -> None:
        self._socket = receiver
        self._device_ip = int.from_bytes(socket.inet_aton(device_ip), "big")
        self._call = ctypes.CDLL(None, use_errno=True).recvmmsg
        self._poll = select.poll()
        self._poll.register(receiver, select.POLLIN)
        join_packets(receiver)
        self._pace = Pace(buffer_bytes(receiver), SLOTS * BATCHES)
        self._drained = True
        self._data = np.zeros(BATCH_BYTES + MAX_DATAGRAM, np.uint8)
        "Slots one after another, so that equally long datagrams lie without a gap."
        self._overflow = np.zeros((SLOTS, MAX_DATAGRAM), np.uint8)
        "What a slot is too short for. Hardly ever touched, so it takes no memory."
        self._names = np.zeros((SLOTS, SOCKADDR_BYTES), np.uint8)
        self._sources = self._names[:, 4:8].view(">u4")[:, 0]
        self._control = np.zeros(SLOTS, CONTROL)
        self._packet_lengths = self._control["packet_length"]
        self._iov = np.zeros((SLOTS, 2), IOVEC)
        self._iov["base"][:, 1] = _addresses(self._overflow)
        self._iov["length"][:, 1] = MAX_DATAGRAM
        self._messages = np.zeros(SLOTS, MMSGHDR)
        self._messages["name"] = _addresses(self._names)
        self._messages["name_length"] = SOCKADDR_BYTES
        self._messages["iov"] = _addresses(self._iov)
        self._messages["iov_length"] = 2
        self._messages["control"] = _addresses(self._control)
        self._lengths = self._messages["received"]
        self._control_lengths = self._messages["control_length"]
        self._shorter = 0
        self._divide(USUAL_DATAGRAM)

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
            count = self._receive()
            now = time.monotonic()
            self._take(assembler, count, now)
            self._drained = count < self._slots
            if self._drained:
                break
        packets = assembler.statistics.packets - before
        self._pace.took(packets, now, more=assembler.expected() > 0)

    def _receive(self) -> int:
        self._control_lengths[: self._slots] = CONTROL.itemsize
        count: int = self._call(
            self._socket.fileno(),
            ctypes.c_void_p(self._messages.ctypes.data),
            self._slots,
            socket.MSG_DONTWAIT,
            None,
        )
        if count >= 0:
            return count
        code = ctypes.get_errno()
        if code in (errno.EAGAIN, errno.EINTR, errno.ECONNREFUSED):
            return 0
        raise OSError(code, os.strerror(code))

    def _take(self, assembler: BlockAssembler, count: int, now: float) -> None:
        """Give a batch to the assembler, stretches of equally long datagrams at once."""
        if not count:
            return
        kinds = self._lengths[:count].astype(np.int64)
        joined = self._control_lengths[:count] != 0
        if joined.any():
            kinds |= self._packet_lengths[:count].astype(np.int64) * joined << LENGTH_BITS
        foreign = self._sources[:count] != self._device_ip
        if foreign.any():
            kinds[foreign] = FOREIGN
        breaks = ((kinds[1:] != kinds[:-1]).nonzero()[0] + 1).tolist()
        for begin, end in zip([0, *breaks], [*breaks, count], strict=True):
            kind = int(kinds[begin])
            if kind == FOREIGN:
                assembler.statistics.packets_ignored += end - begin
            else:
                length, packet_length = kind & LENGTH_MASK, kind >> LENGTH_BITS
                self._take_equal(assembler, begin, end, length, packet_length or length, now)
        self._fit(int(self._lengths[:count].max()), count)

    def _take_equal(
        self, assembler: BlockAssembler, begin: int, end: int, length: int, packet_length: int, now: float
    ) -> None:
        """Datagrams of slots `begin` to `end`, each of `length` bytes, cut into packets."""
        if length <= self._pitch and length == packet_length:
            slots = self._data[begin * self._pitch : end * self._pitch].reshape(-1, self._pitch)
            assembler.receive_rows(slots[:, :length], now)
        elif length == self._pitch and length % packet_length == 0:
            slots = self._data[begin * self._pitch : end * self._pitch]
            assembler.receive_rows(slots.reshape(-1, packet_length), now)
        else:
            for slot in range(begin, end):
                datagram = self._datagram(slot, length)
                whole = length - length % packet_length
                assembler.receive_rows(datagram[:whole].reshape(-1, packet_length), now)
                if whole < length:
                    assembler.receive(datagram[whole:].data, now)

    def _datagram(self, slot: int, length: int) -> NDArray[np.uint8]:
        """What a slot received, in one piece."""
        begin = slot * self._pitch
        if length <= self._pitch:
            return self._data[begin : begin + length]
        rest = self._overflow[slot, : length - self._pitch]
        return np.concatenate([self._data[begin : begin + self._pitch], rest])

    def _fit(self, longest: int, count: int) -> None:
        """Make slots as long as datagrams are, at once where these grow, later where they shrink."""
        if longest > self._pitch:
            self._divide(longest)
        elif longest == self._pitch:
            self._shorter = self._longest_shorter = 0
        else:
            self._shorter += count
            self._longest_shorter = max(self._longest_shorter, longest)
            if self._shorter > SHRINK_AFTER:
                self._divide(max(self._longest_shorter, SHORTEST_SLOT))

    def _divide(self, pitch: int) -> None:
        """Make slots of `pitch` bytes."""
        self._pitch = pitch
        self._slots = min(SLOTS, BATCH_BYTES // pitch)
        self._shorter = self._longest_shorter = 0
        begins = np.arange(SLOTS, dtype=np.uint64) * np.uint64(pitch)
        self._iov["base"][:, 0] = self._data.ctypes.data + begins
        self._iov["length"][:, 0] = pitch


def join_packets(receiver: socket.socket) -> bool:
    """Let the kernel join packets that come to a socket, as UDP_GRO does; whether it can."""
    try:
        receiver.setsockopt(socket.SOL_UDP, UDP_GRO, 1)
    except OSError:
        return False
    return True


def _addresses(array: NDArray[Any]) -> NDArray[np.uint64]:
    """Where each row of an array begins."""
    rows: NDArray[np.uint64] = array.ctypes.data + np.arange(len(array), dtype=np.uint64) * np.uint64(
        array.strides[0]
    )
    return rows
