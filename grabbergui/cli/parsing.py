"""The parser of every command: its help has an example, keeps to the terminal's width, and ends by itself."""

from __future__ import annotations

import argparse
import shutil
import textwrap
from typing import Any

NARROWEST = 40
"""Columns below which help is not wrapped any further."""


def columns() -> int:
    """Return how wide a line of help may be: the terminal, less the two columns that argparse leaves free."""
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
