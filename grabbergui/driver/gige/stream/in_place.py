"""Joined packets, written by the kernel straight to their places in a frame's buffer. Linux.

Where the kernel joins packets (UDP_GRO), one `recvmsg` brings up to 64 KB. It takes a list of buffers, which
separates each packet's header from its data: headers go to an array, the data of consecutive packets to
consecutive places in the frame, without a second copy.

Which packets arrive is known only afterwards. So they are received into the places of those that are
expected next. If others have arrived, they are copied out of there and handed over like any packets. Nothing
is lost by that, as those places were still empty.
"""

from __future__ import annotations

import ctypes
import os
import struct
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grabbergui.driver.gige.packet_header import EXTENDED, STANDARD, PacketFormat, offset_of
from grabbergui.driver.gige.stream.assembler import BlockAssembler
from grabbergui.driver.gige.stream.block import Places
from grabbergui.driver.gige.stream.packet_origin import PacketOrigin
from grabbergui.driver.gige.stream.recvmmsg import (
    CONTROL,
    DONT_WAIT,
    IOVEC,
    MMSGHDR,
    NO_DATAGRAM,
    SOCKADDR_BYTES,
    addresses,
    hand_over_joined,
)

MOST_MESSAGES = 256
"Calls before timers and finished frames have their turn; datagrams of strangers count, too."
LONGEST_MESSAGE = 65535
MOST_PACKETS = 512
"Packets of a message, at most: the kernel takes 1024 vectors. GRO joins 64, but local senders more."
PLACE_VECTORS = 2 * IOVEC.itemsize
"Bytes of the vectors of one place: header and data."
HEADER_END = struct.Struct(">I")
"The packet id; in a standard header its first byte is the format."
ID_AT = {
    STANDARD.itemsize: offset_of(STANDARD, "format_and_packet_id"),
    EXTENDED.itemsize: offset_of(EXTENDED, "packet_id"),
}
"Byte of a header of that size at which it begins."


class PlacedDatagram(NamedTuple):
    """A datagram that was received into the places from index `at` on."""

    at: int
    length: int
    packet_length: int
    "Bytes of each packet in it, but the last, which may be shorter."


class Received(NamedTuple):
    """What one read brought."""

    bytes: int
    messages: int
    in_order: bool
    "Whether all full packets were the expected ones."
    emptied: bool
    "Whether nothing more waits at the socket."


class InPlaceReader:
    """Receives the packets of a block in progress. One thread."""

    def __init__(self, origin: PacketOrigin) -> None:
        self._origin = origin
        # Unlike CDLL, PyDLL keeps the GIL: the call never waits, and is shorter than a change of threads.
        self._call = ctypes.PyDLL(None, use_errno=True).recvmsg
        self._call.restype = ctypes.c_ssize_t
        self._name = np.zeros(SOCKADDR_BYTES, np.uint8)
        self._control = np.zeros(1, CONTROL)
        self._message = np.zeros(1, MMSGHDR)
        self._message["name"] = self._name.ctypes.data
        self._message["name_length"] = SOCKADDR_BYTES
        self._message["control"] = self._control.ctypes.data
        # ctypes sets and reads single numbers several times faster than numpy.
        self._source = ctypes.c_uint64.from_address(self._name.ctypes.data)
        self._vectors_at = ctypes.c_uint64.from_address(_field(self._message, "iov"))
        self._control_length = ctypes.c_uint64.from_address(_field(self._message, "control_length"))
        self._packet_length = ctypes.c_int32.from_address(_field(self._control, "packet_length"))
        self._shape = (0, 0, 0)
        self._begin = 0
        "Address of the places that the vectors point to."
        self._offsets = np.zeros(0, np.uint64)
        self._headers = self._spill = np.zeros((0, 0), np.uint8)
        self._vectors = np.zeros((0, 2), IOVEC)

    def receive(self, descriptor: int, places: Places, assembler: BlockAssembler, now: float) -> Received:
        """Take waiting packets up to the end of the places, for the assembler. Raises OSError."""
        self._point_at(places)
        begin, pitch = places.first - 1, places.packet_length
        ends, unexpected, foreign, emptied = self._read(descriptor, places)
        if foreign:
            assembler.ignore(foreign)
        full = ends[-1] - begin
        if unexpected is not None and unexpected.packet_length == pitch:
            full += unexpected.length // pitch
        full = min(full, len(places.lines) - begin)
        headers = self._headers[begin : begin + full]
        placed = assembler.receive_in_place(headers, places, now) if full else 0
        if unexpected is not None or begin + placed < ends[-1]:
            messages = [PlacedDatagram(at, (end - at) * pitch, pitch) for at, end in pairwise(ends)]
            messages += [unexpected] if unexpected is not None else []
            self._hand_over_from(begin + placed, messages, places, assembler, now)
        count, total = len(ends) - 1, (ends[-1] - begin) * pitch
        if unexpected is not None:
            count, total = count + 1, total + unexpected.length
        return Received(total, count, placed == total // pitch, emptied)

    def _hand_over_from(
        self, end: int, messages: list[PlacedDatagram], places: Places, assembler: BlockAssembler, now: float
    ) -> None:
        """Hand over what lies in the places from index `end` on, which are not its own."""
        displaced = [rest for message in messages if (rest := _behind(message, end, places.packet_length))]
        # All are copied before the first is handed over, which may overwrite the others.
        datagrams = [self._datagram(message, places) for message in displaced]
        for message, datagram in zip(displaced, datagrams, strict=True):
            hand_over_joined(assembler, datagram, message.packet_length, now)

    def _read(self, descriptor: int, places: Places) -> tuple[list[int], PlacedDatagram | None, int, bool]:
        """Read until an unexpected message arrives, the places are full, or nothing waits.

        Return the index of the first place and that behind each expected message, the unexpected one if there
        was one, how many datagrams were from strangers, and whether nothing waits.
        """
        call, message = self._call, ctypes.c_void_p(self._message.ctypes.data)
        vectors_at, vectors = self._vectors_at, self._vectors.ctypes.data
        control_length, packet_length = self._control_length, self._packet_length
        source, device = self._source, self._origin.key
        pitch, at, end = places.packet_length, places.first - 1, len(places.lines)
        headers, size = self._headers.data, self._headers.shape[1]
        id_at = ID_AT[size]
        # The last word of the header of the first place.
        ending = (PacketFormat.PAYLOAD << 24 if size == STANDARD.itemsize else 0) + 1
        ends = [at]
        foreign = 0
        for _ in range(MOST_MESSAGES):
            vectors_at.value = vectors + at * PLACE_VECTORS
            control_length.value = CONTROL.itemsize
            length = call(descriptor, message, DONT_WAIT)
            if length < 0:
                code = ctypes.get_errno()
                if code not in NO_DATAGRAM:
                    raise OSError(code, os.strerror(code))
                return ends, None, foreign, True
            if source.value != device:
                foreign += 1
                continue
            joined = packet_length.value if control_length.value else length
            (found,) = HEADER_END.unpack_from(headers, at * size + id_at)
            if joined != pitch or length % pitch or found != ending + at:
                return ends, PlacedDatagram(at, length, joined), foreign, False
            at += length // pitch
            ends.append(at)
            if at >= end:
                break
        return ends, None, foreign, False

    def _datagram(self, message: PlacedDatagram, places: Places) -> NDArray[np.uint8]:
        """Return a copy of a message, collected from its places."""
        begin = message.at
        count = -(-message.length // places.packet_length)
        packets = np.empty((count, places.packet_length), np.uint8)
        size = self._headers.shape[1]
        packets[:, :size] = self._headers[begin : begin + count]
        lines = places.lines[begin : begin + count]
        packets[: len(lines), size:] = lines
        behind = max(begin - len(places.lines), 0)
        packets[len(lines) :, size:] = self._spill[behind : behind + count - len(lines)]
        return packets.ravel()[: message.length]

    def _point_at(self, places: Places) -> None:
        """Let the vectors point to a block's places; the vectors behind them point to spare memory."""
        count, stride = places.lines.shape
        if (count, stride, places.packet_length) != self._shape:
            self._divide(count, stride, places.packet_length)
        begin = places.lines.ctypes.data
        if begin != self._begin:
            self._begin = begin
            self._vectors["base"][:count, 1] = begin + self._offsets

    def _divide(self, count: int, stride: int, packet_length: int) -> None:
        most = min(MOST_PACKETS, LONGEST_MESSAGE // packet_length + 1)
        self._shape = count, stride, packet_length
        self._begin = 0
        self._offsets = np.arange(count, dtype=np.uint64) * np.uint64(stride)
        self._headers = np.zeros((count + most, packet_length - stride), np.uint8)
        self._spill = np.zeros((most, stride), np.uint8)
        self._vectors = np.zeros((count + most, 2), IOVEC)
        self._vectors["base"][:, 0] = addresses(self._headers)
        self._vectors["base"][count:, 1] = addresses(self._spill)
        self._vectors["length"] = packet_length - stride, stride
        self._message["iov_length"] = 2 * most


def _behind(message: PlacedDatagram, end: int, packet_length: int) -> PlacedDatagram | None:
    """Return the part of a message whose places are behind `end`, if any."""
    skipped = max(end - message.at, 0) * packet_length
    if skipped >= message.length > 0:
        return None
    return message._replace(at=message.at + skipped // packet_length, length=message.length - skipped)


def _field(record: NDArray[Any], name: str) -> int:
    """Return the address of a field of a single record."""
    address: int = record[name].ctypes.data
    return address
