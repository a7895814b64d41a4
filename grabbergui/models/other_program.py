"""Another program that controls a camera: its name, and what of its work ends when it loses control."""

from __future__ import annotations

import os
import re
from contextlib import suppress
from pathlib import Path

from grabbergui.recording.kinds import RecordingKind

_HOLDER = re.compile(r"another application at (\S+?)(?: \((.+?, PID (\d+))\))? controls")
_WRITES = os.O_WRONLY | os.O_RDWR
_SUFFIXES = frozenset(kind.suffix for kind in RecordingKind if kind.suffix)


def holder_name(denied: str) -> str:
    """Return the program, or its computer's address, that a refusal names; empty if it names none."""
    found = _HOLDER.search(denied)
    return (found.group(2) or found.group(1)) if found is not None else ""


def recordings_of(denied: str) -> list[str]:
    """Return the names of the recordings that the program which a refusal names is writing.

    Empty for a program of another computer or user, for a recording in a folder, of which no file stays open,
    and on systems without /proc.
    """
    found = _HOLDER.search(denied)
    if found is None or found.group(3) is None:
        return []
    process, names = Path("/proc", found.group(3)), set()
    with suppress(OSError):
        for link in (process / "fd").iterdir():
            with suppress(OSError, ValueError, IndexError):
                target = link.readlink()
                info = (process / "fdinfo" / link.name).read_text("ascii")
                if _SUFFIXES & {*target.suffixes} and int(info.split("flags:")[1].split()[0], 8) & _WRITES:
                    names.add(target.name)
    return sorted(names)
