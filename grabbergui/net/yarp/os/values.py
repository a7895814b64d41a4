"""Types of values in messages: those of a Bottle that Python lacks, and the stamp in an envelope.

``int`` is written as int32 (int64 if necessary), ``float`` as float64, ``str`` as a string, ``bytes`` as a
blob, a list as a list. The classes here are the other types of the wire.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from typing import Final, Union

from grabbergui.core.errors import LocalProtocolError


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
            raise LocalProtocolError(f"vocab [{word}] is too long, allowed are {cls.LETTERS} letters")
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

Item = Union[int, float, str, bytes, bytearray, memoryview, "list[Item]"]
"""An item of a Bottle. A ``bool`` is sent as the vocab that YARP uses for it."""

MAX_DEPTH: Final = 64
"""Lists within lists; YARP has no limit, we do not follow a peer into its stack overflow."""

MAX_ITEMS: Final = 10_000
"""Items of one message. Reading one takes Python 1 to 2 µs, so no message holds it up for more than 20 ms."""


def word(item: object) -> str:
    """Return the text of a string or vocab, as commands are matched; empty for anything else."""
    return str(item) if isinstance(item, (str, _AnyVocab)) else ""


_WRAP = 2**31


@dataclass(frozen=True)
class Stamp:
    """YARP's envelope, `COUNT TIME` as text."""

    count: int
    "0 to 2³¹-1, then from 0 again."
    time: float
    "Seconds since 1970; YARP's 15 digits keep some 10 microseconds of it."

    def encode(self) -> str:
        """Return the text on the wire."""
        return f"{self.count % _WRAP} {self.time:.15g}"

    @classmethod
    def decode(cls, text: str) -> Stamp | None:
        """Return the stamp in an envelope; None where it is something else, which is legal."""
        words = text.split()
        try:
            stamp = cls(int(words[0]), float(words[1]))
        except (ValueError, IndexError):
            return None
        return stamp if math.isfinite(stamp.time) and 0 <= stamp.count < _WRAP else None
