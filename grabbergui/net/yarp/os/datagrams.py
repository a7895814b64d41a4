"""Messages cut into datagrams and joined again, as YARP does it over udp and mcast. No I/O."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Iterator, Sequence
from typing import Final

from grabbergui.core.errors import RemoteProtocolError
from grabbergui.net.yarp.os.bottle import (
    Buffer,
)
from grabbergui.net.yarp.os.events import Message
from grabbergui.net.yarp.os.framing import Receiver

_DATAGRAM_START: Final = struct.Struct("<Ii")
"""CRC-32 of the bytes that follow, and the counter."""

DATAGRAM_LIMIT: Final = 65499
"""Size of a datagram in bytes, as YARP sends them."""

_WAKE_UP: Final = -1
"""The counter of an empty datagram."""


def split_datagrams(message: Sequence[Buffer], limit: int = DATAGRAM_LIMIT) -> Iterator[list[Buffer]]:
    """Yield the datagrams of a message, each in pieces for a gathering write."""
    room = limit - _DATAGRAM_START.size
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
    return [_DATAGRAM_START.pack(crc, counter), *pieces]


class Reassembler:
    """Reassembles messages from datagrams. A damaged or missing datagram costs its message."""

    def __init__(self, allocate: Callable[[int], memoryview], limit: int) -> None:
        self._allocate = allocate
        self._limit = limit
        self._restart()

    def datagram(self, data: Buffer) -> Message | None:
        """Accept one datagram; return the message that it completes."""
        if len(data) < _DATAGRAM_START.size:
            return None
        crc, counter = _DATAGRAM_START.unpack_from(data)
        if counter == _WAKE_UP:
            return None
        body = memoryview(data)[_DATAGRAM_START.size :]
        if counter == 0 and self._next:
            self._restart()  # the rest of the last message was lost
        if counter != self._next or zlib.crc32(body) != crc:
            self._restart()
            return None
        self._next += 1
        try:
            message = next(self._receiver.feed(body), None)
        except RemoteProtocolError:
            self._restart()
            return None
        if message is not None:
            self._restart()
        return message

    def _restart(self) -> None:
        self._next = 0
        self._receiver = Receiver(allocate=self._allocate, limit=self._limit)
