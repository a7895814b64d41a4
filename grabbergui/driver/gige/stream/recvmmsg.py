"""Many datagrams with one system call, and many packets in one datagram. Linux.

`recvmmsg` takes all datagrams waiting at the socket. With UDP_GRO the kernel also joins consecutive packets
of equal length to one datagram of up to 64 KB, and reports the length of each. Either way packets of equal
length become the rows of an array, which the assembler takes at once. Structures are those of 64-bit Linux.
"""

from __future__ import annotations

import ctypes
import errno
import os
import socket
import sys
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grabbergui.driver.gige.stream.assembler import BlockAssembler
from grabbergui.driver.gige.stream.datagram_source import MAX_DATAGRAM
from grabbergui.driver.gige.stream.packet_origin import PacketOrigin

SLOTS = 512
"Datagrams a call, at most."
BATCH_BYTES = 2 << 20
"Bytes of all slots: with fewer, calls cost more than copies; more do not fit the processor's cache."
USUAL_DATAGRAM = 1500
SHORTEST_SLOT = 64
FEW = 6
"Datagrams that are looked at one by one: for more, arrays cost less."
SHRINK_AFTER = 512
"Datagrams shorter than a slot, in a row, after which slots are made smaller."
UDP_GRO = 104
"Linux 5.0: option of a socket, and type of the control message with the length of joined packets."
DONT_WAIT = 0x40
"Linux's MSG_DONTWAIT; the socket module of some other systems lacks it."
NO_DATAGRAM = (errno.EAGAIN, errno.EINTR, errno.ECONNREFUSED)
"Errors of a call that found no datagram."
SOCKADDR_BYTES = 16
FOREIGN = -1
"Kind of a datagram not from our device. Other kinds: its length, and above it that of joined packets."
LENGTH_BITS = 20
LENGTH_MASK = (1 << LENGTH_BITS) - 1
WHOLE = LENGTH_MASK
"""Stands for any length, of datagrams of one or more equally long packets that divide a slot evenly."""

IOVEC = np.dtype([("base", np.uint64), ("length", np.uint64)])
MMSGHDR = np.dtype(
    {
        "names": ["name", "name_length", "iov", "iov_length", "control", "control_length", "received"],
        "formats": [np.uint64, np.uint32, np.uint64, np.uint64, np.uint64, np.uint64, np.uint32],
        "offsets": [0, 8, 16, 24, 32, 40, 56],
        "itemsize": 64,
    }
)
"`struct mmsghdr`; fields not listed stay zero."
CONTROL = np.dtype(
    {
        "names": ["length", "level", "type", "packet_length"],
        "formats": [np.uint64, np.int32, np.int32, np.int32],
        "offsets": [0, 8, 12, 16],
        "itemsize": 24,
    }
)
"`struct cmsghdr` with the number that UDP_GRO adds."


def available() -> bool:
    """Return whether this system has these structures and the call."""
    return sys.platform == "linux" and ctypes.sizeof(ctypes.c_void_p) == 8


def join_packets(receiver: socket.socket) -> bool:
    """Let the kernel join the packets of a socket (UDP_GRO); return whether it can."""
    try:
        receiver.setsockopt(socket.SOL_UDP, UDP_GRO, 1)
    except OSError:
        return False
    return True


class SlotRun(NamedTuple):
    """Neighbouring slots that hold datagrams of one kind."""

    begin: int
    end: int
    length: int
    "Bytes of each datagram; `FOREIGN` where they are not from our device, `WHOLE` where lengths may differ."
    packet_length: int
    "Bytes of each packet in it, but the last, which may be shorter."


class Rows(NamedTuple):
    """Packets of equal length, in place."""

    array: NDArray[np.uint8]
    "A packet in each row; some rows may be unused."
    at: NDArray[np.intp] | None
    "Rows that hold packets, in the order of arrival; None: all."


class MessageSlots:
    """Slots of the datagrams' own length, so that these lie one after another without a gap."""

    def __init__(self, origin: PacketOrigin) -> None:
        self._origin = origin
        self._call = ctypes.CDLL(None, use_errno=True).recvmmsg
        # Keeps the GIL: for a single datagram a change of threads takes longer than the call.
        self._call_for_one = ctypes.PyDLL(None, use_errno=True).recvmmsg
        self._data = np.zeros(BATCH_BYTES + MAX_DATAGRAM, np.uint8)
        self._overflow = np.zeros((SLOTS, MAX_DATAGRAM), np.uint8)
        "The end of datagrams longer than a slot. Hardly ever touched, so it takes no memory."
        self._names = np.zeros((SLOTS, SOCKADDR_BYTES), np.uint8)
        self._sources = self._names[:, :8].view(np.uint64)[:, 0]
        "Keys of the senders, see `PacketOrigin.key`."
        self._control = np.zeros(SLOTS, CONTROL)
        self._packet_lengths = self._control["packet_length"]
        self._iov = np.zeros((SLOTS, 2), IOVEC)
        self._iov["base"][:, 1] = addresses(self._overflow)
        self._iov["length"][:, 1] = MAX_DATAGRAM
        self._messages = np.zeros(SLOTS, MMSGHDR)
        self._messages["name"] = addresses(self._names)
        self._messages["name_length"] = SOCKADDR_BYTES
        self._messages["iov"] = addresses(self._iov)
        self._messages["iov_length"] = 2
        self._messages["control"] = addresses(self._control)
        self._address: int = self._messages.ctypes.data
        self._lengths = self._messages["received"]
        self._control_lengths = self._messages["control_length"]
        self._divide(USUAL_DATAGRAM)

    def receive(self, descriptor: int, begin: int, end: int) -> int:
        """Take waiting datagrams from a socket into the slots from `begin` to `end`; return how many.

        Never waits. Raises OSError.
        """
        self._control_lengths[begin:end] = CONTROL.itemsize
        messages = ctypes.c_void_p(self._address + begin * MMSGHDR.itemsize)
        call = self._call if end - begin > 1 else self._call_for_one
        received: int = call(descriptor, messages, end - begin, DONT_WAIT, None)
        if received >= 0:
            return received
        code = ctypes.get_errno()
        if code in NO_DATAGRAM:
            return 0
        raise OSError(code, os.strerror(code))

    def skip(self, descriptor: int) -> int:
        """Discard waiting datagrams, as many as one call takes; return how many. Raises OSError."""
        self._messages["iov_length"] = 0
        try:
            return self.receive(descriptor, 0, self.count)
        finally:
            self._messages["iov_length"] = 2

    def runs(self, received: int, now: float) -> list[SlotRun]:
        """Divide the first `received` slots into runs. `now` in seconds of any clock."""
        if received <= FEW:
            return [self._single(slot, now) for slot in range(received)]
        kinds = self._lengths[:received].astype(np.int64)
        joined = self._control_lengths[:received] != 0
        if joined.any():
            kinds |= self._packet_lengths[:received].astype(np.int64) * joined << LENGTH_BITS
        foreign = self._sources[:received] != self._origin.key
        if foreign.any():
            if self._origin.learn(np.unique(self._sources[:received][foreign]).tolist(), now):
                foreign = self._sources[:received] != self._origin.key
            kinds[foreign] = FOREIGN
        if not foreign.all():
            self._origin.heard = True
        breaks = ((kinds[1:] != kinds[:-1]).nonzero()[0] + 1).tolist()
        found: list[SlotRun] = []
        for begin, end in zip([0, *breaks], [*breaks, received], strict=True):
            run = self._run_of(begin, end, int(kinds[begin]))
            if found and run.length == WHOLE and found[-1][2:] == run[2:]:
                found[-1] = found[-1]._replace(end=end)
            else:
                found.append(run)
        return found

    def _single(self, slot: int, now: float) -> SlotRun:
        """Return one slot as a run, without arrays."""
        length = self._lengths.item(slot)
        key = self._sources.item(slot)
        if key != self._origin.key and not self._origin.learn([key], now):
            return SlotRun(slot, slot + 1, FOREIGN, 0)
        self._origin.heard = True
        joined = self._packet_lengths.item(slot) if self._control_lengths.item(slot) else length
        return SlotRun(slot, slot + 1, length, joined)

    def _run_of(self, begin: int, end: int, kind: int) -> SlotRun:
        if kind == FOREIGN:
            return SlotRun(begin, end, FOREIGN, 0)
        length = kind & LENGTH_MASK
        packet_length = kind >> LENGTH_BITS or length
        whole = 0 < length <= self._pitch and length % packet_length == 0 == self._pitch % packet_length
        return SlotRun(begin, end, WHOLE if whole else length, packet_length)

    def rows(self, run: SlotRun) -> Rows | None:
        """Return the packets of a run without copying, if their distance is constant."""
        begin, end, length, packet_length = run
        slots = self._data[begin * self._pitch : end * self._pitch]
        if length == WHOLE:
            most = self._pitch // packet_length
            counts = self._lengths[begin:end] // packet_length
            full = bool((counts == most).all())
            at = None if full else (np.arange(most) < counts[:, np.newaxis]).ravel().nonzero()[0]
            return Rows(slots.reshape(-1, packet_length), at)
        if length == packet_length <= self._pitch:
            return Rows(slots.reshape(-1, self._pitch)[:, :length], None)
        return None

    def datagram(self, slot: int, length: int) -> NDArray[np.uint8]:
        """Return a slot's datagram in one piece."""
        begin = slot * self._pitch
        if length <= self._pitch:
            return self._data[begin : begin + length]
        rest = self._overflow[slot, : length - self._pitch]
        return np.concatenate([self._data[begin : begin + self._pitch], rest])

    def fit(self, received: int) -> int:
        """Adapt the slots to the datagrams' length: at once if these grow, later if they shrink.

        Returns the longest of the `received`. The slots' content is lost.
        """
        longest = int(self._lengths[:received].max() if received > 1 else self._lengths[0])
        if longest > self._pitch:
            self._divide(longest)
        elif longest == self._pitch:
            self._shorter = self._longest_shorter = 0
        else:
            self._shorter += received
            self._longest_shorter = max(self._longest_shorter, longest)
            if self._shorter > SHRINK_AFTER:
                self._divide(max(self._longest_shorter, SHORTEST_SLOT))
        return longest

    def _divide(self, pitch: int) -> None:
        """Make slots of `pitch` bytes."""
        self._pitch = pitch
        self.count = min(SLOTS, BATCH_BYTES // pitch)
        "Slots in use."
        self._shorter = self._longest_shorter = 0
        begins = np.arange(SLOTS, dtype=np.uint64) * np.uint64(pitch)
        self._iov["base"][:, 0] = self._data.ctypes.data + begins
        self._iov["length"][:, 0] = pitch


def addresses(array: NDArray[Any]) -> NDArray[np.uint64]:
    """Return the address of each row of an array."""
    steps = np.arange(len(array), dtype=np.uint64) * np.uint64(array.strides[0])
    rows: NDArray[np.uint64] = array.ctypes.data + steps
    return rows


def hand_over_joined(
    assembler: BlockAssembler, datagram: NDArray[np.uint8], packet_length: int, now: float
) -> None:
    """Give joined packets to the assembler, of which the last may be shorter than `packet_length`."""
    whole = len(datagram) - len(datagram) % packet_length if packet_length else 0
    if whole:
        assembler.receive_rows(datagram[:whole].reshape(-1, packet_length), now)
    if whole < len(datagram) or not whole:
        assembler.receive(datagram[whole:].data, now)
