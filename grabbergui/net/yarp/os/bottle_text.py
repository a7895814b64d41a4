"""Bottles as text, as typed and as shown by YARP's tools."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from typing import Final

from grabbergui.core.errors import RemoteProtocolError
from grabbergui.net.yarp.os.values import (
    FALSE,
    MAX_DEPTH,
    MAX_ITEMS,
    TRUE,
    Dialect,
    Int64,
    Item,
    Vocab,
    Vocab64,
)

_BLANKS = frozenset(" \t\r\n")
_SEPARATORS = _BLANKS | {","}
_CLOSING = {")": "(", "}": "{"}
_OPENING = frozenset(_CLOSING.values())

_PLAIN_STRING = re.compile(r"[A-Za-z_][A-Za-z_0-9.-]*", re.ASCII)
_ESCAPES = {"\n": r"\n", "\r": r"\r", "\0": r"\0", "\\": r"\\", '"': r"\""}
_UNESCAPED = {"n": "\n", "r": "\r", "0": "\0"}

# One sign at most; digits after a hexadecimal prefix up to eight; one point.
_NUMBER_LIKE = re.compile(
    r"(?=[0-9+.-])(?!\.$)(?P<hex>[+-]?0*[xX][0-9a-fA-F+-]{0,8}$)|(?=[0-9+.-])(?!\.$)[+-]?[0-9.eE+-]*$",
    re.ASCII,
)
_C_INTEGER = re.compile(r"([+-]?)(?:0[xX]([0-9a-fA-F]+)|(0[0-7]*)|([1-9][0-9]*))", re.ASCII)
_C_FLOAT = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?", re.ASCII)

_Nested = Callable[[list[Item]], list[Item]]

_BLANK = re.compile(r"[ \t\r\n,]*")
_WORD = re.compile(r"""[ \t\r\n,]*([^ \t\r\n,(){}"\\]+)(?=[ \t\r\n,)}]|\Z)""")
"A word in which no character has a meaning of its own, and the separators before it."
_PLAIN_BLOB = re.compile(r"\{((?:[ \t\r\n,]*(?:0|[1-9][0-9]{0,8})(?=[ \t\r\n,}]))*)[ \t\r\n,]*\}", re.ASCII)
"A blob of decimal numbers."
_ORDINARY = re.compile(r"""[^ \t\r\n,(){}"\\]+""")
_QUOTED = re.compile(r'"[^"\\]*(?:\\.[^"\\]*)*"', re.DOTALL)
_MARK = re.compile(r'\\.?|["(){}]', re.DOTALL)
"An escaped character, a quote or a bracket: all that decides where a list ends."
_DECIMALS: Final = [str(number) for number in range(256)]
_AT_ONCE: Final = 1 << 16
"""Bytes that are rendered without letting other threads run, about 2 ms."""


def parse_text(text: str, dialect: Dialect = Dialect.YARP3, nested: _Nested = list) -> list[Item]:
    """Return the items of a line; `nested` makes the lists among them.

    Reads every character once at any depth. Raises RemoteProtocolError if brackets or quotes do not match,
    and for more than `MAX_ITEMS` items or `MAX_DEPTH` nested lists.
    """
    return _BottleTextParser(text, dialect, nested).items()


class Nesting:
    """Follows brackets and quotes through a Bottle that spans several lines."""

    def __init__(self) -> None:
        self._depth = {"(": 0, "{": 0}
        self._quoted = False
        self._escape = ""
        "A backslash at the end of what was fed, which escapes the first character of the next line."

    @property
    def open(self) -> bool:
        """Whether the Bottle continues in the next line: a bracket or quote is open, or closed too often."""
        return self._quoted or any(self._depth.values())

    def feed(self, line: str) -> None:
        """Read on. A backslash escapes the character behind it."""
        marks = _MARK.findall(self._escape + line)
        self._escape = "\\" if marks[-1:] == ["\\"] else ""
        for mark in marks:
            if mark == '"':
                self._quoted = not self._quoted
            elif self._quoted or mark[0] == "\\":
                continue
            elif mark in _CLOSING:
                self._depth[_CLOSING[mark]] -= 1
            else:
                self._depth[mark] += 1


class _BottleTextParser:
    """Walks through a text once, depth first."""

    def __init__(self, text: str, dialect: Dialect, nested: _Nested) -> None:
        self._text = text
        self._dialect = dialect
        self._nested = nested
        self._at = 0
        self._items_left = MAX_ITEMS

    def items(self, closing: str = "", depth: int = 0) -> list[Item]:
        """Read items up to the bracket that closes their list; the outermost list ends with the text."""
        if depth > MAX_DEPTH:
            raise RemoteProtocolError(f"a Bottle's lists are nested deeper than {MAX_DEPTH}")
        found: list[Item] = []
        while True:
            if word := _WORD.match(self._text, self._at):
                self._count_items()
                self._at = word.end()
                found.append(_item(word[1], self._dialect))
                continue
            first = self._next()
            if first == closing:
                self._at += len(closing)
                return found
            if first in _CLOSING or not first:
                raise _unbalanced()
            self._count_items()
            if first == "(":
                self._at += 1
                found.append(self._nested(self.items(")", depth + 1)))
            elif first == "{":
                found.append(self._blob(depth))
            else:
                found.append(_item(self._token(), self._dialect))

    def _blob(self, depth: int) -> bytes:
        """Read a blob, whose items are numbers or count as 0."""
        plain = _PLAIN_BLOB.match(self._text, self._at)
        if plain:
            numbers = plain[1].replace(",", " ").split()
            self._count_items(len(numbers))
            self._at = plain.end()
            return bytes(int(number) & 0xFF for number in numbers)
        self._at += 1
        return bytes(_byte(item) for item in self.items("}", depth + 1))

    def _count_items(self, count: int = 1) -> None:
        self._items_left -= count
        if self._items_left < 0:
            raise RemoteProtocolError(f"a Bottle has more than {MAX_ITEMS} items")

    def _next(self) -> str:
        """Skip separators; return the character at which the next item begins, empty at the end."""
        self._at = _BLANK.match(self._text, self._at).end()  # type: ignore[union-attr]
        return self._text[self._at : self._at + 1]

    def _token(self) -> str:
        """Read a word or quoted text, up to a separator or bracket that does not belong to it."""
        start = self._at
        within: list[str] = []  # brackets open in a word such as f(1 2)
        while self._at < len(self._text):
            char = self._text[self._at]
            if char == '"':
                quoted = _QUOTED.match(self._text, self._at)
                if not quoted:
                    raise _unbalanced()
                self._at = quoted.end()
            elif char == "\\":
                self._at = min(self._at + 2, len(self._text))
            elif char in _OPENING:
                within.append(char)
                self._at += 1
            elif char in _CLOSING and within:
                if within.pop() != _CLOSING[char]:
                    raise _unbalanced()
                self._at += 1
            elif not within and (char in _CLOSING or char in _SEPARATORS):
                break
            else:
                ordinary = _ORDINARY.match(self._text, self._at)
                self._at = ordinary.end() if ordinary else self._at + 1
        if within:
            raise _unbalanced()
        return self._text[start : self._at]


def _unbalanced() -> RemoteProtocolError:
    return RemoteProtocolError("a Bottle's brackets or quotes do not match")


def _item(token: str, dialect: Dialect) -> Item:
    match token[0]:
        case "[":
            return _vocab(token[1:-1], dialect)
        case '"':
            return _unescape(token[1:-1])
    if token in ("true", "false", "null"):
        return {"true": TRUE, "false": FALSE, "null": Vocab("null")}[token]
    if token in ("inf", "-inf", "nan"):
        return float(token)
    number = _NUMBER_LIKE.match(token)
    if not number or token.count(".") > 1:
        return _unescape(token)
    if not number["hex"] and re.search(r"[.eE]", token):
        digits = _C_FLOAT.match(token)
        return float(digits[0]) if digits else 0.0
    return _c_integer(token)


def _byte(item: Item) -> int:
    # A blob holds numbers; anything else in it counts as 0, as in YARP.
    number = item if isinstance(item, (int, float)) and not isinstance(item, (Vocab, Vocab64)) else 0
    return int(number) & 0xFF if math.isfinite(number) else 0


def _vocab(letters: str, dialect: Dialect) -> Vocab | Vocab64:
    if dialect is Dialect.YARP4 and len(letters) > Vocab.LETTERS:
        return Vocab64(letters[: Vocab64.LETTERS])
    return Vocab(letters[: Vocab.LETTERS])


def _c_integer(token: str) -> int:
    """Convert as C's strtoll with base 0: the leading digits that it can use, clipped to 64 bits."""
    digits = _C_INTEGER.match(token)
    if not digits:
        return 0
    sign, hexadecimal, octal, decimal = digits.groups()
    # No 64-bit number has more than 22 digits; Python would take its time over millions of them.
    text, base = (hexadecimal, 16) if hexadecimal else (octal, 8) if octal else (decimal, 10)
    value = int(sign + text[:32], base)
    value = max(-(2**63), min(2**63 - 1, value))
    return value if -(2**31) <= value < 2**31 else Int64(value)


def _unescape(text: str) -> str:
    if "\\" not in text:
        return text
    return re.sub(r"\\(.?)", lambda match: _UNESCAPED.get(match[1], match[1]), text)


def render_text(items: list[Item]) -> str:
    """Return the text form of the items, separated by blanks."""
    return " ".join(_render_item(item) for item in items)


def _render_item(item: Item) -> str:
    if isinstance(item, (list, tuple)):
        return f"({render_text(item)})"
    if isinstance(item, bool):
        return "true" if item else "false"
    if isinstance(item, (Vocab, Vocab64)):
        return "true" if item == TRUE else "false" if item == FALSE else f"[{item}]"
    if isinstance(item, int):
        return str(int(item))
    if isinstance(item, float):
        return _render_float(item)
    if isinstance(item, str):
        return quoted(item)
    return "{" + " ".join(_render_bytes(bytes(item))) + "}"


def _render_bytes(blob: bytes) -> Iterator[str]:
    for start in range(0, len(blob), _AT_ONCE):
        yield " ".join(map(_DECIMALS.__getitem__, blob[start : start + _AT_ONCE]))


def _render_float(value: float) -> str:
    text = f"{value:.21g}"
    return text if any(char in text for char in ".en") else text + ".0"


def quoted(text: str) -> str:
    """Return a string in quotes where YARP would set them."""
    if _PLAIN_STRING.fullmatch(text) and text not in ("true", "false"):
        return text
    return '"' + "".join(_ESCAPES.get(char, char) for char in text) + '"'
