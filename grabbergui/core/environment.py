"""The environment of the program: the command that runs it again, and the folders of its user (XDG)."""

from __future__ import annotations

import os
import shlex
import shutil
import sys
from collections.abc import Mapping
from pathlib import Path

NAME = "grabbergui"


def program() -> list[str]:
    """Return the absolute path of the installed command, or of Python with `-m` where there is none.

    It is the one beside the running Python, in whatever environment that is; links are not followed, as the
    Python of a virtual environment is a link out of it.
    """
    command = Path(sys.executable).with_name(NAME)
    if command.is_file():
        return [str(command)]
    return [sys.executable, "-m", NAME]


def shell_command(*arguments: str, absolute: bool = False) -> str:
    """Return what to type: the bare name where the shell would find this program by it, else its path.

    With `absolute` the path in any case, as sudo and services search other folders.
    """
    ours = program()
    found = shutil.which(NAME)
    if not absolute and found is not None and Path(found).resolve() == Path(ours[0]).resolve():
        ours = [NAME]
    return shlex.join([*ours, *arguments])


def sudo_command(*arguments: str) -> str:
    """Return what to type to run this program as root."""
    return f"sudo {shell_command(*arguments, absolute=True)}"


def data_home(environment: Mapping[str, str] = os.environ) -> Path:
    """Return the folder of the user's own data, in which desktops look for programs and types of files."""
    return _folder(environment, "XDG_DATA_HOME", ".local/share")


def config_home(environment: Mapping[str, str] = os.environ) -> Path:
    """Return the folder of the user's configuration."""
    return _folder(environment, "XDG_CONFIG_HOME", ".config")


def cache_home(environment: Mapping[str, str] = os.environ) -> Path:
    """Return the folder of what can be made again."""
    return _folder(environment, "XDG_CACHE_HOME", ".cache")


def _folder(environment: Mapping[str, str], variable: str, default: str) -> Path:
    # The specification ignores a relative path.
    named = environment.get(variable, "")
    return Path(named) if Path(named).is_absolute() else _home() / default


def _home() -> Path:
    try:
        return Path.home()
    except RuntimeError:  # a user that the system does not know, as in containers
        return Path("/")
