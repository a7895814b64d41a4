"""Folders of rosbag2: `metadata.yaml`, and one or several `.mcap` or `.db3` files in its order."""

from __future__ import annotations

from pathlib import Path

from grabbergui.core.errors import UsageError
from grabbergui.core.regular_files import read_bounded
from grabbergui.recording.errors import RecordingError
from grabbergui.recording.file_names import natural
from grabbergui.recording.message_store import MessageStore

METADATA = "metadata.yaml"
_MAX_METADATA = 1 << 24
_SUFFIXES = (".mcap", ".db3")
MOST_FILES = 1000


def bag_files(folder: Path) -> list[Path]:
    """Return the files of a rosbag2 in their order; none if the folder is something else.

    The files that `metadata.yaml` lists come first in its order; without it, all in natural order. Raises
    UsageError, OSError.
    """
    present = [path for path in folder.iterdir() if not path.name.startswith(".") and _is_bag(path)]
    if not present:
        return []
    compressed = [path.name for path in present if path.suffix == ".zstd"]
    if compressed:
        raise UsageError(f"{folder}: {compressed[0]} is compressed as a whole; run `zstd -d` in the folder")
    present.sort(key=natural)
    listed = _listed(folder / METADATA) if (folder / METADATA).exists() else []
    # Up to Foxy the names begin with that of the folder.
    names = [Path(name).name for name in listed]
    missing = [name for name in names if name not in {path.name for path in present}]
    if missing:
        raise UsageError(f"{folder}: {missing[0][:60]}, which {METADATA} lists, is missing")
    files = [folder / name for name in dict.fromkeys(names)] or present
    if len(files) > MOST_FILES:
        raise UsageError(f"{folder} has {len(files)} files; at most {MOST_FILES} are opened at once")
    return files


def _is_bag(path: Path) -> bool:
    return path.suffix in _SUFFIXES or (path.suffix == ".zstd" and Path(path.stem).suffix in _SUFFIXES)


def _listed(metadata: Path) -> list[str]:
    """Return the names of a list in YAML, which rosbag2 always writes a line each."""
    text = read_bounded(metadata, _MAX_METADATA, METADATA).decode("utf-8", "replace")
    lines = iter(text.splitlines())
    names: list[str] = []
    for line in lines:
        if line.strip() == "relative_file_paths:":
            for item in lines:
                if not item.lstrip().startswith("- "):
                    return names
                names.append(item.strip().removeprefix("- ").strip().strip("\"'"))
    return names


def opened(paths: list[Path]) -> list[MessageStore]:
    """Open files in their order. Raises UsageError, RecordingError, OSError."""
    stores: list[MessageStore] = []
    try:
        for number, path in enumerate(paths):
            stores.append(_opened(path, number))
    except BaseException:
        for store in stores:
            store.close()
        raise
    return stores


def _opened(path: Path, number: int) -> MessageStore:
    # Imported on demand, as each kind needs another library.
    if path.suffix == ".db3":
        from grabbergui.recording.db3_file import Db3File

        return Db3File(path, number)
    if path.suffix.lower() == ".mcap":
        from grabbergui.recording.mcap_file import McapFile

        return McapFile(path, number)
    raise RecordingError(f"{path} is no file of a rosbag2")
