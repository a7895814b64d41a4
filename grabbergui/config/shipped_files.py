"""Files that come with the program: examples, configurations and descriptions below `resources/`."""

from __future__ import annotations

from pathlib import Path

from grabbergui.core.errors import MissingFileError

_PACKAGE = Path(__file__).parents[1]
_CHECKOUT = (_PACKAGE.parent / "pyproject.toml").is_file()

RESOURCES = _PACKAGE.parent / "resources" if _CHECKOUT else _PACKAGE / "resources"
"""The folder of the files that come with the program, in a checkout or installed."""
MANUAL = _PACKAGE.parent / "docs" if _CHECKOUT else _PACKAGE / "manual"
"""The folder of the manual's pages."""


def find_file(path: Path, what: str = "file") -> Path:
    """Return the file that was named, or the shipped one of that name (`servo/servo.ini`, `servo.ini`).

    The manual writes `resources/servo/servo.ini`; that is found from any folder. Raises MissingFileError.
    """
    if path.exists():
        return path
    parts = path.parts[1:] if path.parts[:1] == ("resources",) else path.parts
    if not path.is_absolute() and parts and ".." not in parts:
        found = [RESOURCES.joinpath(*parts)] if len(parts) > 1 else sorted(RESOURCES.rglob(parts[0]))
        for shipped in found:
            if shipped.is_file():
                return shipped
    raise MissingFileError(f"there is no {what} {path}")


def check_folder_of(path: Path) -> None:
    """Raise MissingFileError unless the folder exists that a new file or folder shall be made in."""
    folder = path.absolute().parent
    if not folder.is_dir():
        raise MissingFileError(f"there is no folder {folder} for {path.name}; make it first")
