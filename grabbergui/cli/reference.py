"""The reference of commands, options, exit codes and source URIs, made from the program itself.

`python -m grabbergui.cli.reference docs` writes `command-line.md` and `source-uris.md` there; a test holds
that they are current. `sources_help` is the end of `grabbergui --help`.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from grabbergui.cli import EXIT_CODES, command_parsers
from grabbergui.core.source_options import option_rows
from grabbergui.sources import SourceKind

_MADE = "<!-- Made by `python -m grabbergui.cli.reference docs`; change the program instead. -->"
_COMMANDS = f"""{_MADE}
# Command line

`grabbergui [SOURCE]` opens the window, `grabbergui COMMAND` does the rest. [Source URIs](source-uris.md) has
the forms of a SOURCE. `--log-level` and `--log-format` belong to every command, and may precede or follow it.
"""
_URIS = f"""{_MADE}
# Source URIs

A source is named by its kind, a colon, and which one of that kind. Options follow a question mark, joined by
`&`; quote them for the shell: `grabbergui 'gige:SERIAL?packet_size=1500&resend=0'`. An unknown option or a
bad value is an error before anything is opened. `grabbergui list` shows the sources in reach.
"""


def pages() -> dict[str, str]:
    """Return the text of every page by its file name."""
    return {"command-line.md": command_line_page(), "source-uris.md": source_uris_page()}


def command_line_page() -> str:
    """Document every command with its arguments, and the exit codes."""
    parts = [_COMMANDS]
    for name, (summary, parser) in command_parsers().items():
        parts += [f"## grabbergui {name}\n", _sentence(parser.description or summary), ""]
        parts += _table(("argument", "meaning"), _arguments(parser))
        parts.append("")
    parts += ["## Exit codes\n", *_table(("code", "meaning"), _rows(EXIT_CODES.items())), ""]
    return "\n".join(parts)


def source_uris_page() -> str:
    """Document the kinds of source, the forms of their URIs, and their options."""
    parts = [_URIS]
    for kind in SourceKind:
        parts += [
            f"## {kind.value}:\n",
            *_table(("URI", "source"), [(f"`{uri}`", what) for uri, what in kind.forms]),
        ]
        rows = [
            (f"`{row.name}=`", f"`{row.form}`", f"`{row.default}`" if row.default else "", row.meaning)
            for row in option_rows(kind.options)
        ]
        if rows:
            parts += ["", *_table(("option", "value", "default", "meaning"), rows)]
        parts.append("")
    return "\n".join(parts)


def sources_help() -> str:
    """Return the kinds of source and their options as plain text for `--help`."""
    forms = [form for kind in SourceKind for form in kind.forms]
    width = max(len(uri) for uri, _ in forms)
    lines = ["sources (`grabbergui list` shows those in reach):"]
    lines += [f"  {uri:{width}}  {meaning.replace('`', '')}" for uri, meaning in forms]
    lines.append("\noptions of a source, behind a question mark and joined by &:")
    for kind in SourceKind:
        options = [f"{row.name}={row.form}" for row in option_rows(kind.options)]
        if options:
            lines.append(f"  {kind.value + ':':6} {' '.join(options)}")
    return "\n".join(lines)


def _arguments(parser: argparse.ArgumentParser) -> Iterator[tuple[str, str]]:
    """Yield each argument of a parser with its help; those that every command has are left out."""
    for action in parser._actions:
        if action.dest in ("help", "log_level", "log_format") or action.help == argparse.SUPPRESS:
            continue
        value = _value(action)
        names = [f"`{f'{name} {value}'.strip()}`" for name in action.option_strings] or [f"`{value}`"]
        yield ", ".join(names), (action.help or "") % {**vars(action), "prog": parser.prog}


def _value(action: argparse.Action) -> str:
    if action.nargs == 0:
        return ""
    choices = action.choices
    if isinstance(action, argparse._SubParsersAction) or choices is None:
        plain = action.dest.upper() if action.option_strings else action.dest
        value = action.metavar if isinstance(action.metavar, str) else plain
    else:
        value = "|".join(map(str, choices))
    many = {"*": f"[{value} …]", "+": f"{value} …", "?": f"[{value}]", argparse.REMAINDER: f"{value} …"}
    return many.get(str(action.nargs), value)


def _sentence(text: str) -> str:
    return f"{text[:1].upper()}{text[1:].rstrip('.')}."


def _rows(pairs: Iterable[tuple[object, str]]) -> list[tuple[str, str]]:
    return [(str(first), second) for first, second in pairs]


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    lines = [head, ["---"] * len(head), *rows]
    return ["| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines]


if __name__ == "__main__":
    for name, text in pages().items():
        (Path(sys.argv[1]) / name).write_text(text, "utf-8")
