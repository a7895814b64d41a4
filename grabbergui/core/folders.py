"""The folders of the XDG base directory specification, as this user has set them."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path


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
