"""Find where messages, lines and Bottles end in a stream of bytes, and cut messages into datagrams. No I/O.

Messages carry their length, lines their end. A Bottle in a reply shows its length only as it is scanned; one
in text mode continues while brackets are open. Each class keeps its position, so that nothing is read twice.
Over udp each datagram begins with a checksum and a counter, which starts at 0 for each message.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator
from typing import Final

from grabbergui.core.errors import RemoteProtocolError
from grabbergui.net.yarp.os.binary import INDEX_LIMIT, MESSAGE_LIMIT, decode_index
from grabbergui.net.yarp.os.bottle import (
    BLOB,
    DICT,
    ELEMENT,
    FLOAT32_3,
    FLOAT64_3,
    FLOAT64_4,
    INT8,
    INT16,
    INT32,
    INT64,
    LIST,
    STRING,
    VOCAB,
    VOCAB64,
    Buffer,
)
from grabbergui.net.yarp.os.bottle_text import Nesting
from grabbergui.net.yarp.os.events import Message
from grabbergui.net.yarp.os.values import MAX_DEPTH, MAX_ITEMS, Dialect

LINE_LIMIT: Final = 1 << 16
"""Size of a line, and of a Bottle over several lines, in bytes: the most that is parsed at once."""

CONTINUED_LINES: Final = 100
"""Lines of one Bottle."""

_COMMON_SIZES: Final = {
    **{INT8: 1, INT16: 2, INT32: 4, VOCAB: 4, FLOAT32_3: 4, INT64: 8, VOCAB64: 8, FLOAT64_4: 8}
}
_SIZES: Final = {
    Dialect.YARP3: {**_COMMON_SIZES, FLOAT64_3: 8},
    Dialect.YARP4: {**_COMMON_SIZES, FLOAT64_3: 4},
}
_I32: Final = struct.Struct("<i")


def new_memory(size: int) -> memoryview:
    """Return `size` zeroed bytes."""
    return memoryview(bytearray(size))


class Receiver:
    """Cuts the bytes after the header into messages.

    The caller fills `wanted`, reports it to `received`, and calls `take` until that returns None. A message
    costs two reads: one of what has arrived, with the index and the start of the body, and one of the rest of
    the body, straight into the memory that `allocate` returned.
    """

    def __init__(
        self, *, allocate: Callable[[int], memoryview] = new_memory, limit: int = MESSAGE_LIMIT
    ) -> None:
        """`limit` is the size of the longest message accepted, in bytes."""
        self._allocate = allocate
        self._limit = limit
        self._read = memoryview(bytearray(2 * INDEX_LIMIT))
        "Bytes outside of bodies; those from `_begin` to `_end` are still to be decoded."
        self._begin = self._end = 0
        self._command = ""
        self._body: memoryview | None = None
        "Body of the message in progress; None between two messages and within an index."
        self._filled = 0

    @property
    def wanted(self) -> memoryview:
        """Memory for the next bytes, as long as may be read. Never empty."""
        return self._read[self._end :] if self._body is None else self._body[self._filled :]

    @property
    def in_body(self) -> bool:
        """Whether `wanted` is the rest of a body, so that it pays to wait until all of it is filled."""
        return self._body is not None

    @property
    def idle(self) -> bool:
        """Whether the stream is between two messages."""
        return self._body is None and self._begin == self._end

    def received(self, count: int) -> None:
        """Accept `count` more bytes in `wanted`."""
        if self._body is None:
            self._end += count
        else:
            self._filled += count

    def take(self) -> Message | None:
        """Return the next message, None while it is incomplete. RemoteProtocolError is final."""
        if self._body is None:
            if self._begin == self._end:
                self._begin = self._end = 0
                return None
            self._begin_body()
        body = self._body
        if body is None or self._filled < len(body):
            return None
        self._body = None
        return Message(self._command, body)

    def copy(self, data: Buffer) -> int:
        """Copy bytes that were read elsewhere into `wanted`; return how many fitted."""
        wanted = self.wanted
        count = min(len(wanted), len(data))
        wanted[:count] = data[:count]
        self.received(count)
        return count

    def feed(self, data: Buffer) -> Iterator[Message]:
        """Yield the messages that bytes read elsewhere complete. Raises as `take`."""
        rest = memoryview(data)
        while len(rest):
            rest = rest[self.copy(rest) :]
            while (message := self.take()) is not None:
                yield message

    def release(self) -> bytes:
        """Remove and return the bytes that belong to no message."""
        unread = bytes(self._read[self._begin : self._end])
        self._begin = self._end = 0
        return unread

    def _begin_body(self) -> None:
        unread = self._read[self._begin : self._end]
        index = decode_index(unread, self._limit)
        if index is None:
            # Move it to the front, so that there is always room for a whole index.
            self._read[: len(unread)] = unread
            self._begin, self._end = 0, len(unread)
            return
        start = unread[index.size : index.size + index.body_size]
        self._command = index.command
        self._body = self._allocate(index.body_size)
        self._body[: len(start)] = start
        self._filled = len(start)
        self._begin += index.size + len(start)


class LineReader:
    """Takes lines from a buffer, whether they end in CR LF or LF."""

    def __init__(self, limit: int = LINE_LIMIT) -> None:
        self._searched = 0
        self._limit = limit

    def take(self, data: bytearray) -> str | None:
        """Remove and return the next line without its end; None while it is incomplete.

        Raises RemoteProtocolError for a line that is longer than the limit.
        """
        end = data.find(b"\n", self._searched)
        self._searched = len(data)
        if (len(data) if end < 0 else end) > self._limit:
            raise RemoteProtocolError(f"line of more than {self._limit} bytes")
        if end < 0:
            return None
        line = bytes(data[:end]).rstrip(b"\r")
        del data[: end + 1]
        self._searched = 0
        return line.decode("utf-8", "surrogateescape")


class TextBottle:
    """Joins a Bottle's lines, which continue after a backslash and while brackets or quotes are open."""

    def __init__(self) -> None:
        self._nesting = Nesting()
        self._text = ""
        self._size = self._lines = 0

    def add(self, line: str) -> str | None:
        """Add a line; return the text once it is complete. Raises RemoteProtocolError if it has no end."""
        self._size += len(line)
        self._lines += 1
        if self._size <= LINE_LIMIT:
            continued = line.endswith("\\")
            line = line[:-1] if continued else line
            self._nesting.feed(line)
            self._text += line
            if not continued and not self._nesting.open:
                return self._text
            self._text += "" if continued else "\n"
        if self._size > LINE_LIMIT or self._lines >= CONTINUED_LINES:
            raise RemoteProtocolError("text of a Bottle without an end")
        return None


class BottleScanner:
    """Finds the end of one Bottle in a growing buffer."""

    def __init__(self, dialect: Dialect = Dialect.YARP3, limit: int = 1 << 28) -> None:
        self.offset = 0
        "Bytes of the Bottle that were scanned."
        self._sizes = _SIZES[dialect]
        self._limit = limit
        self._items_left = MAX_ITEMS
        # Open lists, innermost last: (items, their type code or 0 where each has its own).
        self._open: list[tuple[int, int]] = []
        self._begun = False

    def scan(self, data: Buffer) -> int:
        """Return how many bytes the Bottle has at least; its size once `data` is that long.

        `data` is all that arrived since the Bottle began. Raises RemoteProtocolError for anything else, and
        for a Bottle longer than the limit.
        """
        needed = self._scan(memoryview(data).cast("B"))
        if needed > self._limit:
            raise RemoteProtocolError(f"a Bottle of at least {needed} bytes, at most {self._limit}")
        return needed

    def _scan(self, data: memoryview) -> int:
        if not self._begun:
            if len(data) < 8:
                return 8
            self.offset = 4
            self._open_list(data, _I32.unpack_from(data)[0])
            self._begun = True
        while self._open:
            if needed := self._skip_items(data):
                return needed
        return self.offset

    def _skip_items(self, data: memoryview) -> int:
        """Skip items of the innermost list up to its end or to a list in it.

        Return 0, or how many bytes the next item needs.
        """
        items, code = self._open[-1]
        offset, size, available = self.offset, self._sizes.get(code), len(data)
        if size is not None:
            end = offset + size * items
            if end > available:
                return end
            self.offset, items = end, 0
        own = 0 if code else 4
        while items:
            end = at = offset + own
            if end > available:
                break
            kind = code or _I32.unpack_from(data, offset)[0]
            if kind in (STRING, BLOB):
                end += 4
                if end > available:
                    break
                length = _I32.unpack_from(data, at)[0]
                if length < 0:
                    raise RemoteProtocolError(f"a Bottle has an item of {length} bytes")
                end += length
            elif (size := self._sizes.get(kind)) is not None:
                end += size
            else:
                self._open[-1] = (items, code)
                return self._enter(data, kind, at, items)
            if end > available:
                break
            self.offset = offset = end
            items -= 1
        else:
            self._open.pop()
            return 0
        self._open[-1] = (items, code)
        return end

    def _enter(self, data: memoryview, kind: int, at: int, items: int) -> int:
        dictionary = kind & ~ELEMENT == LIST + DICT
        if not dictionary and kind & ~ELEMENT != LIST:
            raise RemoteProtocolError(f"a Bottle has an item of unknown type code {kind}")
        end = at + (8 if dictionary else 4)
        if len(data) < end:
            return end
        self._open[-1] = (items - 1, self._open[-1][1])
        if dictionary:
            kind = _I32.unpack_from(data, at)[0]
        self.offset = end - 4
        self._open_list(data, kind)
        return 0

    def _open_list(self, data: memoryview, code: int) -> None:
        """Enter a list whose count is at `offset`."""
        if code & ~ELEMENT != LIST:
            raise RemoteProtocolError(f"a Bottle begins with type code {code}, must be 256 to 511")
        count = _I32.unpack_from(data, self.offset)[0]
        self._items_left -= max(count, 0)
        if count < 0 or self._items_left < 0:
            raise RemoteProtocolError(f"a Bottle claims {count} items, at most {MAX_ITEMS} in all")
        if len(self._open) > MAX_DEPTH:
            raise RemoteProtocolError(f"a Bottle's lists are nested deeper than {MAX_DEPTH}")
        self.offset += 4
        self._open.append((count, code & ELEMENT))
