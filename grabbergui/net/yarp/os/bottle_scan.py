"""Finds where a Bottle ends in a stream.

Replies come without a length: the Bottle itself says how long it is, but only bit by bit. The scanner keeps
its place between arrivals, so that a long reply is not read again from its beginning each time.
"""

from __future__ import annotations

import struct

from grabbergui.core.errors import RemoteProtocolError
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
from grabbergui.net.yarp.os.values import MAX_DEPTH, MAX_ITEMS, Dialect

_SIZES = {INT8: 1, INT16: 2, INT32: 4, VOCAB: 4, FLOAT32_3: 4, INT64: 8, VOCAB64: 8, FLOAT64_4: 8}
_I32 = struct.Struct("<i")


class BottleScanner:
    """Follows one Bottle through a growing buffer."""

    def __init__(self, dialect: Dialect = Dialect.YARP3, limit: int = 1 << 28) -> None:
        self.offset = 0
        "How far the Bottle has been followed."
        self._sizes = {**_SIZES, FLOAT64_3: 8 if dialect is Dialect.YARP3 else 4}
        self._limit = limit
        self._items_left = MAX_ITEMS
        # What is still to come, innermost last: (items, their type code or 0 where each has its own).
        self._open: list[tuple[int, int]] = []
        self._begun = False

    def scan(self, data: Buffer) -> int:
        """How many bytes are needed at least, given those so far; no more once that many are there.

        `data` is all that arrived since the Bottle began. Raises RemoteProtocolError where it is none, or
        longer than the limit.
        """
        needed = self._scan(memoryview(data).cast("B"))
        if needed > self._limit:
            raise RemoteProtocolError(f"a Bottle of at least {needed} bytes, allowed are {self._limit}")
        return needed

    def _scan(self, data: memoryview) -> int:
        if not self._begun:
            if len(data) < 8:
                return 8
            self.offset = 4
            self._open_list(data, _I32.unpack_from(data)[0])
            self._begun = True
        while self._open:
            items, code = self._open[-1]
            if not items:
                self._open.pop()
                continue
            needed = self._step(data, items, code)
            if needed:
                return needed
        return self.offset

    def _step(self, data: memoryview, items: int, code: int) -> int:
        """Go past one item, or past all of a fixed size; else how many bytes that needs."""
        start = self.offset
        size = self._sizes.get(code)
        if size is not None:
            end = start + size * items
            if len(data) < end:
                return end
            self.offset = end
            self._open.pop()
            return 0
        own = 0 if code else 4
        if len(data) < start + own:
            return start + own
        kind = code or _I32.unpack_from(data, start)[0]
        at = start + own
        size = self._sizes.get(kind)
        if size is not None:
            end = at + size
        elif kind in (STRING, BLOB):
            if len(data) < at + 4:
                return at + 4
            length = _I32.unpack_from(data, at)[0]
            if length < 0:
                raise RemoteProtocolError(f"a Bottle has an item of {length} bytes")
            end = at + 4 + length
        else:
            return self._enter(data, kind, at, items)
        if len(data) < end:
            return end
        self.offset = end
        self._open[-1] = (items - 1, code)
        return 0

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
        """Enter a list whose count lies at `offset`."""
        if code & ~ELEMENT != LIST:
            raise RemoteProtocolError(f"a Bottle begins with type code {code}, must be 256 to 511")
        count = _I32.unpack_from(data, self.offset)[0]
        self._items_left -= max(count, 0)
        if count < 0 or self._items_left < 0:
            raise RemoteProtocolError(f"a Bottle claims {count} items, allowed are {MAX_ITEMS} in all")
        if len(self._open) > MAX_DEPTH:
            raise RemoteProtocolError(f"a Bottle's lists are nested deeper than {MAX_DEPTH}")
        self.offset += 4
        self._open.append((count, code & ELEMENT))
