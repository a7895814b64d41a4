"""The entry in the desktop's menu with its icon, description, types of files and man page.

They go below a data folder of the XDG base directory specification, the user's own or that of a package.
"""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from grabbergui.core.environment import RESOURCES
from grabbergui.core.errors import UsageError

_SHIPPED = {
    "applications/grabbergui.desktop": "desktop/grabbergui.desktop",
    "icons/hicolor/scalable/apps/grabbergui.svg": "icons/grabbergui.svg",
    "metainfo/grabbergui.metainfo.xml": "desktop/grabbergui.metainfo.xml",
    "mime/packages/grabbergui.xml": "desktop/grabbergui-mime.xml",
    "man/man1/grabbergui.1": "man/grabbergui.1",
}
"""Place below the data folder to the file below `resources/`."""

_REFRESHING = (
    ("applications", "update-desktop-database", "--quiet"),
    ("mime", "update-mime-database"),
    ("icons/hicolor", "gtk-update-icon-cache", "--quiet", "--force", "--ignore-theme-index"),
)
"""Folder below the data folder, and the command that rebuilds its cache."""
_REFRESH_TIME = 60.0
"""Seconds that one of them may take."""


@dataclass(frozen=True)
class DesktopEntry:
    """The program's files in one data folder."""

    data: Path

    def files(self) -> list[Path]:
        """List the files that `install` writes and `remove` removes."""
        return [self.data / place for place in _SHIPPED]

    def install(self, program: Sequence[str]) -> list[Path]:
        """Write the files, with an entry that starts `program`; return them. Raises OSError."""
        for place, shipped in _SHIPPED.items():
            text = (RESOURCES / shipped).read_text("utf-8")
            if place.endswith(".desktop"):
                text = text.replace("Exec=grabbergui ", f"Exec={exec_value(program)} ")
                text = text.replace("\nExec=", f"\nTryExec={program[0]}\nExec=")
            target = self.data / place
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_text(text, "utf-8")
        return self.files()

    def remove(self) -> list[Path]:
        """Remove the files that are there and return them. Raises OSError."""
        removed = [file for file in self.files() if file.exists()]
        for file in removed:
            file.unlink()
        return removed

    def refresh(self) -> None:
        """Rebuild the desktop's caches with those of its tools that are installed."""
        for folder, command, *options in _REFRESHING:
            tool = shutil.which(command)
            place = self.data / folder
            if tool is not None and place.is_dir():
                with suppress(subprocess.TimeoutExpired):  # the files are in place all the same
                    subprocess.run(
                        [tool, *options, str(place)], check=False, capture_output=True, timeout=_REFRESH_TIME
                    )


def exec_value(program: Sequence[str]) -> str:
    """Quote a command as the value of Exec in a desktop entry. Raises UsageError for what cannot be quoted.

    Desktop Entry Specification 1.5, "The Exec key": an argument in double quotes, in it a backslash before
    four characters, that backslash doubled as in any string value, and a percent sign doubled.
    """
    return " ".join(map(_quoted, program))


def _quoted(argument: str) -> str:
    if "=" in argument or not argument.isprintable():
        raise UsageError(f"a desktop entry cannot start {argument!r}; move the environment to another folder")
    argument = argument.replace("%", "%%")
    if not any(sign in argument for sign in " \t\"'\\><~|&;$*?#()`"):
        return argument
    quoted = "".join(f"\\{sign}" if sign in '"`$\\' else sign for sign in argument)
    return '"{}"'.format(quoted.replace("\\", "\\\\"))
