"""Where a configuration file is looked for: YARP's search order.

The current folder, then for the context given, `contexts/<context>` below the configuration home, the data
home, and the system's configuration and data folders; then those folders themselves. The environment
variables are YARP's: YARP_CONFIG_HOME, YARP_DATA_HOME, YARP_CONFIG_DIRS, YARP_DATA_DIRS (colon-separated).
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path

from grabbergui.core.errors import UsageError


def search_path(context: str = "", environment: Mapping[str, str] = os.environ) -> Iterator[Path]:
    """The folders in order; they need not exist."""
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
    """The user's folder of configuration, then the system's."""
    home = {"win32": "AppData/Roaming", "darwin": "Library/Preferences"}.get(sys.platform, ".config")
    return [
        _folder(environment, "YARP_CONFIG_HOME", "XDG_CONFIG_HOME", home),
        *_folders(environment, "YARP_CONFIG_DIRS", "XDG_CONFIG_DIRS", "/etc/xdg"),
    ]


def find(name: str, context: str = "", environment: Mapping[str, str] = os.environ) -> Path:
    """The first file of that name; an absolute path is itself. Raises UsageError saying where it looked."""
    if Path(name).is_absolute():
        folders = [Path("/")]
    else:
        folders = list(dict.fromkeys(search_path(context, environment)))
    for folder in folders:
        if (folder / name).is_file():
            return folder / name
    looked = ", ".join(str(folder) for folder in folders)
    raise UsageError(f"there is no configuration file {name}; looked in {looked}")


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
