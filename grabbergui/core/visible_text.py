"""Display text: what a terminal would take for a command is made visible.

Names, units, values, errors and file names come from cameras, peers and folders. In a terminal they could
move the cursor, set its title, reverse the order of letters (U+202E) or hide letters, and in a log forge
records. Every line that a command prints goes through `print_line`, every log record through `cli.process`.
JSON goes through `print_json`: readers get the exact text, escaped as JSON escapes it.
"""

from __future__ import annotations

import sys
import traceback
import unicodedata
from collections.abc import Iterable
from types import TracebackType
from typing import Any, TextIO

from grabbergui.core.json_text import to_json

_SHORT = {"\n": r"\n", "\r": r"\r", "\t": r"\t"}
_BLANK_LETTERS = "\u115f\u1160\u3164\uffa0\u2800"
"""Letters without a shape, which would hide as spaces."""


def visible(text: str) -> str:
    r"""Return one line of text that a terminal shows as it is: ESC as `\x1b`, a newline as `\n`."""
    return "".join(map(_spelled, text)) if not text.isprintable() or _has_blanks(text) else text


def _has_blanks(text: str) -> bool:
    return not text.isascii() and any(sign in text for sign in _BLANK_LETTERS)


def _spelled(sign: str) -> str:
    # Python calls no space but the plain one printable.
    if (sign.isprintable() or unicodedata.category(sign) == "Zs") and sign not in _BLANK_LETTERS:
        return sign
    code = ord(sign)
    digits = f"x{code:02x}" if code < 0x100 else f"u{code:04x}" if code < 0x10000 else f"U{code:08x}"
    return _SHORT.get(sign) or f"\\{digits}"


def shortened(text: str, most: int) -> str:
    """Return at most so many characters of a text, the last one an ellipsis if some are missing.

    A label of a million characters takes a window ten seconds.
    """
    return text if len(text) <= most else f"{text[: most - 1]}…"


def print_line(text: object = "", *, error: bool = False, flush: bool = False) -> None:
    """Print one line to stdout, or to stderr, if it is open."""
    _print(visible(str(text)), sys.stderr if error else sys.stdout, flush=flush)


def print_lines(lines: Iterable[str], *, error: bool = False, flush: bool = False) -> None:
    """Print lines, each of which may come from outside."""
    for line in lines:
        print_line(line, error=error, flush=flush)


def print_json(value: Any, *, indent: int | None = None, flush: bool = False) -> None:
    """Print a value as JSON, in ASCII."""
    _print(to_json(value, indent=indent), sys.stdout, flush=flush)


def print_note(text: str) -> None:
    """Replace the line on stderr, which is a terminal, by a passing note; an empty one erases it."""
    _print(f"\r\033[K{visible(text)}", sys.stderr, end="", flush=True)


def print_traceback(
    kind: type[BaseException], error: BaseException | None, trace: TracebackType | None
) -> None:
    """Print an exception that nothing caught; a `sys.excepthook`."""
    text = "".join(traceback.format_exception(kind, error, trace))
    print_lines(text.rstrip("\n").split("\n"), error=True)


def _print(text: str, stream: TextIO | None, *, end: str = "\n", flush: bool = False) -> None:
    if stream is not None:
        print(text, end=end, file=stream, flush=flush)
