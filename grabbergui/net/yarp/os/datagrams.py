"""Messages cut into UDP datagrams, each with a checksum and a counter that starts anew with each message."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Iterator, Sequence
from typing import Final

from grabbergui.core.errors import RemoteProtocolError
from grabbergui.net.yarp.os.bottle import Buffer
from grabbergui.net.yarp.os.carrier import Message
from grabbergui.net.yarp.os.receiver import Receiver

PREFIX: Final = struct.Struct("<Ii")
"""CRC-32 of what follows the prefix, and the counter."""

DATAGRAM_LIMIT: Final = 65499
_WAKE_UP: Final = -1


def split(message: Sequence[Buffer], limit: int = DATAGRAM_LIMIT) -> Iterator[list[Buffer]]:
    """Each datagram in pieces, for a gathering write."""
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


class Joiner:
    """Puts messages together again; a damaged or missing datagram costs its message."""

    def __init__(self, allocate: Callable[[int], memoryview], limit: int) -> None:
        self.damaged = 0
        "Messages lost to wrong checksums or gaps."
        self._allocate = allocate
        self._limit = limit
        self._start_anew()

    def datagram(self, data: Buffer) -> Message | None:
        """Take one datagram; gives the message that it completes."""
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
            self._start_anew()
        return message

    def _drop(self) -> None:
        if self._next or not self._receiver.idle:
            self.damaged += 1
        self._start_anew()

    def _start_anew(self) -> None:
        self._next = 0
        self._receiver = Receiver(allocate=self._allocate, limit=self._limit)
