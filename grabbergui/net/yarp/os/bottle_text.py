"""Bottles in their text form: ``[fgc] [set] [feat] 8 2.5 "two words" (1 2) {255 0}``.

The rules are YARP's own, oddities included: what looks like a number is one, an integer may be octal or
hexadecimal as in C, and numbers are printed with 21 digits.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable

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


_List = Callable[[list[Item]], list[Item]]


def parse(text: str, dialect: Dialect = Dialect.YARP3, nested: _List = list) -> list[Item]:
    """The items of a line; lists among them are made by `nested`.

    Raises RemoteProtocolError where brackets or quotes do not match.
    """
    return _parse(text, dialect, nested, 0)


class _Nesting:
    """Which brackets and quotes are open, as a text is read."""

    def __init__(self) -> None:
        self._depth = {"(": 0, "{": 0}
        self._quoted = self._escaped = False

    @property
    def open(self) -> bool:
        """Whether any is; one that was closed too often counts too."""
        return self._quoted or any(self._depth.values())

    def take(self, char: str) -> bool:
        """Read on; whether the sign is neither bracket nor quote nor within quotes."""
        if self._escaped:
            self._escaped = False
        elif char == "\\":
            self._escaped = True
        elif char == '"':
            self._quoted = not self._quoted
        elif self._quoted:
            pass
        elif char in self._depth:
            self._depth[char] += 1
        elif char in _CLOSING:
            self._depth[_CLOSING[char]] -= 1
        else:
            return True
        return False


def is_complete(text: str) -> bool:
    """Whether no bracket or quote is left open, so that a Bottle does not go on in the next line."""
    nesting = _Nesting()
    for char in text:
        nesting.take(char)
    return not nesting.open


def render(items: list[Item]) -> str:
    """The text form of the items, separated by blanks."""
    return " ".join(_render_item(item) for item in items)


def _parse(text: str, dialect: Dialect, nested: _List, level: int) -> list[Item]:
    if level > MAX_DEPTH:
        raise RemoteProtocolError(f"a Bottle's lists are nested deeper than {MAX_DEPTH}")
    return [_item(token, dialect, nested, level) for token in _tokens(text)]


def _tokens(text: str) -> list[str]:
    """Split at blanks and commas that stand outside brackets and quotes."""
    tokens: list[str] = []
    nesting = _Nesting()
    start: int | None = None
    for index, char in enumerate(text):
        if start is None:
            if char in _SEPARATORS:
                continue
            start = index
        if nesting.take(char) and char in _SEPARATORS and not nesting.open:
            tokens.append(text[start:index])
            start = None
    if nesting.open:
        raise RemoteProtocolError("a Bottle's brackets or quotes do not match")
    if start is not None:
        tokens.append(text[start:])
    if len(tokens) > MAX_ITEMS:
        raise RemoteProtocolError(f"a Bottle has more than {MAX_ITEMS} items")
    return tokens


def _item(token: str, dialect: Dialect, nested: _List, level: int) -> Item:
    match token[0]:
        case "(":
            return nested(_parse(token[1:-1], dialect, nested, level + 1))
        case "{":
            return bytes(_byte(part) for part in _tokens(token[1:-1]))
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


def _byte(token: str) -> int:
    # A blob holds numbers; anything else in it counts as 0, as in YARP.
    number = 0 if token[0] in "({[" else _item(token, Dialect.YARP3, list, 0)
    return int(number) & 0xFF if isinstance(number, (int, float)) and math.isfinite(number) else 0


def _vocab(letters: str, dialect: Dialect) -> Vocab | Vocab64:
    if dialect is Dialect.YARP4 and len(letters) > Vocab.LETTERS:
        return Vocab64(letters[: Vocab64.LETTERS])
    return Vocab(letters[: Vocab.LETTERS])


def _c_integer(token: str) -> int:
    """What C's strtoll makes of it with base 0: the digits it can use, clipped to 64 bits."""
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
    return re.sub(r"\\(.?)", lambda match: _UNESCAPED.get(match[1], match[1]), text, flags=re.DOTALL)


def _render_item(item: Item) -> str:
    if isinstance(item, (list, tuple)):
        return f"({render(item)})"
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
    return "{" + " ".join(str(byte) for byte in bytes(item)) + "}"


def _render_float(value: float) -> str:
    text = f"{value:.21g}"
    return text if any(char in text for char in ".en") else text + ".0"


def quoted(text: str) -> str:
    """A string in quotes where YARP would set them."""
    if _PLAIN_STRING.fullmatch(text) and text not in ("true", "false"):
        return text
    return '"' + "".join(_ESCAPES.get(char, char) for char in text) + '"'
