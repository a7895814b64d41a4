"""The program's environment: the command that runs it, its own files, and its user's folders (XDG)."""

from __future__ import annotations

import contextlib
import os
import secrets
import shutil
import stat
import sys
from collections.abc import Mapping
from pathlib import Path

from grabbergui.core.errors import MissingFileError, UsageError
from grabbergui.core.shell_words import shell_line

NAME = "grabbergui"


def program() -> list[str]:
    """Return the absolute path of the installed command, or Python with `-m` if there is none.

    The command is looked for beside the running Python. Links are not followed, as the Python of a virtual
    environment is a link out of it.
    """
    command = Path(sys.executable).with_name(NAME)
    if command.is_file():
        return [str(command)]
    return [sys.executable, "-m", NAME]


def shell_command(*arguments: str, absolute: bool = False) -> str:
    """Return what to type: the program's name if the shell finds it, else its path.

    With `absolute` always the path, as sudo and services search other folders.
    """
    command = program()
    found = shutil.which(NAME)
    if not absolute and found is not None and Path(found).resolve() == Path(command[0]).resolve():
        command = [NAME]
    return shell_line([*command, *arguments])


def sudo_command(*arguments: str) -> str:
    """Return what to type to run this program as root."""
    return f"sudo {shell_command(*arguments, absolute=True)}"


def data_home(environment: Mapping[str, str] = os.environ) -> Path:
    """Return the folder of the user's data, in which desktops look for applications and file types."""
    return _folder(environment, "XDG_DATA_HOME", ".local/share")


def config_home(environment: Mapping[str, str] = os.environ) -> Path:
    """Return the folder of the user's configuration."""
    return _folder(environment, "XDG_CONFIG_HOME", ".config")


def cache_home(environment: Mapping[str, str] = os.environ) -> Path:
    """Return the folder of files that can be created again."""
    return _folder(environment, "XDG_CACHE_HOME", ".cache")


def _folder(environment: Mapping[str, str], variable: str, default: str) -> Path:
    # The specification ignores a relative path.
    folder = Path(environment.get(variable, ""))
    return folder if folder.is_absolute() else home() / default


def home() -> Path:
    """Return the user's home directory, or the root directory if the system has none for the user."""
    try:
        return Path.home()
    except RuntimeError:  # a user without an entry in the system's database, as in containers
        return Path("/")


def expanded(path: str | Path) -> Path:
    """Return a path with `~` or `~user` at its beginning expanded. Raises UsageError for an unknown user."""
    try:
        return Path(path).expanduser()
    except RuntimeError as error:
        raise UsageError(f"{path}: there is no such home directory; write the whole path") from error


_PACKAGE = Path(__file__).parents[1]
_CHECKOUT = (_PACKAGE.parent / "pyproject.toml").is_file()

RESOURCES = _PACKAGE.parent / "resources" if _CHECKOUT else _PACKAGE / "resources"
"""The folder of the files shipped with the program, in a checkout or installed."""
MANUAL = _PACKAGE.parent / "docs" if _CHECKOUT else _PACKAGE / "manual"
"""The folder of the manual's pages."""
EXAMPLES = (_PACKAGE.parent if _CHECKOUT else _PACKAGE) / "examples"
"""The folder of the library's example programs."""


def find_file(path: Path, what: str = "file", folder: str = "") -> Path:
    """Return the file at `path`, or the shipped file of that name (`servo/servo.ini`, `servo.ini`).

    `resources/servo/servo.ini`, as the manual writes it, is found from any folder. A bare name is looked for
    in one `folder` of the resources, or in all. Raises MissingFileError.
    """
    if path.exists():
        return path
    parts = path.parts[1:] if path.parts[:1] == ("resources",) else path.parts
    if not path.is_absolute() and parts and ".." not in parts:
        found = [RESOURCES.joinpath(*parts)]
        if len(parts) == 1:  # compared, as the name itself may look like a pattern
            found = [each for each in sorted((RESOURCES / folder).rglob("*")) if each.name == parts[0]]
        for shipped in found:
            if shipped.is_file():
                return shipped
    raise MissingFileError(f"there is no {what} {path}")


_BINARY = getattr(os, "O_BINARY", 0)
"""Without it, Windows changes the ends of lines."""


def write_whole(path: Path, content: str | bytes) -> None:
    """Write a file atomically, text as UTF-8: if writing fails, the old content stays, or there is no file.

    A pipe or /dev/stdout is written to, never replaced; a link stays a link. Raises OSError.
    """
    if isinstance(content, str):
        content = content.encode()
    if path.exists() and not path.is_file():
        path.write_bytes(content)
        return
    try:
        _write_and_rename(path.resolve(), content)
    except OSError as error:
        error.filename = str(path)  # writing names no file, and creating one the draft
        raise


def _write_and_rename(path: Path, content: bytes) -> None:
    replaced = path.exists()
    mode = stat.S_IMODE(path.stat().st_mode) if replaced else 0o666
    draft = path.with_name(f".{path.name[:40]}.{secrets.token_hex(4)}")
    try:
        descriptor = os.open(draft, os.O_WRONLY | os.O_CREAT | os.O_EXCL | _BINARY, mode)
    except PermissionError:  # for the folder; the file itself may be writable
        path.write_bytes(content)
        return
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())  # otherwise a power cut after the rename may leave an empty file
        if replaced:
            draft.chmod(mode)
        draft.replace(path)
    except BaseException:
        with contextlib.suppress(OSError):
            draft.unlink()
        raise


def check_folder_of(path: Path) -> None:
    """Raise MissingFileError unless the folder of a new file or folder exists."""
    folder = path.absolute().parent
    if not folder.is_dir():
        raise MissingFileError(f"there is no folder {folder} for {path.name}; create it first")
