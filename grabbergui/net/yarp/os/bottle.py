"""Bottles: YARP's lists of typed values, in their binary form.

All integers are little endian. A Bottle is a code, a count and the items; code 256 alone means that every
item carries its own type code, 256 + code that all items are of that type and carry none. The text form is
in `values`.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Sequence
from typing import Final, cast

from grabbergui.core.errors import LocalProtocolError, RemoteProtocolError
from grabbergui.net.yarp.os.bottle_text import parse_text, render_text
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

_LAYOUTS: Final = {
    dialect: {code: struct.Struct("<" + letter) for code, letter in formats.items()}
    for dialect, formats in _FORMATS.items()
}

_CLASSES: Final[dict[int, type]] = {INT8: Int8, INT16: Int16, VOCAB: Vocab, VOCAB64: Vocab64}
"""Classes of decoded integers that are not plain numbers."""

_SMALL: Final = 4096
"""Bytes of a blob that is copied into the message around it."""


class Bottle(list[Item]):
    """A list of typed values: ``Bottle([Vocab("fgc"), Vocab("get"), Vocab("feat"), 8])``."""

    def __init__(self, items: Iterable[Item] = (), *, specialised: bool | None = None) -> None:
        super().__init__(items)
        self.specialised = specialised
        """Whether a list of one type leaves out its items' codes; None leaves it to `encode`. Image
        headers always do, lists for YARP 4.0's thrift readers never."""
        self.dialect: Dialect | None = None
        "The YARP that wrote it, if the type codes of a decoded Bottle show it."

    def encode(self, dialect: Dialect = Dialect.YARP3, *, specialise: bool = True) -> bytes:
        """Return the binary form. Raises LocalProtocolError for a value that has none."""
        return b"".join(self.encode_parts(dialect, specialise=specialise))

    def encode_parts(self, dialect: Dialect = Dialect.YARP3, *, specialise: bool = True) -> list[Buffer]:
        """Return the binary form in pieces, so that a large blob need not be copied."""
        writer = _BottleWriter(dialect, specialise)
        writer.bottle(self)
        return writer.pieces()

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
        reader = _BottleReader(memoryview(data).cast("B"), offset, dialect)
        bottle = cls(reader.whole())
        # Remember the encoding, so that the Bottle is written as it was received.
        bottle.specialised = reader.specialised
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
        return cls(parse_text(text, dialect, nested=Bottle))

    def to_text(self) -> str:
        """Return the text form, as `yarp read` prints it."""
        return render_text(self)

    def find(self, key: str) -> Item | None:
        """Return the value of ``(key value)`` or ``key value`` among the items, as YARP looks it up."""
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


_COMMON_CODES: Final[dict[type, int]] = {
    **{Properties: LIST + DICT, Bottle: LIST, list: LIST, tuple: LIST, str: STRING},
    **{bytes: BLOB, bytearray: BLOB, memoryview: BLOB},
    **{Int8: INT8, Int16: INT16, Int64: INT64, Vocab: VOCAB},
}
_CODES: Final[dict[Dialect, dict[type, int]]] = {
    Dialect.YARP3: {**_COMMON_CODES, Float32: FLOAT32_3, float: FLOAT64_3},
    Dialect.YARP4: {**_COMMON_CODES, Float32: FLOAT32_4, float: FLOAT64_4, Vocab64: VOCAB64},
}
"""By class, subclasses first. That of an int depends on its value."""


class _BottleWriter:
    """Appends values to a message; a large blob becomes a piece of its own, which is not copied."""

    def __init__(self, dialect: Dialect, specialise: bool) -> None:
        self._dialect = dialect
        self._codes = _CODES[dialect]
        self._layouts = _LAYOUTS[dialect]
        self._specialise = specialise
        self._pieces: list[Buffer] = []
        self._small = bytearray()

    def pieces(self) -> list[Buffer]:
        """Return the message."""
        return [*self._pieces, self._small] if self._small else self._pieces

    def bottle(self, items: Sequence[Item]) -> None:
        """Append a list with its type code."""
        own = getattr(items, "specialised", None)
        codes = [self._codes.get(type(item)) or self._code(item) for item in items]
        common = codes[0] if codes and len(set(codes)) == 1 else 0
        if (self._specialise if own is None else own) and 0 < common < LIST:
            self._small += _HEAD.pack(LIST + common, len(codes))
            for item in items:
                self._value(common, item)
            return
        self._small += _HEAD.pack(LIST, len(codes))
        for code, item in zip(codes, items):  # noqa: B905 - `strict` costs time, and the lengths are the same
            if code == STRING:  # most items are
                text = cast(str, item).encode("utf-8", "surrogateescape")
                self._small += _HEAD.pack(STRING, len(text)) + text
                continue
            if code != LIST:  # a list writes its code, which depends on its items
                self._small += _I32.pack(code)
            self._value(code, item)

    def _code(self, item: Item) -> int:
        """Return the type code of an item whose class alone does not decide about it."""
        if type(item) is int:
            return INT32 if -(2**31) <= item < 2**31 else INT64
        if isinstance(item, bool):
            return VOCAB
        for kind, code in self._codes.items():
            if isinstance(item, kind):
                return code
        if isinstance(item, int) and not isinstance(item, Vocab64):
            return INT32 if -(2**31) <= item < 2**31 else INT64
        if isinstance(item, Vocab64):
            raise LocalProtocolError(f"vocab [{item}] has more than four letters, YARP 3.x has none such")
        raise LocalProtocolError(f"a {type(item).__name__} cannot go into a Bottle")

    def _value(self, code: int, item: Item) -> None:
        if code == STRING:
            text = cast(str, item).encode("utf-8", "surrogateescape")
            self._small += _I32.pack(len(text)) + text
        elif code == LIST:
            self.bottle(cast(Sequence[Item], item))
        elif code == LIST + DICT:
            self.bottle(cast(Properties, item))
        elif code == BLOB:
            self._blob(memoryview(cast(Buffer, item)).cast("B"))
        else:
            if isinstance(item, bool):
                item = TRUE if item else FALSE
            try:
                self._small += self._layouts[code].pack(item)
            except (struct.error, OverflowError) as error:
                raise LocalProtocolError(f"{item!r} does not fit a Bottle's {type(item).__name__}") from error

    def _blob(self, blob: memoryview) -> None:
        self._small += _I32.pack(len(blob))
        if len(blob) <= _SMALL:
            self._small += blob
        else:
            self._pieces += (self._small, blob)
            self._small = bytearray()


class _BottleReader:
    """Decodes one message; every read is checked against its end."""

    def __init__(self, data: memoryview, offset: int, dialect: Dialect) -> None:
        self.offset = offset
        self.specialised = False
        "Whether the message is a list of one type, without the items' type codes."
        self.codes_of_4 = False
        "True after a type code that YARP 3.x does not write."
        # Bytes are sliced faster than a memoryview, but a large message is not copied for that.
        self._data: Buffer = bytes(data) if len(data) <= _SMALL else data
        self._dialect = dialect
        self._layouts = _LAYOUTS[dialect]
        self._items_left = MAX_ITEMS

    def whole(self, depth: int = 0) -> list[Item]:
        """Return the items of a list that begins with its type code."""
        code = self._int32()
        if not code & LIST or code & ~(LIST | ELEMENT):
            raise RemoteProtocolError(f"a Bottle begins with type code {code}, must be 256 to 511")
        self.specialised = bool(code & ELEMENT) if not depth else self.specialised
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
        if element in self._layouts:
            return self._fixed(element, count)
        found: list[Item] = []
        for _ in range(count):
            code = element or self._int32()
            if code == STRING:
                found.append(str(self._block("string"), "utf-8", "surrogateescape"))
            elif code == INT32:
                found.append(self._int32())
            else:
                found.append(self._item(code, depth))
        return found

    def _item(self, code: int, depth: int) -> Item:
        if code in self._layouts:
            return self._fixed(code, 1)[0]
        if code == BLOB:
            return bytes(self._block("blob"))
        if code & ~ELEMENT == LIST:
            return Bottle(self._list(code & ELEMENT, depth + 1))
        if code & ~ELEMENT == LIST + DICT:
            return Properties(self.whole(depth + 1))
        raise RemoteProtocolError(f"a Bottle has an item of unknown type code {code}")

    def _fixed(self, code: int, count: int) -> list[Item]:
        self.codes_of_4 |= code in (FLOAT64_4, VOCAB64)
        layout = self._layouts[code]
        if count != 1:
            layout = struct.Struct(f"<{count}{_FORMATS[self._dialect][code]}")
        end = self.offset + layout.size
        if end > len(self._data):
            raise self._truncated(f"{count} items of type code {code}")
        values = layout.unpack_from(self._data, self.offset)
        self.offset = end
        if code == INT64:
            return [Int64(value) if -(2**31) <= value < 2**31 else value for value in values]
        kind = Float32 if layout.format.endswith("f") else _CLASSES.get(code)
        return [kind(value) for value in values] if kind else list(values)

    def _block(self, what: str) -> Buffer:
        """Return the bytes of an item that begins with its size."""
        length = self._int32()
        start = self.offset
        self.offset = end = start + length
        if length < 0:
            raise RemoteProtocolError(f"a Bottle has a {what} of {length} bytes")
        if end > len(self._data):
            raise self._truncated(f"a {what} of {length} bytes")
        return self._data[start:end]

    def _int32(self) -> int:
        value: int
        try:
            (value,) = _I32.unpack_from(self._data, self.offset)
        except struct.error:
            raise self._truncated("an int32") from None
        self.offset += 4
        return value

    def _truncated(self, what: str) -> RemoteProtocolError:
        return RemoteProtocolError(f"a Bottle ends at byte {len(self._data)} within {what}")
