"""Makes the reference from the program: pages of the manual, the man page, the commands for completion.

    python scripts/reference.py

`tests/unit/test_reference_document.py` checks that they are current.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

from grabbergui import __version__
from grabbergui.cli import EXIT_CODES, ON_FAILURE, arguments_of, command_parsers, sentence, shared_options
from grabbergui.cli.json_output import JSON_OUTPUT
from grabbergui.core.json_text import to_json
from grabbergui.core.pfnc import FORMATS, Family, PixelFormat, SampleLayout
from grabbergui.core.uri import option_rows
from grabbergui.sources import SourceKind

ROOT = Path(__file__).resolve().parents[1]
_MADE = "<!-- Made by `python scripts/reference.py`; change the program instead. -->"
_COMMANDS = f"""{_MADE}
# Command line

`grabbergui [SOURCE]` opens the window, `grabbergui COMMAND` does the rest. [Source URIs](source-uris.md) has
the forms of a SOURCE. `--log-level` and `--log-format` belong to every command, and may precede or follow it.
"""
_URIS = f"""{_MADE}
# Source URIs

A URI names a source by its kind, a colon, and an address or name. Options follow a question mark and are
joined by `&`; quote them for the shell: `grabbergui 'gige:SERIAL?packet_size=1500&resend=0'`. An unknown
option or a bad value is refused before anything is opened. `grabbergui list` shows the available sources.
"""
_PIXEL_FORMATS = """# Pixel formats

This program knows {count} formats of the Pixel Format Naming Convention (PFNC 2.4) by name, of which {shown}
can be shown. It also knows the names of GigE Vision 1.x (`RGB8Packed`) and the codes that Basler's older
cameras use for formats of the convention. A vendor's own code is called what the camera calls it, like
compressed formats (Hikrobot's `Mono8HB`) and those of event cameras; such frames are received and recorded
as raw data. The layout of any other unknown code is guessed from its bits per pixel.

*Bits* are those of a pixel in the payload and, if different, the significant bits of a sample. *Unpacked as*
is the result of `frame.raw()`: type and components; packed samples have their value in the low bits.
*Made by* is the cost of the conversion:

- **view**: `raw()` is a view of the payload; colour takes one pass of OpenCV.
- **OpenCV**: the same, and colour is OpenCV's own conversion.
- **compiled**: a loop compiled by numba (the extra `fast`): unpacking takes about twice the time of a plain
  copy, YUV 1.3 times OpenCV's conversion. Without numba, numpy and OpenCV need several passes.
- **look-up**: one table look-up per byte.
- **numpy**: several passes; range images, masks and formats that cameras rarely send.

[Benchmarks](../benchmarks.md#converting-images) has figures.
"""
_FAMILIES = {
    Family.MONO: "One value per pixel",
    Family.BAYER: "Bayer",
    Family.SPARSE: "Sparse colour filters",
    Family.RGB: "RGB",
    Family.BICOLOR: "BiColor",
    Family.YUV: "YUV and YCbCr",
    Family.COORDINATES: "Coordinates",
}


def files() -> dict[Path, str]:
    """Return the text of every file that is made from the program."""
    return {
        ROOT / "docs" / "command-line.md": command_line_page(),
        ROOT / "docs" / "source-uris.md": source_uris_page(),
        ROOT / "docs" / "reference" / "pixel-formats.md": pixel_formats_page(),
        ROOT / "resources" / "man" / "grabbergui.1": man_page(),
        ROOT / "resources" / "completion" / "commands.json": to_json(
            completion_table(), indent=1, ascii_only=False
        )
        + "\n",
    }


def command_line_page() -> str:
    """Document every command with its arguments, and the exit codes."""
    parts = [_COMMANDS]
    for name, (_, parser) in command_parsers().items():
        parts += [f"## grabbergui {name}\n", parser.description or "", ""]
        parts += ["```sh", parser.example, "```", ""]
        parts += _table(("argument", "meaning"), _arguments(parser))
        parts.append("")
        if (output := JSON_OUTPUT.get(name)) is not None:
            parts += [f"With `--json` it prints {output.form}{':' if output.fields else '.'}", ""]
            if output.fields:
                rows = [(f"`{field}`", meaning) for field, meaning in output.fields.items()]
                parts += [*_table(("field", "meaning"), rows), ""]
    parts += ["## Exit codes\n", *_table(("code", "meaning"), _rows(EXIT_CODES.items())), "", ON_FAILURE, ""]
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


def pixel_formats_page() -> str:
    """Document every format: name, code, bits, how it is unpacked, shown and how fast."""
    shown = sum(pixel_format.convertible for pixel_format in FORMATS)
    lines = [_MADE, _PIXEL_FORMATS.format(count=len(FORMATS), shown=shown)]
    head = ("name", "code", "bits", "unpacked as", "shown as", "made by")
    for family, title in _FAMILIES.items():
        rows = [_described(each) for each in FORMATS if each.family is family]
        lines += [f"## {title}\n", *_table(head, rows), ""]
    return "\n".join(lines)


def _described(pixel_format: PixelFormat) -> tuple[str, ...]:
    bits = f"{pixel_format.bits_per_pixel}"
    if pixel_format.depth != pixel_format.bits_per_pixel:
        bits += f", {pixel_format.depth}"
    return (
        f"`{pixel_format.name}`",
        f"`0x{pixel_format.code:08X}`",
        bits,
        unpacked_as(pixel_format),
        shown_as(pixel_format),
        made_by(pixel_format),
    )


def unpacked_as(pixel_format: PixelFormat) -> str:
    """Return type and components of `Frame.raw`."""
    if not pixel_format.convertible:
        return "–"
    kind = {"u": "uint", "i": "int", "f": "float"}[pixel_format.kind]
    sample = f"{kind}{8 * pixel_format.sample_bytes}"
    return sample if pixel_format.components == 1 else f"{sample} × {pixel_format.components}"


def shown_as(pixel_format: PixelFormat) -> str:
    """Return what a display shows of it."""
    if not pixel_format.convertible:
        return "not shown; its bytes can be saved"
    if pixel_format.needs_range:
        return "grey, smallest to largest value"
    if pixel_format.family is Family.YUV:
        matrix = pixel_format.standard or "601"
        return f"colour, BT.{matrix}, {'limited' if pixel_format.standard else 'full'} range"
    if pixel_format.family in (Family.BAYER, Family.SPARSE):
        return "colour, interpolated"
    return "grey" if pixel_format.family is Family.MONO else "colour"


def made_by(pixel_format: PixelFormat) -> str:
    """Return the class of speed, by a format's way through `core.unpacking` and `core.colour`."""
    if not pixel_format.convertible:
        return "–"
    if pixel_format.packed and not pixel_format.planar:
        return "look-up" if pixel_format.depth < 8 else "compiled"
    spread = pixel_format.expands_chroma or pixel_format.layout is SampleLayout.FIELDS or pixel_format.planar
    if spread or pixel_format.needs_range or pixel_format.kind != "u" or pixel_format.depth < 8:
        return "numpy"
    if pixel_format.family in (Family.SPARSE, Family.BICOLOR):
        return "numpy"
    if pixel_format.family is Family.YUV:
        whole = pixel_format.components == 3 or pixel_format.standard == "601"
        return "OpenCV" if whole else "compiled"
    return "view"


def man_page() -> str:
    """Return the man page in section 1, as man(7) macros."""
    parts = [
        '.\\" Made by `python scripts/reference.py`; change the program instead.',
        f'.TH GRABBERGUI 1 "" "grabbergui {__version__}" "User Commands"',
        ".SH NAME",
        r"grabbergui \- tune GenICam cameras live, and share them on YARP and ROS 2 networks",
        ".SH SYNOPSIS",
        ".B grabbergui\n.RI [ SOURCE ]",
        '.br\n.B grabbergui\n.IR COMMAND " [" ARGUMENT " ...]"',
        ".SH DESCRIPTION",
        _roff("Without a command it opens the window on SOURCE, or on the source that was open last."),
        ".SH OPTIONS",
        _roff("They belong to every command, and may precede or follow it."),
    ]
    for action in shared_options():
        parts += [".TP", *_man_argument(action)]
    parts.append(".SH COMMANDS")
    for name, (_, parser) in command_parsers().items():
        parts += [f'.SS "grabbergui {name}"', _roff(parser.description or "")]
        for action in _explained(parser):
            parts += [".TP", *_man_argument(action, parser)]
        parts += [".PP", "Example:", ".PP", ".RS", ".nf", _roff(parser.example), ".fi", ".RE"]
    parts.append(".SH SOURCES")
    for kind in SourceKind:
        for uri, meaning in kind.forms:
            parts += [".TP", f".B {_roff(uri)}", _roff(sentence(meaning.replace("`", "")))]
    parts += [".PP", _roff("Options of a source follow a question mark and are joined by &.")]
    for kind in SourceKind:
        for row in option_rows(kind.options):
            default = f" ({row.default})" if row.default else ""
            meaning = row.meaning.replace("`", "") + default
            parts += [".TP", f".B {_roff(f'{kind.value}: {row.name}={row.form}')}", _roff(sentence(meaning))]
    parts.append(".SH EXIT STATUS")
    for code, meaning in EXIT_CODES.items():
        parts += [".TP", f".B {code}", _roff(sentence(meaning.replace("`", "")))]
    parts += [".PP", _roff(ON_FAILURE.replace("`", ""))]
    parts += [
        ".SH ENVIRONMENT",
        ".TP\n.B GRABBERGUI_INTERFACES",
        _roff(
            "Network interfaces on which cameras are searched, separated by commas; none searches nowhere."
        ),
        ".TP\n.B NO_COLOR",
        _roff("Print without colours."),
        ".SH SEE ALSO",
        _roff("`grabbergui paths manual` prints where the manual's pages are."),
    ]
    return "\n".join(parts) + "\n"


def _man_argument(action: argparse.Action, parser: argparse.ArgumentParser | None = None) -> list[str]:
    names = [f"{name} {_value(action)}".strip() for name in action.option_strings] or [_value(action)]
    return [f".B {_roff(', '.join(names))}", _roff(sentence(_meaning(action, parser)))]


def _roff(text: str) -> str:
    """Escape a line of text for roff; ASCII alone is sure to survive every device."""
    text = text.replace("\\", r"\e").replace("-", r"\-").replace("'", r"\(aq").replace("`", r"\(ga")
    text = "".join(sign if sign.isascii() else rf"\[u{ord(sign):04X}]" for sign in text)
    return rf"\&{text}" if text.startswith(".") else text


def completion_table() -> dict[str, Any]:
    """Return the commands with their arguments, as `grabbergui.setup.completion` reads them."""
    return {
        "shared": [_completed(action) for action in shared_options()],
        "sources": {
            uri: meaning.replace("`", "")
            for kind in SourceKind
            for uri, meaning in kind.forms
            if uri == uri.lower() and not any(sign.isdigit() for sign in uri.partition(":")[2])
        }
        | {f"{kind.value}:": kind.forms[0][1] for kind in SourceKind},
        "commands": {
            name: {
                "summary": summary,
                "positionals": [_completed(each) for each in _explained(parser) if not each.option_strings],
                "options": [_completed(each) for each in _explained(parser) if each.option_strings],
            }
            for name, (summary, parser) in command_parsers().items()
        },
    }


_FILES = frozenset({"FILE", "FOLDER", "PATH"})


def _completed(action: argparse.Action) -> dict[str, Any]:
    """Return what completion needs to know of one argument."""
    value = str(action.metavar or action.dest)
    described: dict[str, Any] = {"names": list(action.option_strings), "help": _meaning(action)}
    if action.nargs == 0:
        return {**described, "kind": "flag"}
    if action.choices is not None:
        described["choices"] = [str(choice) for choice in action.choices]
    kinds = {"SOURCE": "source", "SOURCE|FILE": "source or file", "NAME=VALUE": "assignment"}
    if action.choices is not None:
        kind = "choice"
    elif action.dest in ("names", "command"):
        kind = "feature"
    else:
        kind = kinds.get(value, "file" if value in _FILES else "text")
    return {**described, "kind": kind, "many": action.nargs in ("*", "+")}


def _explained(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    """Yield the arguments of a parser that have help; those that every command has are left out."""
    for action in arguments_of(parser):
        if action.dest != "help" and action.help != argparse.SUPPRESS:
            yield action


def _meaning(action: argparse.Action, parser: argparse.ArgumentParser | None = None) -> str:
    return (action.help or "") % {**vars(action), "prog": parser.prog if parser else "grabbergui"}


def _arguments(parser: argparse.ArgumentParser) -> Iterator[tuple[str, str]]:
    """Yield the names of each argument of a parser, and its help."""
    for action in _explained(parser):
        value = _value(action)
        names = [f"`{f'{name} {value}'.strip()}`" for name in action.option_strings] or [f"`{value}`"]
        yield ", ".join(names), _meaning(action, parser)


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


def _rows(pairs: Iterable[tuple[object, str]]) -> list[tuple[str, str]]:
    return [(str(first), second) for first, second in pairs]


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    lines = [head, ["---"] * len(head), *rows]
    return ["| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines]


if __name__ == "__main__":
    for path, text in files().items():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, "utf-8")
