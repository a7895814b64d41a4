"""Opens files that users or other programs left, in the one way that cannot hang.

A name may lead to a FIFO, whose opening waits for a writer, to a device such as /dev/zero, which never ends,
or to a folder. Only regular files are opened, without waiting, and read up to a limit. The type is checked
before the opening, as the opening of a device may already act on it, and again on the descriptor, as the name
may have been exchanged meanwhile. In folders of several users, where a link is a danger too, use
`shared_folder`.
"""

from __future__ import annotations

import errno
import os
import stat
from io import BufferedReader
from pathlib import Path

from grabbergui.core.errors import UsageError

_FLAGS = os.O_RDONLY | sum(
    getattr(os, name, 0) for name in ("O_NONBLOCK", "O_NOCTTY", "O_CLOEXEC", "O_BINARY")
)
_KINDS = (
    (stat.S_ISFIFO, "a pipe (FIFO)"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISLNK, "a link"),
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISREG, "a regular file"),
)


def open_regular(path: Path) -> BufferedReader:
    """Open a regular file for reading.

    Raises UsageError for anything else, IsADirectoryError for a folder, OSError.
    """
    _require_regular(path, path.stat())
    descriptor = os.open(path, _FLAGS)
    try:
        _require_regular(path, os.fstat(descriptor))
        return os.fdopen(descriptor, "rb")
    except BaseException:
        os.close(descriptor)
        raise


def check_regular(path: Path) -> None:
    """Raise UsageError unless a path leads to a regular file, OSError; for libraries that open it by name."""
    open_regular(path).close()


def read_bounded(path: Path, most: int, kind: str) -> bytes:
    """Return the content of a regular file of some `kind`.

    Raises UsageError beyond `most` bytes, and as `open_regular` does.
    """
    with open_regular(path) as file:
        content = file.read(most + 1)
    if len(content) > most:
        size = f"{most >> 20} MiB" if most >= 1 << 20 else f"{most >> 10} KiB"
        raise UsageError(f"{path} is too long for a {kind}: larger than {size}")
    return content


def kind_of(status: os.stat_result) -> str:
    """Return what lies at a path that is no regular file, as "a device"."""
    return next((name for matches, name in _KINDS if matches(status.st_mode)), "something else")


def _require_regular(path: Path, status: os.stat_result) -> None:
    if stat.S_ISDIR(status.st_mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if not stat.S_ISREG(status.st_mode):
        raise UsageError(f"{path} is {kind_of(status)}, not a regular file; it is not opened")
