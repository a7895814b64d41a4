"""Which other program uses a USB device, as Linux reports it.

The kernel names `usbfs` as the driver of an interface that a program has claimed (`/sys/bus/usb/devices`),
but not the program: that is one which has the device's file open (`/dev/bus/usb/BBB/DDD`). Open files of
other users' programs are only seen by root.
"""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from contextlib import suppress
from functools import lru_cache
from pathlib import Path

ROOT = Path("/")
KEEP = 2.0
"Seconds for which the program that was found is not looked for again: a window searches all the time."
CLAIMED = "usbfs"
"Driver of an interface that a program has claimed."
UNKNOWN = "another program"


def user_of(place: str, bus: int, address: int, root: Path = ROOT) -> str:
    """Return the other program that has claimed an interface of a device: its name and PID.

    `place` is the device's folder in /sys/bus/usb/devices, such as `2-1.4`. Empty if no program has claimed
    one, if this program has, or if that is unknown, as on other systems than Linux.
    """
    return _kept_user(place, bus, address, root, int(time.monotonic() // KEEP))


@lru_cache(maxsize=64)
def _kept_user(place: str, bus: int, address: int, root: Path, period: int) -> str:
    """Return the same program for the whole `period`, a number."""
    if not _is_claimed(place, root):
        return ""
    programs = list(_programs_with(f"/dev/bus/usb/{bus:03}/{address:03}", root))
    if os.getpid() in programs:
        return ""
    return _name_of(programs[0], root) if programs else UNKNOWN


def _is_claimed(place: str, root: Path) -> bool:
    for interface in (root / "sys/bus/usb/devices").glob(f"{place}:*"):
        with suppress(OSError):
            if (interface / "driver").readlink().name == CLAIMED:
                return True
    return False


def _programs_with(file: str, root: Path) -> Iterator[int]:
    """Yield the processes that have a file open."""
    for process in (root / "proc").glob("[0-9]*"):
        with suppress(OSError):  # it has ended, or is another user's
            if any(link.readlink() == Path(file) for link in (process / "fd").iterdir()):
                yield int(process.name)


def _name_of(process: int, root: Path) -> str:
    try:
        name = (root / "proc" / str(process) / "comm").read_text("utf-8", "replace").strip()
    except OSError:
        return UNKNOWN
    return f"{name}, PID {process}"
