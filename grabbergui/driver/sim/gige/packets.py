"""Frames as GVSP datagrams: a block's packets, sent with few system calls.

`sendmmsg` sends many packets at once, and the kernel splits larger sends into packets if it supports that.
A block's packets are described once, by arrays in the layout of the kernel's structures; headers and payload
are not copied. This needs 64-bit Linux; elsewhere each packet takes one `sendto`.
"""

from __future__ import annotations

import bisect
import ctypes
import errno
import os
import socket
import struct
import sys
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from grabbergui.core.component import ComponentKind, PayloadType
from grabbergui.driver.gige.gvcp import Status
from grabbergui.driver.gige.gvsp import (
    CHUNK_BIT,
    IP_UDP_BYTES,
    GendcPosition,
    Leader,
    PartPosition,
    PartType,
    PayloadKind,
    PayloadPart,
    Trailer,
    payload_stride,
)
from grabbergui.driver.gige.packet_header import FLAG_RESEND, PacketFormat, PacketHeader
from grabbergui.driver.sim.contents import FILE_NAME, Piece, pieces
from grabbergui.driver.sim.model import FramePlan

_KINDS = {
    PayloadType.IMAGE: PayloadKind.IMAGE,
    PayloadType.CHUNK: PayloadKind.CHUNK,
    PayloadType.RAW_DATA: PayloadKind.RAW,
    PayloadType.FILE: PayloadKind.FILE,
    PayloadType.JPEG: PayloadKind.JPEG,
    PayloadType.JPEG2000: PayloadKind.JPEG2000,
    PayloadType.H264: PayloadKind.H264,
    PayloadType.MULTI_PART: PayloadKind.MULTI_PART,
    PayloadType.GENDC: PayloadKind.GENDC,
}
_FORMATS = {
    PayloadType.H264: PacketFormat.H264,
    PayloadType.MULTI_PART: PacketFormat.MULTI_PART,
    PayloadType.GENDC: PacketFormat.GENDC,
}
_POSITION_BYTES = {
    PacketFormat.H264: 8,
    PacketFormat.MULTI_PART: PartPosition.SIZE,
    PacketFormat.GENDC: GendcPosition.FORMAT.size,
}
_PART_TYPES = {
    ComponentKind.RANGE: PartType.IMAGE_3D,
    ComponentKind.CONFIDENCE: PartType.CONFIDENCE,
}
_UDP_SEGMENT = 103
_MOST_SEGMENTS = 64
_MOST_BYTES = 65_000
"Largest segmented send in bytes, the limit of a UDP datagram."
_MESSAGES_A_CALL = 32
_IOVEC = np.dtype([("base", np.uint64), ("length", np.uint64)])
_MMSGHDR = np.dtype(
    {
        "names": ["name", "name_length", "vectors", "vector_count"],
        "formats": [np.uint64, np.uint32, np.uint64, np.uint64],
        "offsets": [0, 8, 16, 24],
        "itemsize": 64,
    }
)
"`struct mmsghdr` on 64-bit Linux; omitted fields stay zero."
SUPPORTED = sys.platform == "linux" and struct.calcsize("P") == 8


@dataclass
class FramePackets:
    """A frame cut into packets: 0 is the leader, 1 to n the payload, n + 1 the trailer."""

    plan: FramePlan
    payload: NDArray[np.uint8]
    "The frame's bytes."
    packet_size: int
    "As SCPS counts."
    extended: bool = False
    "64-bit block ids."
    height_in_trailer: bool = False
    "As a line-scan camera does, which knows the number of lines only at the end."
    sent: int = 0
    "Packets that were sent already, or lost on purpose; later ones cannot be sent again yet."

    @property
    def block_id(self) -> int:
        """The frame's id on the wire."""
        return self.plan.frame_id if self.extended else (self.plan.frame_id - 1) % 0xFFFF + 1

    @property
    def stride(self) -> int:
        """Payload bytes of a full packet."""
        return payload_stride(self.packet_size, extended=self.extended)

    @property
    def payload_packets(self) -> int:
        """Number of payload packets."""
        return len(self.starts)

    @property
    def trailer_id(self) -> int:
        """The last packet's id."""
        return self.payload_packets + 1

    @cached_property
    def headers(self) -> NDArray[np.uint8]:
        """Headers of the payload packets, (n, bytes), with the position of the data if the format has one."""
        first = PacketHeader(self._format, self.block_id, 1, extended=self.extended).encode()
        headers = np.tile(np.frombuffer(first, np.uint8), (self.payload_packets, 1))
        # The packet id is the last three bytes, or four of which 24 bits are always enough.
        ids = np.arange(1, self.payload_packets + 1, dtype=np.uint32)
        headers[:, -3] = ids >> 16
        headers[:, -2] = ids >> 8 & 0xFF
        headers[:, -1] = ids & 0xFF
        positions = self._positions()
        return np.concatenate((headers, positions), axis=1) if positions is not None else headers

    @cached_property
    def starts(self) -> NDArray[np.int64]:
        """Offset of each packet's data in the payload; a part of a multi-part block begins with a packet."""
        room = self.stride - _POSITION_BYTES.get(self._format, 0)
        return np.concatenate([np.arange(begin, end, room, dtype=np.int64) for begin, end in self._runs()])

    @cached_property
    def sizes(self) -> NDArray[np.int64]:
        """Payload bytes of each packet: full except for the last packet of a run."""
        room = self.stride - _POSITION_BYTES.get(self._format, 0)
        ends = np.concatenate([np.full(-(-(end - begin) // room), end) for begin, end in self._runs()])
        return np.minimum(ends - self.starts, room)

    def leader(self) -> bytes:
        """Return the leader's datagram."""
        settings, kind = self.plan.settings, self.plan.settings.payload_type
        body = Leader(self._payload_type, self.plan.timestamp_ns, size=len(self.payload))
        if kind is PayloadType.FILE:
            body = replace(body, file_name=FILE_NAME)
        elif kind is PayloadType.MULTI_PART:
            body = replace(body, parts=tuple(self._part(piece) for piece in self._pieces))
        elif kind is PayloadType.IMAGE:
            body = Leader(
                self._payload_type,
                self.plan.timestamp_ns,
                settings.pixel_format.code,
                settings.width,
                0 if self.height_in_trailer else settings.height,
                settings.offset_x,
                settings.offset_y,
            )
        header = PacketHeader(
            PacketFormat.LEADER, self.block_id, 0, extended=self.extended, parts=len(body.parts)
        )
        return header.encode() + body.encode()

    def trailer(self) -> bytes:
        """Return the trailer's datagram."""
        alone = self.plan.settings.payload_type is PayloadType.CHUNK
        size = len(self.payload) if alone or self._payload_type & CHUNK_BIT else None
        body = Trailer(self._payload_type, self.plan.settings.height, size)
        return self._header(PacketFormat.TRAILER, self.trailer_id) + body.encode()

    def packet(self, packet_id: int) -> bytes:
        """Return any packet's datagram, marked as resent."""
        if packet_id == 0:
            return self._marked(self.leader())
        if packet_id == self.trailer_id:
            return self._marked(self.trailer())
        start, size = int(self.starts[packet_id - 1]), int(self.sizes[packet_id - 1])
        header = self.headers[packet_id - 1].tobytes()
        return self._marked(header + self.payload[start : start + size].tobytes())

    @cached_property
    def _pieces(self) -> tuple[Piece, ...]:
        return pieces(self.plan.settings, tuple(self.plan.chunk_values))

    def _runs(self) -> list[tuple[int, int]]:
        """Return begin and end of each run, which is divided into full packets and a last one."""
        if self.plan.settings.payload_type is PayloadType.MULTI_PART:
            return [(piece.begin, piece.begin + piece.length) for piece in self._pieces]
        return [(0, len(self.payload))]

    def _positions(self) -> NDArray[np.uint8] | None:
        """Return the position of each packet's data, shape (n, 8 or 16)."""
        if self._format is PacketFormat.GENDC:
            last = self.payload_packets - 1
            rows = [
                GendcPosition(
                    int(size),
                    int(start),
                    GendcPosition.DESCRIPTOR if start == 0 else 0,
                    GendcPosition.FIRST * (index == 0) | GendcPosition.LAST * (index == last),
                ).encode()
                for index, (start, size) in enumerate(zip(self.starts, self.sizes, strict=True))
            ]
        elif self._format is PacketFormat.MULTI_PART:
            begins = [piece.begin for piece in self._pieces]
            ends = {piece.begin + piece.length for piece in self._pieces}
            rows = [
                PartPosition(
                    bisect.bisect_right(begins, start) - 1, int(start), int(start + size) in ends
                ).encode()
                for start, size in zip(self.starts, self.sizes, strict=True)
            ]
        elif self._format is PacketFormat.H264:
            rows = [self.plan.timestamp_ns.to_bytes(8, "big")] * self.payload_packets
        else:
            return None
        return np.frombuffer(b"".join(rows), np.uint8).reshape(len(rows), -1)

    def _part(self, piece: Piece) -> PayloadPart:
        settings = self.plan.settings
        shape = (settings.width, settings.height, settings.offset_x, settings.offset_y, 0, 0)
        if piece.kind is ComponentKind.METADATA:
            return PayloadPart(PartType.CHUNK, piece.length, 0, (0, 0, 0, 0, 0, 0))
        data_type = _PART_TYPES.get(piece.kind, PartType.IMAGE_2D)
        return PayloadPart(data_type, piece.length, piece.pixel_format.code, shape, purpose=piece.kind)

    @property
    def _format(self) -> PacketFormat:
        return _FORMATS.get(self.plan.settings.payload_type, PacketFormat.PAYLOAD)

    @property
    def _payload_type(self) -> int:
        kind = self.plan.settings.payload_type
        appended = kind in (PayloadType.IMAGE, PayloadType.JPEG, PayloadType.JPEG2000)
        return _KINDS[kind] | (CHUNK_BIT if appended and self.plan.chunk_values else 0)

    def _header(self, packet_format: PacketFormat, packet_id: int) -> bytes:
        return PacketHeader(packet_format, self.block_id, packet_id, extended=self.extended).encode()

    def _marked(self, datagram: bytes) -> bytes:
        marked = bytearray(datagram)
        marked[0:2] = int(Status.PACKET_RESEND).to_bytes(2, "big")
        if self.extended:
            marked[3] |= FLAG_RESEND
        return bytes(marked)


def unavailable(block_id: int, packet_id: int, extended: bool, status: Status) -> bytes:
    """Return the datagram that says that a packet cannot be sent again, or not yet."""
    return PacketHeader(PacketFormat.PAYLOAD, block_id, packet_id, status, extended).encode()


def test_packet(size: int) -> bytes:
    """Return a datagram for trying a packet size: block id 0, zeros to fill it up."""
    header = PacketHeader(PacketFormat.PAYLOAD, 0, 0).encode()
    return header.ljust(size - IP_UDP_BYTES, b"\0")


class DatagramBatch:
    """Sends packets of (header, data) to one destination from one socket."""

    def __init__(self, sender: socket.socket, to: tuple[str, int], *, segmentation: bool) -> None:
        self.destination = to
        self._socket = sender
        self._segment = 0
        self._segmentation = segmentation and SUPPORTED
        if SUPPORTED:
            self._libc = ctypes.CDLL(None, use_errno=True)
            family_port = struct.pack("=H", socket.AF_INET) + struct.pack(">H", to[1])
            self._name = np.frombuffer(family_port + socket.inet_aton(to[0]) + bytes(8), np.uint8).copy()

    def send(
        self,
        headers: NDArray[np.uint8],
        payload: NDArray[np.uint8],
        starts: NDArray[np.int64],
        sizes: NDArray[np.int64],
    ) -> None:
        """Send packet i as `headers[i]` and `sizes[i]` bytes of `payload` from `starts[i]` on.

        Waits while the socket's buffer is full. Packets that the network refuses are lost, as on any network.
        """
        if not SUPPORTED:
            self._send_singly(headers, payload, starts, sizes)
            return
        vectors = np.empty((len(sizes), 2), _IOVEC)
        vectors["base"][:, 0] = headers.ctypes.data + np.arange(len(sizes)) * headers.shape[1]
        vectors["length"][:, 0] = headers.shape[1]
        vectors["base"][:, 1] = payload.ctypes.data + starts
        vectors["length"][:, 1] = sizes
        segment = headers.shape[1] + int(sizes[0])
        # Only equal packets can be cut out of one send; the last of it may be shorter.
        uniform = self._segmentation and len(sizes) > 1 and bool((sizes[:-1] == sizes[0]).all())
        grouped = uniform and int(sizes[-1]) <= int(sizes[0]) and self._set_segment(segment)
        if not grouped:
            self._set_segment(0)
        group = min(_MOST_SEGMENTS, max(_MOST_BYTES // segment, 1)) if grouped else 1
        self._send_vectors(vectors, group)

    def _send_vectors(self, vectors: NDArray[np.void], group: int) -> None:
        first = np.arange(0, len(vectors), group)
        messages = np.zeros(len(first), _MMSGHDR)
        messages["name"] = self._name.ctypes.data
        messages["name_length"] = self._name.size
        messages["vectors"] = vectors.ctypes.data + first * (2 * _IOVEC.itemsize)
        messages["vector_count"] = 2 * np.minimum(group, len(vectors) - first)
        done = 0
        while done < len(messages):
            count = min(len(messages) - done, _MESSAGES_A_CALL)
            at = messages.ctypes.data + done * _MMSGHDR.itemsize
            sent = self._libc.sendmmsg(self._socket.fileno(), ctypes.c_void_p(at), count, 0)
            if sent > 0:
                done += sent
                continue
            code = ctypes.get_errno()
            if code in (errno.EINTR, errno.EAGAIN, errno.ENOBUFS):
                continue
            if group > 1 and code in (errno.EIO, errno.EINVAL, errno.EMSGSIZE):
                # This route cannot segment; from here on one packet a message.
                self._segmentation = False
                self._set_segment(0)
                self._send_vectors(vectors[done * group :], 1)
                return
            if code not in (errno.ECONNREFUSED, errno.EPERM, errno.EMSGSIZE):
                raise OSError(code, os.strerror(code))
            done += 1

    def _set_segment(self, size: int) -> bool:
        if size != self._segment:
            try:
                self._socket.setsockopt(socket.SOL_UDP, _UDP_SEGMENT, size)
            except OSError:
                self._segmentation = False
                return False
            self._segment = size
        return True

    def _send_singly(
        self,
        headers: NDArray[np.uint8],
        payload: NDArray[np.uint8],
        starts: NDArray[np.int64],
        sizes: NDArray[np.int64],
    ) -> None:
        for header, start, size in zip(headers, starts, sizes, strict=True):
            try:
                self._socket.sendto(
                    header.tobytes() + payload[start : start + size].tobytes(), self.destination
                )
            except OSError as error:
                if error.errno not in (errno.ECONNREFUSED, errno.EPERM, errno.ENOBUFS, errno.EMSGSIZE):
                    raise
