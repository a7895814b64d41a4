"""Shared memory that Fast DDS, ROS 2's middleware, leaves behind when a program is killed.

Each participant has segments (`fastdds_<16 hex digits>`) and ports (`fastdds_port<number>`) in /dev/shm. The
owner holds a lock (flock) on a file `…_el` beside it, readers of a shared port one on `…_sl`; the kernel ends
these locks with the process, however that ends.
"""

from __future__ import annotations

import os
import re
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from pathlib import Path

from grabbergui.core.environment import shell_command, sudo_command
from grabbergui.core.errors import AccessDeniedError
from grabbergui.doctor import Finding, good, note

FOLDER = Path("/dev/shm")
PROCESSES = Path("/proc")
YOUNGEST = 10.0
"""Seconds; a younger segment may not be complete and locked yet."""
_FILE = re.compile(r"(?:sem\.)?(?P<thing>fastdds_(?:[0-9a-f]{16}|port\d+))(?P<part>_el|_sl|_mutex)?")


@dataclass(frozen=True)
class Leftover:
    """A segment or port that no process uses."""

    name: str
    files: tuple[Path, ...]
    "The memory itself, its locks and its semaphore."
    size: int
    "Bytes of memory that it takes."


def check() -> Iterator[Finding]:
    """Check this machine's shared memory."""
    yield from shared_memory(FOLDER)


def shared_memory(folder: Path) -> Iterator[Finding]:
    """Report the memory that killed programs left behind."""
    found = leftovers(folder)
    if found:
        yield note(
            f"killed ROS 2 programs left {megabytes(found)} in {folder}: {len(found)} segments and ports "
            "of Fast DDS that no process uses",
            shell_command("doctor", "--clear-shared-memory"),
        )
    elif folder.is_dir():
        yield good(f"no killed ROS 2 program left shared memory in {folder}")


def leftovers(folder: Path, *, youngest: float = YOUNGEST) -> list[Leftover]:
    """Return segments that no process uses and this user may remove, by name. `youngest` is in seconds."""
    if sys.platform == "win32":
        return []
    things: dict[str, list[Path]] = {}
    mapped = _mapped()
    with suppress(FileNotFoundError):
        for path in sorted(folder.iterdir()):
            if match := _FILE.fullmatch(path.name):
                things.setdefault(match["thing"], []).append(path)
    found = []
    for name, files in things.items():
        with ExitStack() as stack, suppress(FileNotFoundError):  # its owner may remove it meanwhile
            states = [path.stat() for path in files]
            ours = os.geteuid() in (0, *(state.st_uid for state in states))
            idle = time.time() - max(state.st_mtime for state in states) >= youngest
            if ours and idle and mapped.isdisjoint(map(_identity, states)) and _lock(files, stack):
                found.append(Leftover(name, tuple(files), sum(state.st_blocks * 512 for state in states)))
    return found


def clear(found: Sequence[Leftover]) -> list[Leftover]:
    """Remove the segments that still have no owner; return those removed. Raises AccessDeniedError."""
    mapped = _mapped()
    removed = []
    for leftover in found:
        with ExitStack() as stack, suppress(FileNotFoundError):
            # The locks are held until all is gone, so that no starting program takes it over half removed.
            states = [path.stat() for path in leftover.files]
            if mapped.isdisjoint(map(_identity, states)) and _lock(leftover.files, stack):
                _remove(leftover)
                removed.append(leftover)
    return removed


def megabytes(found: Sequence[Leftover]) -> str:
    """Return the bytes of all leftovers."""
    return f"{sum(leftover.size for leftover in found) / 1e6:.1f} MB"


def _remove(leftover: Leftover) -> None:
    # Locks last: as long as they are there and held, nobody else thinks the name free.
    for path in sorted(leftover.files, key=lambda path: path.name.endswith(("_el", "_sl"))):
        try:
            path.unlink(missing_ok=True)
        except PermissionError as error:
            raise AccessDeniedError(
                f"{path} cannot be removed by this user; run: "
                + sudo_command("doctor", "--clear-shared-memory")
            ) from error


def _lock(files: Sequence[Path], stack: ExitStack) -> bool:
    """Take all locks for as long as `stack` is open; false if a process, in any container, holds one."""
    if sys.platform == "win32":
        return False
    import fcntl

    for path in files:
        if not path.name.endswith(("_el", "_sl")):
            continue
        try:
            file = stack.enter_context(path.open("rb"))
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except (BlockingIOError, PermissionError):
            return False
    return True


def _mapped() -> frozenset[tuple[int, int]]:
    """Return device and inode of every file mapped by a process that we may inspect.

    A port is used by those who send to it too, and these hold no lock.
    """
    found: set[tuple[int, int]] = set()
    if sys.platform == "win32":
        return frozenset(found)
    for maps in PROCESSES.glob("[0-9]*/maps"):
        with suppress(OSError):  # another user's, or it has ended
            for line in maps.read_text(errors="replace").splitlines():
                _, _, _, device, inode, *path = line.split(maxsplit=5)
                if path and "fastdds_" in path[0]:
                    major, minor = (int(part, 16) for part in device.split(":"))
                    found.add((os.makedev(major, minor), int(inode)))
    return frozenset(found)


def _identity(state: os.stat_result) -> tuple[int, int]:
    return state.st_dev, state.st_ino
