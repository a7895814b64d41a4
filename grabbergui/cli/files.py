"""The command about files in a camera: `files`."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from grabbergui.cli.arguments import add_source, opened
from grabbergui.cli.process import passing_note, stop_on_signals
from grabbergui.core.environment import check_folder_of, write_whole
from grabbergui.core.errors import ExistingFileError, UsageError
from grabbergui.core.file_access import (
    CameraFile,
    Progress,
    content_of,
    delete_file,
    list_files,
    read_file,
    write_file,
)
from grabbergui.core.json_text import to_json
from grabbergui.core.visible_text import print_json, print_line

_ARGUMENTS = {"list": (0, 0), "get": (1, 2), "put": (2, 2), "delete": (1, 1)}
"Least and most arguments of each action."


def add_commands(commands: Any) -> None:
    """Add the parser of this family."""
    parser = commands.add_parser(
        "files",
        help="list, download, upload and delete files in a camera",
        example="grabbergui files gige: put LUTLuminance gamma.bin",
    )
    add_source(parser)
    parser.add_argument(
        "action",
        nargs="?",
        choices=tuple(_ARGUMENTS),
        default="list",
        help="list (the default), get NAME [PATH], put NAME PATH, or delete NAME",
    )
    parser.add_argument("name", metavar="NAME", nargs="?", help="a file, as `files SOURCE list` shows it")
    parser.add_argument(
        "path",
        metavar="PATH",
        nargs="?",
        type=Path,
        help="a file on this computer (for get: NAME in the current folder)",
    )
    parser.add_argument(
        "--replace-firmware",
        action="store_true",
        help="let put write firmware; a wrong file or a power cut may make the camera unusable",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON array (list) or object")
    parser.set_defaults(run=_files)


def _files(options: argparse.Namespace) -> int:
    given = sum(argument is not None for argument in (options.name, options.path))
    least, most = _ARGUMENTS[options.action]
    if not least <= given <= most:
        needed = {"get": "NAME and perhaps PATH", "put": "NAME and PATH", "delete": "NAME"}
        raise UsageError(f"files {options.action} takes {needed.get(options.action, 'no further argument')}")
    action = {"list": _list, "get": _get, "put": _put, "delete": _delete}[options.action]
    action(options)
    return 0


def _list(options: argparse.Namespace) -> None:
    with opened(options.source) as grabber:
        files = list_files(grabber)
    if options.json:
        print_json([file.as_dict() for file in files], indent=2)
        return
    width = max((len(file.name) for file in files), default=0)
    for file in files:
        print_line(_line(file, width))


def _line(file: CameraFile, width: int) -> str:
    size = "?" if file.size is None else str(file.size)
    details = ", ".join(f"{name} = {value}" for name, value in file.details.items())
    return f"{file.name:{width}}  {size:>9} B  {details}".rstrip()


def _get(options: argparse.Namespace) -> None:
    path = options.path or Path(options.name)
    if path.exists():
        raise ExistingFileError(f"{path} exists already; nothing is overwritten. Name another file")
    check_folder_of(path)
    with (
        opened(options.source) as grabber,
        stop_on_signals() as cancelled,
        _progress(options.name) as progress,
    ):
        content = read_file(grabber, options.name, progress=progress, cancelled=cancelled)
    write_whole(path, content)
    _report(options, {"file": options.name, "size": len(content), "path": str(path)}, f"saved as {path}")


def _put(options: argparse.Namespace) -> None:
    content = content_of(options.path)
    with (
        opened(options.source) as grabber,
        stop_on_signals() as cancelled,
        _progress(options.name) as progress,
    ):
        written = write_file(
            grabber,
            options.name,
            content,
            replace_firmware=options.replace_firmware,
            progress=progress,
            cancelled=cancelled,
        )
    outcome = (
        "written and read back" if written.verified else "written; the camera does not let it be read back"
    )
    result = {"file": options.name, "size": written.size, "verified": written.verified}
    _report(options, result, outcome)


def _delete(options: argparse.Namespace) -> None:
    with opened(options.source) as grabber:
        delete_file(grabber, options.name)
    if options.json:
        print_json({"file": options.name, "deleted": True})
    else:
        print_line(f"{options.name}: deleted")


def _report(options: argparse.Namespace, result: dict[str, Any], outcome: str) -> None:
    print_line(to_json(result) if options.json else f"{options.name}: {result['size']} bytes {outcome}")


@contextmanager
def _progress(name: str) -> Iterator[Progress]:
    """Show the progress of a transfer while it runs."""
    with passing_note(name) as show:
        yield lambda done, of: show(f"{name}: {100 * done // of} %" if of else f"{name}: {done} bytes")
