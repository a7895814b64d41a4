"""Names of a recording's files: their order, and the notes beside one."""

from __future__ import annotations

import re
from pathlib import Path


def natural(path: Path) -> list[tuple[int, int, str]]:
    """Return a key that sorts names as people count: `frame_2.png` before `frame_10.png`."""
    parts = re.split(r"([0-9]{1,18})", path.name)
    return [(0, int(part), "") if part.isascii() and part.isdigit() else (1, 0, part) for part in parts]


def notes_beside(path: Path) -> Path:
    """Return the file with the notes of a file: `movie.frames.jsonl` beside `movie.mp4`."""
    return path.with_name(path.stem + ".frames.jsonl")
