"""Messages over UDP: cut into datagrams, sent, received and reassembled.

Each datagram begins with a checksum and a counter, which starts at 0 for each message.
"""

from __future__ import annotations

import socket
import struct
import time
import zlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from typing import Final

from grabbergui.core.errors import RemoteProtocolError, TransportError
from grabbergui.net.yarp.os import sockets
from grabbergui.net.yarp.os.bottle import Buffer
from grabbergui.net.yarp.os.carrier import Message
from grabbergui.net.yarp.os.framing import Receiver

PREFIX: Final = struct.Struct("<Ii")
"""CRC-32 of the bytes after the prefix, and the counter."""

DATAGRAM_LIMIT: Final = 65499
"""Size of a datagram in bytes, as YARP sends them."""

_WAKE_UP: Final = -1
_POLL_SECONDS: Final = 0.5
_LONG_DATAGRAM: Final = 49_000
_GAP_SECONDS: Final = 0.001
"""Pause after a long datagram, as in YARP: a reader's kernel holds three of them by default, and a lost one
takes its whole image with it."""


def split(message: Sequence[Buffer], limit: int = DATAGRAM_LIMIT) -> Iterator[list[Buffer]]:
    """Yield each datagram in pieces, for a gathering write."""
    room = limit - PREFIX.size
    pieces: list[Buffer] = []
    used = counter = 0
    for part in message:
        view = memoryview(part)
        while len(view):
            piece, view = view[: room - used], view[room - used :]
            pieces.append(piece)
            used += len(piece)
            if used == room:
                yield _datagram(pieces, counter)
                pieces, used, counter = [], 0, counter + 1
    if pieces:
        yield _datagram(pieces, counter)


def _datagram(pieces: list[Buffer], counter: int) -> list[Buffer]:
    crc = 0
    for piece in pieces:
        crc = zlib.crc32(piece, crc)
    return [PREFIX.pack(crc, counter), *pieces]


class Reassembler:
    """Reassembles messages. A damaged or missing datagram costs its message."""

    def __init__(self, allocate: Callable[[int], memoryview], limit: int) -> None:
        self.damaged = 0
        "Messages lost to wrong checksums or missing datagrams."
        self._allocate = allocate
        self._limit = limit
        self._restart()

    def datagram(self, data: Buffer) -> Message | None:
        """Accept one datagram; return the message that it completes."""
        if len(data) < PREFIX.size:
            return None
        crc, counter = PREFIX.unpack_from(data)
        if counter == _WAKE_UP:
            return None
        body = memoryview(data)[PREFIX.size :]
        if counter == 0 and self._next:
            self._drop()  # the rest of the last message was lost
        if counter != self._next or zlib.crc32(body) != crc:
            self._drop()
            return None
        self._next += 1
        try:
            message = next(self._receiver.feed(body), None)
        except RemoteProtocolError:
            self._drop()
            return None
        if message is not None:
            self._restart()
        return message

    def _drop(self) -> None:
        if self._next or not self._receiver.idle:
            self.damaged += 1
        self._restart()

    def _restart(self) -> None:
        self._next = 0
        self._receiver = Receiver(allocate=self._allocate, limit=self._limit)


def send(sock: socket.socket, message: Sequence[Buffer]) -> None:
    """Send a message. Raises TransportError."""
    for datagram in split(message):
        if sockets.send(sock, datagram) > _LONG_DATAGRAM:
            time.sleep(_GAP_SECONDS)


def sending_socket(sock: socket.socket, port: int) -> socket.socket:
    """Close the TCP connection and return a UDP socket to `port` at its other end. Raises TransportError."""
    # The receiver knows us by the address and port that the TCP connection had.
    local, remote = sock.getsockname(), sock.getpeername()
    sock.close()
    if not 0 < port < 65536:
        raise TransportError(f"it offers UDP port {port}")
    datagrams = socket.socket(sock.family, socket.SOCK_DGRAM)
    try:
        datagrams.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        datagrams.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, sockets.BUFFER_BYTES)
        # A YARP built without ACE takes that very port for itself; on one machine we must use another.
        with suppress(OSError):
            datagrams.bind(local[:2])
        datagrams.connect((remote[0], port))
    except OSError as error:
        datagrams.close()
        raise TransportError(f"no UDP to {remote[0]}:{port}: {sockets.reason(error)}") from error
    return datagrams


def receiving_socket(sock: socket.socket) -> socket.socket:
    """Return a UDP socket at a free port of the address at which a TCP connection arrived."""
    datagrams = socket.socket(sock.family, socket.SOCK_DGRAM)
    try:
        datagrams.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, sockets.BUFFER_BYTES)
        datagrams.bind((sock.getsockname()[0], 0))
        sockets.set_deadline(datagrams, _POLL_SECONDS)
    except BaseException:
        datagrams.close()
        raise
    return datagrams


def receive(sock: socket.socket, sender: str, ended: Callable[[], bool]) -> Iterator[memoryview]:
    """Yield the datagrams from one address until `ended` is true; each is valid until the next."""
    buffer = memoryview(bytearray(65536))
    while not ended():
        try:
            size, address = sock.recvfrom_into(buffer)
        except (BlockingIOError, ConnectionError):
            continue
        # The port may differ: a YARP built without ACE does not send from that of its TCP connection.
        if address[0] == sender:
            yield buffer[:size]
