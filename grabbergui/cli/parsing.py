"""The parser of every command, and the types of its arguments.

Help has an example, keeps to the terminal's width, and ends by itself. The types refuse bad values at once.
"""

from __future__ import annotations

import argparse
import math
import shutil
import textwrap
from typing import Any

NARROWEST = 40
"""Columns below which help is not wrapped any further."""


def columns() -> int:
    """Return the width of a line of help: the terminal's, less the two columns that argparse leaves free."""
    return max(shutil.get_terminal_size().columns - 2, NARROWEST)


def wrapped(text: str, indent: str = "", first: str | None = None) -> str:
    """Wrap one paragraph to the terminal's width, its first line with an indent of its own."""
    return textwrap.fill(
        text,
        columns(),
        initial_indent=indent if first is None else first,
        subsequent_indent=indent,
        break_long_words=False,
        break_on_hyphens=False,
    )


class CommandParser(argparse.ArgumentParser):
    """Parses one command. `example` is a complete command line, printed below the options."""

    def __init__(self, *arguments: Any, example: str = "", **keywords: Any) -> None:
        super().__init__(*arguments, **keywords)
        self.example = example

    def format_help(self) -> str:
        """Return usage, description, arguments, and the example."""
        text = super().format_help()
        return f"{text}\nexample:\n  {self.example}\n" if self.example else text


def count(text: str) -> int:
    """Parse a whole number of at least 1."""
    return _whole(text, 1, None)


def count_or_none(text: str) -> int:
    """Parse a whole number of at least 0."""
    return _whole(text, 0, None)


def port(text: str) -> int:
    """Parse a TCP port; 0 stands for any free one."""
    return _whole(text, 0, 0xFFFF)


def key(text: str) -> int:
    """Parse a number of 32 bits, decimal or hexadecimal."""
    try:
        return _whole(text, 0, 0xFFFFFFFF)
    except argparse.ArgumentTypeError:
        raise argparse.ArgumentTypeError(f"'{text}' is no number from 0 to 0xFFFFFFFF") from None


def positive(text: str) -> float:
    """Parse a finite number above 0."""
    value = _finite(text)
    if value <= 0:
        raise argparse.ArgumentTypeError(f"'{text}' is not more than 0")
    return value


def not_negative(text: str) -> float:
    """Parse a finite number of at least 0."""
    value = _finite(text)
    if value < 0:
        raise argparse.ArgumentTypeError(f"'{text}' is less than 0")
    return value


def part(text: str) -> float:
    """Parse a share: `1%` or `0.01`."""
    value = not_negative(text.removesuffix("%")) / (100 if text.endswith("%") else 1)
    if value > 1:
        raise argparse.ArgumentTypeError(f"'{text}' is more than all; write 1% or 0.01")
    return value


def seconds(text: str) -> float:
    """Parse a duration: `5ms`, `0.005s` or `0.005`."""
    if text.endswith("ms"):
        return not_negative(text.removesuffix("ms")) / 1000
    return not_negative(text.removesuffix("s"))


def counted(number: int, noun: str) -> str:
    """Return `1 frame` or `2 frames`."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def _whole(text: str, least: int, most: int | None) -> int:
    try:
        value = int(text, 0)
    except ValueError:
        value = least - 1
    if value < least or (most is not None and value > most):
        limits = f"from {least} on" if most is None else f"from {least} to {most}"
        raise argparse.ArgumentTypeError(f"'{text}' is no whole number {limits}")
    return value


def _finite(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"'{text}' is no number")
    return value
