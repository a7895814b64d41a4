"""Values in messages: the types of a Bottle that Python lacks, Bottles as text, and the stamp in an envelope.

``int`` is written as int32 (int64 if necessary), ``float`` as float64, ``str`` as a string, ``bytes`` as a
blob, a list as a list. The classes here are the other types of the wire. The rules of the text form,
``[fgc] [set] [feat] 8 2.5 "two words" (1 2) {255 0}``, are YARP's own, oddities included: what looks like a
number is one, an integer may be octal or hexadecimal as in C, and numbers are printed with 21 digits.
"""

from __future__ import annotations

from enum import Enum
from typing import Final, Union

from grabbergui.core.errors import LocalProtocolError, RemoteProtocolError

Item = Union[int, float, str, bytes, bytearray, memoryview, "list[Item]"]
"""An item of a Bottle. A ``bool`` is sent as the vocab that YARP uses for it."""
MAX_DEPTH: Final = 64
"""Lists within lists. YARP has no limit; without one, a peer could overflow the stack."""
MAX_ITEMS: Final = 10_000
"""Items of one message. Reading one takes Python 1 to 2 µs, so no message holds it up for more than 20 ms."""


class Dialect(Enum):
    """Version of YARP on the wire: 3.x and 4.0 disagree on the meaning of type code 10."""

    YARP3 = "3.x"
    "float64 is 10, float32 is 128, no vocab64."
    YARP4 = "4.0"
    "float64 is 20, float32 is 10, vocab64 is 18."


class Int8(int):
    """An int8, for messages that require the type."""


class Int16(int):
    """An int16."""


class Int64(int):
    """An int64, even where the value would fit 32 bits."""


class Float32(float):
    """A float32."""


class _AnyVocab(int):
    LETTERS = 4

    def __new__(cls, word: str | int) -> _AnyVocab:
        if isinstance(word, int):
            return super().__new__(cls, word)
        letters = word.encode("latin-1", "replace")
        if len(letters) > cls.LETTERS:
            raise LocalProtocolError(f"vocab [{word}] is too long, at most {cls.LETTERS} letters")
        return super().__new__(cls, int.from_bytes(letters.ljust(cls.LETTERS, b"\0"), "little", signed=True))

    def __str__(self) -> str:
        return self.to_bytes(self.LETTERS, "little", signed=True).split(b"\0", 1)[0].decode("latin-1")

    def __repr__(self) -> str:
        return f"{type(self).__name__}({str(self)!r})"


class Vocab(_AnyVocab):
    """A word of up to four letters packed into an int32, low byte first: ``Vocab("fgi")``.

    Compares as the integer it is; ``str`` gives the letters back.
    """


class Vocab64(_AnyVocab):
    """A word of up to eight letters in an int64; YARP 4.0 only."""

    LETTERS = 8


TRUE = Vocab("1")
"""YARP's encoding of true; false is the vocab 0."""

FALSE = Vocab(0)


def word(item: object) -> str:
    """Return the text of a string or vocab, as commands are matched; empty for anything else."""
    return str(item) if isinstance(item, (str, _AnyVocab)) else ""


def item_text(item: Item) -> str:
    """Return an item as a word of a command line: numbers in figures, YARP's encoding of a switch as `true`.

    Raises RemoteProtocolError for a list or a blob.
    """
    if isinstance(item, bool) or (isinstance(item, Vocab) and item in (TRUE, FALSE)):
        return "true" if item else "false"
    if isinstance(item, (str, _AnyVocab)):
        return str(item)
    if isinstance(item, (int, float)):
        return repr(item).removesuffix(".0")
    raise RemoteProtocolError(f"a {'list' if isinstance(item, list) else 'blob'} where a word is expected")
