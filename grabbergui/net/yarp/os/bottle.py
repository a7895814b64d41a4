"""Bottles: YARP's lists of typed values, in their binary form.

All integers are little endian. A Bottle is a code, a count and the items; code 256 alone means that every
item carries its own type code, 256 + code that all items are of that type and carry none. The text form is
in `bottle_text`.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable
from typing import Final, cast

from grabbergui.core.errors import LocalProtocolError, RemoteProtocolError
from grabbergui.net.yarp.os import bottle_text
from grabbergui.net.yarp.os.values import (
    FALSE,
    MAX_DEPTH,
    MAX_ITEMS,
    TRUE,
    Dialect,
    Float32,
    Int8,
    Int16,
    Int64,
    Item,
    Vocab,
    Vocab64,
)

Buffer = bytes | bytearray | memoryview

INT32, STRING, VOCAB, FLOAT64_3, BLOB, INT64, VOCAB64, FLOAT64_4 = 1, 4, 9, 10, 12, 17, 18, 20
INT8, INT16, FLOAT32_3 = 32, 64, 128
LIST, DICT, ELEMENT = 256, 512, 0xFF
FLOAT32_4 = 10

_HEAD = struct.Struct("<ii")
_I32 = struct.Struct("<i")

_FORMATS: Final = {
    Dialect.YARP3: {
        **{INT8: "b", INT16: "h", INT32: "i", INT64: "q", VOCAB: "i"},
        **{FLOAT64_3: "d", FLOAT64_4: "d", FLOAT32_3: "f", VOCAB64: "q"},
    },
    Dialect.YARP4: {
        **{INT8: "b", INT16: "h", INT32: "i", INT64: "q", VOCAB: "i"},
        **{FLOAT32_4: "f", FLOAT64_4: "d", FLOAT32_3: "f", VOCAB64: "q"},
    },
}
"""`struct` letters of the items of fixed size. The other dialect's code is read where it is not ambiguous."""

_CLASSES: Final[dict[int, type]] = {INT8: Int8, INT16: Int16, VOCAB: Vocab, VOCAB64: Vocab64}


class Bottle(list[Item]):
    """A list of typed values: ``Bottle([Vocab("fgc"), Vocab("get"), Vocab("feat"), 8])``."""

    def __init__(self, items: Iterable[Item] = (), *, specialised: bool | None = None) -> None:
        super().__init__(items)
        self.specialised = specialised
        """Whether a list of one type leaves out its items' codes; None leaves it to `encode`. Image
        headers always do, lists for YARP 4.0's thrift readers never."""
        self.dialect: Dialect | None = None
        "Which YARP wrote it, where a decoded Bottle's type codes tell."

    def encode(self, dialect: Dialect = Dialect.YARP3, *, specialise: bool = True) -> bytes:
        """The binary form. Raises LocalProtocolError for a value that has none."""
        return b"".join(self.encode_parts(dialect, specialise=specialise))

    def encode_parts(self, dialect: Dialect = Dialect.YARP3, *, specialise: bool = True) -> list[Buffer]:
        """The binary form in pieces, so that a large blob need not be copied."""
        code, body = _encode_list(self, dialect, specialise)
        return [_I32.pack(code), *body]

    @classmethod
    def decode(cls, message: Buffer, dialect: Dialect | None = None) -> Bottle:
        """Read a whole message.

        Without a `dialect` the one that uses up the message exactly is taken, 3.x first. Raises
        RemoteProtocolError, also where bytes are left over.
        """
        if dialect is not None:
            return cls._decode_all(message, dialect)
        try:
            return cls._decode_all(message, Dialect.YARP3)
        except RemoteProtocolError as error:
            try:
                return cls._decode_all(message, Dialect.YARP4)
            except RemoteProtocolError:
                raise error from None

    @classmethod
    def decode_from(
        cls, data: Buffer, offset: int = 0, dialect: Dialect = Dialect.YARP3
    ) -> tuple[Bottle, int]:
        """Read one Bottle that begins at `offset`; returns it and where it ends.

        In a stream, find the end first with `framing.BottleScanner`. Raises RemoteProtocolError.
        """
        reader = _Reader(memoryview(data).cast("B"), offset, dialect)
        bottle = cls(reader.whole())
        # What it was, so that it is written again as it came.
        bottle.specialised = bool(_I32.unpack_from(data, offset)[0] & ELEMENT)
        bottle.dialect = Dialect.YARP4 if dialect is Dialect.YARP4 or reader.codes_of_4 else None
        return bottle, reader.offset

    @classmethod
    def _decode_all(cls, message: Buffer, dialect: Dialect) -> Bottle:
        bottle, end = cls.decode_from(message, 0, dialect)
        if end != len(message):
            raise RemoteProtocolError(
                f"Bottle of {end} bytes in a message of {len(message)}, read as YARP {dialect.value}"
            )
        return bottle

    @classmethod
    def from_text(cls, text: str, dialect: Dialect = Dialect.YARP3) -> Bottle:
        """Read the text form, as typed into `yarp rpc`. Raises RemoteProtocolError."""
        return cls(bottle_text.parse(text, dialect, nested=Bottle))

    def to_text(self) -> str:
        """The text form, as `yarp read` prints it."""
        return bottle_text.render(self)

    def find(self, key: str) -> Item | None:
        """The value of ``(key value)`` or ``key value`` among the items, as YARP looks it up."""
        for index, item in enumerate(self):
            if isinstance(item, list) and len(item) > 1 and item[0] == key:
                return item[1]
            if isinstance(item, str) and item == key and index + 1 < len(self):
                return self[index + 1]
        return None

    def __repr__(self) -> str:
        return f"{type(self).__name__}({super().__repr__()})"


class Properties(Bottle):
    """A dictionary as YARP sends it: ``(key value)`` lists under a type code of its own."""


def _encode_list(items: list[Item], dialect: Dialect, specialise: bool) -> tuple[int, list[Buffer]]:
    """The list's own code, and its count and items."""
    own = getattr(items, "specialised", None)
    compact = specialise if own is None else own
    encoded = [_encode_item(item, dialect, specialise) for item in items]
    codes = {code for code, _ in encoded}
    common = next(iter(codes)) if len(codes) == 1 else 0
    body: list[Buffer] = [_I32.pack(len(encoded))]
    if compact and 0 < common < LIST:
        for _, parts in encoded:
            body += parts
        return LIST + common, body
    for code, parts in encoded:
        body.append(_I32.pack(code))
        body += parts
    return LIST, body


def _encode_item(item: Item, dialect: Dialect, specialise: bool) -> tuple[int, list[Buffer]]:
    if isinstance(item, Properties):
        code, body = _encode_list(item, dialect, specialise)
        return LIST + DICT, [_I32.pack(code), *body]
    if isinstance(item, (list, tuple)):
        return _encode_list(item, dialect, specialise)
    if isinstance(item, str):
        text = item.encode("utf-8", "surrogateescape")
        return STRING, [_I32.pack(len(text)), text]
    if isinstance(item, (bytes, bytearray, memoryview)):
        blob = memoryview(item).cast("B")
        return BLOB, [_I32.pack(len(blob)), blob]
    if isinstance(item, bool):
        return VOCAB, [_I32.pack(TRUE if item else FALSE)]
    if isinstance(item, (int, float)):
        code = _number_code(item, dialect)
        try:
            return code, [struct.pack("<" + _FORMATS[dialect][code], item)]
        except (struct.error, OverflowError) as error:
            raise LocalProtocolError(f"{item!r} does not fit a Bottle's {type(item).__name__}") from error
    raise LocalProtocolError(f"a {type(item).__name__} cannot go into a Bottle")


def _number_code(item: int | float, dialect: Dialect) -> int:
    if isinstance(item, float):
        if isinstance(item, Float32):
            return FLOAT32_3 if dialect is Dialect.YARP3 else FLOAT32_4
        return FLOAT64_3 if dialect is Dialect.YARP3 else FLOAT64_4
    for code, kind in _CLASSES.items():
        if isinstance(item, kind):
            if code == VOCAB64 and dialect is Dialect.YARP3:
                raise LocalProtocolError(f"vocab [{item}] has more than four letters, YARP 3.x has none such")
            return code
    return INT32 if not isinstance(item, Int64) and -(2**31) <= item < 2**31 else INT64


class _Reader:
    """Walks through one message; every read is checked against its end."""

    def __init__(self, data: memoryview, offset: int, dialect: Dialect) -> None:
        self.offset = offset
        self.codes_of_4 = False
        "Whether a type code came that YARP 3.x does not write."
        self._data = data
        self._formats = _FORMATS[dialect]
        self._items_left = MAX_ITEMS

    def whole(self, depth: int = 0) -> list[Item]:
        """A Bottle with its code."""
        code = self._int32()
        if not code & LIST or code & ~(LIST | ELEMENT):
            raise RemoteProtocolError(f"a Bottle begins with type code {code}, must be 256 to 511")
        return self._list(code & ELEMENT, depth)

    def _list(self, element: int, depth: int) -> list[Item]:
        count = self._int32()
        if depth > MAX_DEPTH:
            raise RemoteProtocolError(f"a Bottle's lists are nested deeper than {MAX_DEPTH}")
        left = len(self._data) - self.offset
        if not 0 <= count <= left:  # no item is smaller than a byte
            raise RemoteProtocolError(f"a Bottle claims {count} items, {left} bytes are left")
        self._items_left -= count
        if self._items_left < 0:
            raise RemoteProtocolError(f"a Bottle has more than {MAX_ITEMS} items")
        if element in self._formats:
            return self._fixed(element, count)
        return [self._item(element or self._int32(), depth) for _ in range(count)]

    def _item(self, code: int, depth: int) -> Item:
        if code in self._formats:
            return self._fixed(code, 1)[0]
        if code == STRING:
            return str(self._block("string"), "utf-8", "surrogateescape")
        if code == BLOB:
            return bytes(self._block("blob"))
        if code == LIST + DICT or code & ~ELEMENT == LIST + DICT:
            return Properties(self.whole(depth + 1))
        if code & ~ELEMENT == LIST:
            return Bottle(self._list(code & ELEMENT, depth + 1))
        raise RemoteProtocolError(f"a Bottle has an item of unknown type code {code}")

    def _fixed(self, code: int, count: int) -> list[Item]:
        self.codes_of_4 |= code in (FLOAT64_4, VOCAB64)
        layout = struct.Struct(f"<{count}{self._formats[code]}")
        start = self._take(layout.size, f"{count} items of type code {code}")
        values = layout.unpack_from(self._data, start)
        if self._formats[code] == "f":
            return [Float32(value) for value in values]
        if code == INT64:
            return [Int64(value) if -(2**31) <= value < 2**31 else value for value in values]
        kind = _CLASSES.get(code)
        return cast(list[Item], [kind(value) for value in values] if kind else list(values))

    def _block(self, what: str) -> memoryview:
        length = self._int32()
        if length < 0:
            raise RemoteProtocolError(f"a Bottle has a {what} of {length} bytes")
        start = self._take(length, f"a {what} of {length} bytes")
        return self._data[start : start + length]

    def _int32(self) -> int:
        return cast(int, _I32.unpack_from(self._data, self._take(4, "an int32"))[0])

    def _take(self, size: int, what: str) -> int:
        start, self.offset = self.offset, self.offset + size
        if self.offset > len(self._data):
            raise RemoteProtocolError(f"a Bottle ends at byte {len(self._data)} within {what}")
        return start
