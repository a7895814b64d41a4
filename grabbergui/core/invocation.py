"""How to run this program again, from a shell or as root, for messages and for files of the desktop."""

from __future__ import annotations

import shlex
import shutil
import sys
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
