"""Opens what lies in folders that every user of the computer can write to: /tmp and /dev/shm.

Another user can put anything there under a name that this program expects: a FIFO, at which a plain `open`
waits for ever, a link to a file of this user, a device. So each path in such a folder is opened here, without
waiting and without following a link, and what was opened is examined by its descriptor: a name may mean
another file a moment later. Libraries that open files there by themselves (Fast DDS, GenApi, LTTng) are
started only after their names have been checked with `foreign`.
"""

from __future__ import annotations

import os
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from grabbergui.core.regular_files import kind_of

MEMORY = Path("/dev/shm")
"Where Fast DDS, GenApi's semaphores and LTTng keep shared memory."

_FLAGS = (
    os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0)
)


def temporary() -> Path:
    """Return the folder of all users' temporary files."""
    return Path(tempfile.gettempdir())


@contextmanager
def opened(path: Path, *, folder: bool = False, of_others: bool = False) -> Iterator[int]:
    """Open a regular file, or a `folder`, for reading; yield its descriptor, which is closed with the block.

    Never waits. Raises PermissionError for anything else, and, unless `of_others`, for what another user
    owns; FileNotFoundError and other OSErrors as `os.open` does.
    """
    if why := _unwanted(
        os.lstat(path), folder=folder, of_others=of_others
    ):  # opening a device may do something
        raise PermissionError(f"{path} is not opened: it is {why}")
    descriptor = os.open(path, _FLAGS)
    try:
        if why := _unwanted(os.fstat(descriptor), folder=folder, of_others=of_others):
            raise PermissionError(f"{path} is not opened: it is {why}")
        yield descriptor
    finally:
        os.close(descriptor)


def foreign(path: Path, *, of_others: bool = False) -> str:
    """Return why a library must not open this path, as "a FIFO" or "another user's"; empty if it may.

    Empty, too, if there is nothing yet. With `of_others` a regular file of another user is permitted.
    """
    try:
        return _unwanted(os.lstat(path), folder=False, of_others=of_others)
    except FileNotFoundError:
        return ""


def _unwanted(state: os.stat_result, *, folder: bool, of_others: bool) -> str:
    if stat.S_IFMT(state.st_mode) != (stat.S_IFDIR if folder else stat.S_IFREG):
        return kind_of(state)
    if not of_others and hasattr(os, "geteuid") and state.st_uid != os.geteuid():
        return "another user's"
    return ""
