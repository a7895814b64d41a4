"""Shared memory of Fast DDS: reasons against using it, who may read it, what killed programs left there.

Fast DDS keeps segments and ports as files in `/dev/shm`, a folder of all users, and opens them by itself and
by fixed names. So this module looks at them before it starts, each through `core.shared_folder`.

The owner of a segment or port holds a lock (flock) on a file `…_el` beside it, readers of a shared port one
on `…_sl`; the kernel ends these locks with the process, however that ends.
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

from grabbergui.core import shared_folder
from grabbergui.core.environment import sudo_command
from grabbergui.core.errors import AccessDeniedError, SourceUnavailableError

YOUNGEST = 10.0
"""Seconds; a younger segment may not be complete and locked yet."""
_FAST_DDS = re.compile(r"(?:sem\.)?(?P<thing>fastdds_(?:[0-9a-f]{16}|port\d+))(?P<part>_el|_sl|_mutex)?")
_LTTNG = re.compile(r"lttng-ust-wait-\d+(?:-(?P<user>\d+))?")
"""Memory in which ROS 2's tracing waits for its daemon; it is opened when rclpy is imported."""
_Identity = tuple[int, int]
"""Device and inode of a file."""


def require_unblocked(folder: Path = shared_folder.MEMORY) -> None:
    """Raise SourceUnavailableError for a FIFO where LTTng opens a file: importing rclpy would never end."""
    if sys.platform == "win32":
        return
    user = str(os.getuid())
    for path in _entries(folder):
        match = _LTTNG.fullmatch(path.name)
        if match and match["user"] in (None, user) and (why := shared_folder.foreign(path, of_others=True)):
            raise SourceUnavailableError(f"ROS 2 cannot start, because {path} is {why}: {_remove_by(path)}")


def irregular(folder: Path = shared_folder.MEMORY) -> str:
    """Return the first path at which Fast DDS would wait for ever, or follow a link, and why; else empty."""
    for path in _entries(folder):
        if _FAST_DDS.fullmatch(path.name) and (why := shared_folder.foreign(path, of_others=True)):
            return f"{path} is {why}; {_remove_by(path)}"
    return ""


def reason_against(folder: Path = shared_folder.MEMORY) -> str:
    """Return why this process must not use shared memory; empty if it may.

    Another user, also root, runs DDS programs: Fast DDS then prefers shared memory, neither user can open the
    other's, and nothing arrives. Or a name that Fast DDS opens is no regular file, or another user's.
    """
    if sys.platform == "win32":
        return ""
    if why := irregular(folder):
        return why
    import fcntl

    for path in _entries(folder):
        match = _FAST_DDS.fullmatch(path.name)
        if not match or not shared_folder.foreign(path):
            continue
        if match["thing"].startswith("fastdds_port"):
            return f"{path} is another user's; {_remove_by(path)}"
        if match["part"] != "_el":
            continue
        try:
            with shared_folder.opened(path, of_others=True) as lock:
                fcntl.flock(lock, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except (BlockingIOError, PermissionError):
            with suppress(FileNotFoundError, KeyError):  # it ends, or the user has no name
                return f"user {path.owner()} runs ROS 2 programs here"
        except FileNotFoundError:
            continue
    return ""


def keep_private() -> None:
    """Let only this user read the segments that this process made; Fast DDS lets all users."""
    if sys.platform == "win32":
        return
    for path, identity in _mappings(Path("/proc/self/maps")):
        with suppress(OSError), shared_folder.opened(path) as file:
            if _identity(os.fstat(file)) == identity:
                os.fchmod(file, 0o600)


def _entries(folder: Path) -> list[Path]:
    try:
        return sorted(folder.iterdir())
    except OSError:  # there is none, or a container forbids it
        return []


def _remove_by(path: Path) -> str:
    return f"remove it: sudo rm {path}"


@dataclass(frozen=True)
class Leftover:
    """A segment or port that no process uses."""

    name: str
    files: tuple[Path, ...]
    "The memory itself, its locks and its semaphore."
    size: int
    "Bytes of memory that it takes."


def leftovers(folder: Path, *, youngest: float = YOUNGEST, own: bool = False) -> list[Leftover]:
    """Return segments that no process uses and this user may remove, by name. `youngest` is in seconds.

    Root may remove those of all users, but with `own` gets only its own.
    """
    if sys.platform == "win32":
        return []
    things: dict[str, list[Path]] = {}
    for path in _entries(folder):
        if match := _FAST_DDS.fullmatch(path.name):
            things.setdefault(match["thing"], []).append(path)
    all_users = os.geteuid() == 0 and not own
    found = []
    mapped: frozenset[_Identity] | None = None
    for name, files in things.items():
        with ExitStack() as stack, suppress(FileNotFoundError):  # its owner may remove it meanwhile
            if any(shared_folder.foreign(path, of_others=all_users) for path in files):
                continue
            states = [path.lstat() for path in files]
            if time.time() - max(state.st_mtime for state in states) >= youngest and _lock(files, stack):
                mapped = _mapped() if mapped is None else mapped  # it takes a while
                if mapped.isdisjoint(map(_identity, states)):
                    found.append(Leftover(name, tuple(files), sum(state.st_blocks * 512 for state in states)))
    return found


def clear(found: Sequence[Leftover]) -> list[Leftover]:
    """Remove the segments that still have no owner; return those removed. Raises AccessDeniedError."""
    mapped = _mapped() if found else frozenset()  # it takes a while
    removed = []
    for leftover in found:
        with ExitStack() as stack, suppress(FileNotFoundError):
            # The locks are held until all is gone, so that no starting program takes it over half removed.
            states = [path.lstat() for path in leftover.files]
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
            lock = stack.enter_context(shared_folder.opened(path, of_others=True))
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except (BlockingIOError, PermissionError):
            return False
    return True


def _mapped() -> frozenset[_Identity]:
    """Return every segment and port that a process uses which we may inspect.

    A port is used by those who send to it too, and these hold no lock.
    """
    return frozenset(
        identity for maps in Path("/proc").glob("[0-9]*/maps") for _, identity in _mappings(maps)
    )


def _mappings(maps: Path) -> Iterator[tuple[Path, _Identity]]:
    """Yield the segments and ports in a process's memory."""
    if sys.platform == "win32":
        return
    with suppress(OSError):  # another user's, or it has ended
        for line in maps.read_text(errors="replace").splitlines():
            if "fastdds_" in line:
                _, _, _, device, inode, path = line.split(maxsplit=5)
                major, minor = (int(part, 16) for part in device.split(":"))
                yield Path(path), (os.makedev(major, minor), int(inode))


def _identity(state: os.stat_result) -> _Identity:
    return state.st_dev, state.st_ino
