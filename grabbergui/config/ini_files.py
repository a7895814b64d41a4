"""YARP's `.ini` files: found and read as YARP does.

The dialect has `key value` lines in `[sections]`. A value is the rest of the line after the key, without
surrounding quotes. Lines starting with `//` or `#` are comments. A section may begin with `[group name]`,
which YARP uses for lists of groups; both words are then its name.

A file is looked for in the current folder; then, if there is a context, in `contexts/<context>` of the
configuration home, the data home, and the system's configuration and data folders; then in those folders
themselves. The environment variables are YARP's: YARP_CONFIG_HOME, YARP_DATA_HOME, YARP_CONFIG_DIRS,
YARP_DATA_DIRS (colon-separated).
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from grabbergui.core.errors import UsageError
from grabbergui.core.regular_files import read_bounded

_ENTRY = re.compile(r"([^\s=]+)(?:\s*=\s*|\s+|$)(.*)")
"""`key value`, or `key = value` as in other dialects."""
MAX_INI_BYTES = 1 << 20
"Largest size of a configuration file."


@dataclass
class IniSection:
    """The keys of one section, in order."""

    name: str
    "Empty for the keys before the first section."
    values: dict[str, str] = field(default_factory=dict)


def read_ini(path: Path) -> str:
    """Return the text of a file for `parse_ini`. Raises UsageError, OSError."""
    return read_bounded(path, MAX_INI_BYTES, ".ini file").decode("utf-8", "replace")


def parse_ini(text: str, where: str = "configuration") -> dict[str, IniSection]:
    """Read a file's text. Raises UsageError naming `where` and the line."""
    if len(text) > MAX_INI_BYTES:
        raise UsageError(f"{where}: {len(text)} bytes is too long for a configuration")
    sections = {"": IniSection("")}
    current = sections[""]
    for number, line in enumerate(text.splitlines(), 1):
        line = line.strip()
        if not line or line.startswith(("//", "#", ";")):
            continue
        if line.startswith("["):
            if not line.endswith("]") or not line[1:-1].strip():
                raise UsageError(f"{where}, line {number}: '{line}' is no section; write [name]")
            name = " ".join(line[1:-1].split())
            current = sections.setdefault(name, IniSection(name))
            continue
        match = _ENTRY.fullmatch(line)
        if not match:
            raise UsageError(f"{where}, line {number}: '{line}' has no key; write: key value")
        current.values[match[1]] = _unquoted(match[2])
    return sections


def _unquoted(value: str) -> str:
    if len(value) >= 2 and value[0] == value[-1] and value[0] in "\"'":
        return value[1:-1]
    return value


def find_ini(name: str, context: str = "", environment: Mapping[str, str] = os.environ) -> Path:
    """Return the first file of this name, or an absolute path itself. Raises UsageError with the folders."""
    if Path(name).is_absolute():
        folders = [Path("/")]
    else:
        folders = list(dict.fromkeys(_search_path(context, environment)))
    for folder in folders:
        if (folder / name).is_file():
            return folder / name
    looked = ", ".join(str(folder) for folder in folders)
    raise UsageError(f"there is no configuration file {name}; looked in {looked}")


def _search_path(context: str = "", environment: Mapping[str, str] = os.environ) -> Iterator[Path]:
    """Yield the folders in order; they need not exist."""
    yield Path.cwd()
    config_home, *config_dirs = config_folders(environment)
    homes = [
        config_home,
        _folder(environment, "YARP_DATA_HOME", "XDG_DATA_HOME", ".local/share"),
        *config_dirs,
        *_folders(environment, "YARP_DATA_DIRS", "XDG_DATA_DIRS", "/usr/local/share:/usr/share"),
    ]
    if context:
        yield from (home / "contexts" / context for home in homes)
    yield from homes


def config_folders(environment: Mapping[str, str] = os.environ) -> list[Path]:
    """Return the user's configuration folder, then the system's."""
    home = {"win32": "AppData/Roaming", "darwin": "Library/Preferences"}.get(sys.platform, ".config")
    return [
        _folder(environment, "YARP_CONFIG_HOME", "XDG_CONFIG_HOME", home),
        *_folders(environment, "YARP_CONFIG_DIRS", "XDG_CONFIG_DIRS", "/etc/xdg"),
    ]


def _folder(environment: Mapping[str, str], yarp: str, xdg: str, below_home: str) -> Path:
    if environment.get(yarp):
        return Path(environment[yarp])
    if environment.get(xdg):
        return Path(environment[xdg]) / "yarp"
    return Path(environment.get("HOME") or "/") / below_home / "yarp"


def _folders(environment: Mapping[str, str], yarp: str, xdg: str, default: str) -> list[Path]:
    if environment.get(yarp):
        return [Path(part) for part in environment[yarp].split(":") if part]
    return [Path(part) / "yarp" for part in (environment.get(xdg) or default).split(":") if part]
