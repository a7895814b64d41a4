"""Sends many datagrams with few system calls.

`sendmmsg` sends many packets at once, and the kernel splits larger sends into packets if it supports that.
A block's packets are described once, by arrays in the layout of the kernel's structures; headers and payload
are not copied. This needs 64-bit Linux; elsewhere each packet takes one `sendto`.
"""

from __future__ import annotations

import ctypes
import errno
import os
import socket
import struct
import sys

import numpy as np
from numpy.typing import NDArray

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
