"""Many datagrams with one system call, each scattered to its place in the picture. Linux.

`recvmmsg` fills slots of three pieces: the packet's header, its payload at the place where the next packets
are expected to belong, and an overflow. Headers are then checked all at once with numpy; what is as expected
needs no further work, the rest (leaders, trailers, packets after a gap) goes the assembler's general way.
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

from grabbergui.driver.gige.block_assembler import BlockAssembler, Landing
from grabbergui.driver.gige.datagram_source import MAX_DATAGRAM, DatagramSource
from grabbergui.driver.gige.gvsp import EXTENDED_BIT, PacketFormat
from grabbergui.driver.gige.stream_socket import buffer_bytes

SLOTS = 128
"Datagrams a call."
BATCHES = 8
"Calls before timers and finished frames are looked after."
LONGEST_PAUSE = 0.0005
"Seconds to let packets gather once the socket was empty: fewer, larger batches cost less."
FASTEST_FILL = 1.6e9
"Bytes a second, the kernel's book-keeping included: a pause may let this fill a sixteenth of the buffer."

IOVEC = np.dtype([("base", np.uint64), ("length", np.uint64)])
MMSGHDR = np.dtype(
    {
        "names": ["name", "name_length", "iov", "iov_length", "received"],
        "formats": [np.uint64, np.uint32, np.uint64, np.uint64, np.uint32],
        "offsets": [0, 8, 16, 24, 56],
        "itemsize": 64,
    }
)
"`struct mmsghdr` of 64-bit Linux."

STANDARD_HEADER = np.dtype([("word", ">u8")])
EXTENDED_HEADER = np.dtype([("word", ">u8"), ("block_id", ">u8"), ("packet_id", ">u4")])


def available() -> bool:
    """Whether this system has it."""
    return sys.platform == "linux" and ctypes.sizeof(ctypes.c_void_p) == 8


class BatchSource(DatagramSource):
    """Feeds an assembler from a socket by batches. One thread."""

    def __init__(self, receiver: socket.socket, device_ip: str) -> None:
        self._socket = receiver
        self._device_ip = int.from_bytes(socket.inet_aton(device_ip), "big")
        self._call = ctypes.CDLL(None, use_errno=True).recvmmsg
        # More would let a small buffer run over while we wait.
        self._pause = min(LONGEST_PAUSE, buffer_bytes(receiver) / 16 / FASTEST_FILL)
        self._headers = {
            False: np.zeros(SLOTS, STANDARD_HEADER),
            True: np.zeros(SLOTS, EXTENDED_HEADER),
        }
        self._scratch = np.zeros((SLOTS, MAX_DATAGRAM), np.uint8)
        self._names = np.zeros((SLOTS, 16), np.uint8)
        self._sources = self._names[:, 4:8].view(">u4")[:, 0]
        self._iov = np.zeros((SLOTS, 3), IOVEC)
        self._iov["base"][:, 1] = self._iov["base"][:, 2] = _addresses(self._scratch)
        self._messages = np.zeros(SLOTS, MMSGHDR)
        self._messages["name"] = _addresses(self._names)
        self._messages["name_length"] = 16
        self._messages["iov"] = _addresses(self._iov)
        self._messages["iov_length"] = 3
        self._received = self._messages["received"]
        self._scratch_addresses = _addresses(self._scratch)
        self._counting = np.arange(SLOTS, dtype=np.uint64)
        self._extended: bool | None = None
        self._direct = 0

    def receive(self, assembler: BlockAssembler, timeout: float) -> None:
        """See DatagramSource."""
        for batch in range(BATCHES):
            landing = assembler.landing(SLOTS)
            self._aim(landing)
            count = self._receive()
            if not count:
                if batch or not select.select([self._socket], [], [], timeout)[0]:
                    return
                if self._pause:
                    time.sleep(self._pause)
                count = self._receive()
            self._take(assembler, landing, count)

    def _aim(self, landing: Landing | None) -> None:
        """Point the slots to where the next packets are expected to belong, the others to scratch memory."""
        extended = landing.extended if landing is not None else bool(self._extended)
        iov = self._iov
        if extended is not self._extended:
            self._extended = extended
            headers = self._headers[extended]
            iov["base"][:, 0] = _addresses(headers)
            iov["length"][:, 0] = headers.itemsize
        direct = landing.count if landing is not None else 0
        if landing is not None:
            stride = landing.stride
            iov["base"][:direct, 1] = landing.address + self._counting[:direct] * np.uint64(stride)
            iov["length"][:direct, 1] = stride
            iov["length"][:direct, 2] = MAX_DATAGRAM
        if direct < self._direct or not direct:
            iov["base"][direct:, 1] = self._scratch_addresses[direct:]
            iov["length"][direct:, 1] = MAX_DATAGRAM
            iov["length"][direct:, 2] = 0
        self._direct = direct

    def _receive(self) -> int:
        flags = socket.MSG_DONTWAIT
        count: int = self._call(
            self._socket.fileno(), ctypes.c_void_p(self._messages.ctypes.data), SLOTS, flags, None
        )
        if count >= 0:
            return count
        code = ctypes.get_errno()
        if code in (errno.EAGAIN, errno.EINTR, errno.ECONNREFUSED):
            return 0
        raise OSError(code, os.strerror(code))

    def _take(self, assembler: BlockAssembler, landing: Landing | None, count: int) -> None:
        if not count:
            return
        now = time.monotonic()
        good = 0
        if landing is not None:
            good = self._as_expected(landing, min(count, landing.count))
            # What landed in a place that is not its own must be out of the way before others are put right.
            rest = [self._datagram(slot, landing) for slot in range(good, count)]
            assembler.landed(landing, good, now)
        else:
            rest = [self._datagram(slot, None) for slot in range(count)]
        for datagram in rest:
            if datagram is None:
                assembler.statistics.packets_ignored += 1
            else:
                assembler.receive(datagram, now)

    def _as_expected(self, landing: Landing, count: int) -> int:
        """How many slots, from the first on, hold the full packet that was expected there."""
        headers = self._headers[landing.extended][:count]
        lengths = headers.itemsize + landing.stride
        right = (self._received[:count] == lengths) & (self._sources[:count] == self._device_ip)
        packets = landing.first + self._counting[:count]
        if landing.extended:
            kind = (PacketFormat.PAYLOAD | EXTENDED_BIT) << 24
            right &= (headers["word"] == kind) & (headers["block_id"] == landing.block.block_id)
            right &= headers["packet_id"] == packets
        else:
            base = landing.block.block_id << 32 | PacketFormat.PAYLOAD << 24
            right &= headers["word"] == np.uint64(base) + packets
        return count if right.all() else int(right.argmin())

    def _datagram(self, slot: int, landing: Landing | None) -> bytes | None:
        """A copy of what a slot received, in one piece; None where it is not from our device."""
        if int(self._sources[slot]) != self._device_ip:
            return None
        length = int(self._received[slot])
        header = self._headers[bool(self._extended)][slot : slot + 1].tobytes()[:length]
        body = length - len(header)
        if landing is None or slot >= landing.count:
            return header + self._scratch[slot, :body].tobytes()
        begin = (landing.first - 1 + slot) * landing.stride
        assert landing.block.buffer is not None
        landed = landing.block.buffer[begin : begin + min(body, landing.stride)].tobytes()
        return header + landed + self._scratch[slot, : max(0, body - landing.stride)].tobytes()


def _addresses(array: NDArray[Any]) -> NDArray[np.uint64]:
    """Where each row of an array begins."""
    rows: NDArray[np.uint64] = array.ctypes.data + np.arange(len(array), dtype=np.uint64) * np.uint64(
        array.strides[0]
    )
    return rows
