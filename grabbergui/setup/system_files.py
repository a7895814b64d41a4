"""Files that the program adds to the desktop and to the system.

The entry in the desktop's menu with its icon, description, types of files and man page goes below a data
folder of the XDG base directory specification, the user's own or that of a package. The udev rule lets users
open USB3 Vision cameras.
"""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from grabbergui.core.environment import RESOURCES, sudo_command
from grabbergui.core.errors import AccessDeniedError, UsageError

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


UDEV_RULE_NAME = "70-grabbergui-u3v.rules"
UDEV_RULE = RESOURCES / "udev" / UDEV_RULE_NAME
UDEV_RULES = Path("/etc/udev/rules.d")


def installed_udev_rule(
    folder: Path = UDEV_RULES, packaged: Path = Path("/usr/lib/udev/rules.d")
) -> Path | None:
    """Return the installed rule, of this user's system or of a package; None without one."""
    for place in (folder / UDEV_RULE_NAME, packaged / UDEV_RULE_NAME):
        if place.is_file():
            return place
    return None


def install_udev_rule(folder: Path = UDEV_RULES) -> Path:
    """Write the rule and let udev read it; return its path. Raises AccessDeniedError."""
    target = folder / UDEV_RULE_NAME
    try:
        folder.mkdir(parents=True, exist_ok=True)
        target.write_text(UDEV_RULE.read_text("utf-8"), "utf-8")
    except PermissionError as error:
        raise AccessDeniedError(
            f"{target} cannot be written by this user; run: {sudo_command('setup', 'udev')}"
        ) from error
    _reload_udev()
    return target


def remove_udev_rule(folder: Path = UDEV_RULES) -> Path | None:
    """Remove the rule and let udev know; return where it was, None where there was none.

    Raises AccessDeniedError.
    """
    target = folder / UDEV_RULE_NAME
    try:
        target.unlink()
    except FileNotFoundError:
        return None
    except PermissionError as error:
        raise AccessDeniedError(
            f"{target} cannot be removed by this user; run: {sudo_command('setup', 'udev', '--remove')}"
        ) from error
    _reload_udev()
    return target


def _reload_udev() -> None:
    udevadm = shutil.which("udevadm")
    if udevadm is not None:
        for arguments in (["control", "--reload"], ["trigger", "--subsystem-match=usb"]):
            # A container has no udev to notify; the rule is in place all the same.
            subprocess.run([udevadm, *arguments], check=False, capture_output=True, timeout=10)
