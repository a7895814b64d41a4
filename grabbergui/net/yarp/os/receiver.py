"""The receiving end of a binary connection, as a machine without I/O."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from grabbergui.net.yarp.os.bottle import Buffer
from grabbergui.net.yarp.os.carrier import HEAD_LIMIT, MESSAGE_LIMIT, Message, decode_head


def _fresh(size: int) -> memoryview:
    return memoryview(bytearray(size))


class Receiver:
    """Cuts what follows the greeting into messages.

    The caller fills `wanted`, says so with `received`, and calls `take` until it gives None. A message
    costs two reads: one of whatever has come, which brings the head and the beginning of the body, one of
    the body's rest straight into the memory that `allocate` gave.
    """

    def __init__(
        self, *, allocate: Callable[[int], memoryview] = _fresh, limit: int = MESSAGE_LIMIT
    ) -> None:
        """`limit`: bytes of the longest message taken."""
        self._allocate = allocate
        self._limit = limit
        self._read = memoryview(bytearray(2 * HEAD_LIMIT))
        "What came outside of bodies; that between the next two is still to be looked at."
        self._begin = self._end = 0
        self._command = ""
        self._body: memoryview | None = None
        "Of the message that has begun; None between two messages and within a head."
        self._filled = 0

    @property
    def wanted(self) -> memoryview:
        """Where the next bytes go; as long as may be read, never empty."""
        return self._read[self._end :] if self._body is None else self._body[self._filled :]

    @property
    def in_body(self) -> bool:
        """Whether `wanted` is a body's rest, so that it is worth waiting until all of it is filled."""
        return self._body is not None

    @property
    def idle(self) -> bool:
        """Whether the stream stands between two messages."""
        return self._body is None and self._begin == self._end

    def received(self, count: int) -> None:
        """Note `count` bytes more in `wanted`."""
        if self._body is None:
            self._end += count
        else:
            self._filled += count

    def take(self) -> Message | None:
        """The next message, None while it is not complete. Raises RemoteProtocolError; nothing can follow."""
        if self._body is None:
            self._begin_body()
        body = self._body
        if body is None or self._filled < len(body):
            return None
        self._body = None
        return Message(self._command, body)

    def feed(self, data: Buffer) -> Iterator[Message]:
        """The messages that bytes read elsewhere complete. Raises as `take`."""
        rest = memoryview(data)
        while len(rest):
            wanted = self.wanted
            count = min(len(wanted), len(rest))
            wanted[:count] = rest[:count]
            rest = rest[count:]
            self.received(count)
            while (message := self.take()) is not None:
                yield message

    def _begin_body(self) -> None:
        unread = self._read[self._begin : self._end]
        head = decode_head(unread, self._limit)
        if head is None:
            # To the front, so that a whole head always finds room.
            self._read[: len(unread)] = unread
            self._begin, self._end = 0, len(unread)
            return
        start = unread[head.size : head.size + head.body_size]
        self._command = head.command
        self._body = self._allocate(head.body_size)
        self._body[: len(start)] = start
        self._filled = len(start)
        self._begin += head.size + len(start)
