"""Large descriptions that were loaded before, kept in the user's cache folder with what GenApi made of them.

Vetting and parsing a description of 3,500 nodes takes a quarter of a second, each time a camera is opened.
Both depend on its text alone, so their results are kept: `XDG_CACHE_HOME/grabbergui/descriptions`, a folder
for each description, named after the SHA-256 of its text and of the versions that vetted and parsed it. A
folder that others can write to is not used, nor an entry that is not as it was written.
"""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import logging
import os
import shutil
import stat
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import genicam

import grabbergui
from grabbergui.core import folders

FORMAT = 1
"To be raised with every change of what vetting refuses or rewrites."
MOST_ENTRIES = 24
"A few megabytes each; beyond that the one that was used longest ago is removed."
PATIENCE = 2.0
"Seconds to wait for another program that loads the same description."

_TEXT, _RESULT, _DIGEST, _LOCK = "description.xml", "result", "digest", "lock"
log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Known:
    """The cached results for one description."""

    text: str
    "The description as GenApi parsed it, vetted and with a comment of its own."
    result_name: str
    "The name that GenApi gave to the file of its result."
    result: bytes


@contextlib.contextmanager
def known(xml: str) -> Iterator[Known | None]:
    """Return the cached results for a description; None if there are none that can be trusted.

    For the length of the block no other program has it, so that GenApi's semaphore of this text can only be
    taken by a process that is gone.
    """
    entry = _folder() / _key(xml)
    with contextlib.ExitStack() as stack:
        found = None
        try:
            _require_private(entry)
            _lock(entry, stack)
            found = _read(entry)
            os.utime(entry)
        except FileNotFoundError:
            pass
        except (OSError, ValueError) as error:
            log.info("the cached results for this description are not used: %s", error)
        yield found


def keep(xml: str, made: Known) -> None:
    """Keep what was made of a description that this process has loaded. Failures are logged."""
    folder = _folder()
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        _require_private(folder)
        entry = folder / _key(xml)
        new = Path(tempfile.mkdtemp(prefix="new-", dir=folder))
        try:
            (new / _TEXT).write_bytes(made.text.encode())
            (new / _RESULT).write_bytes(made.result)
            (new / _DIGEST).write_text(f"{_digest(made)} {made.result_name}")
            (new / _LOCK).touch()
            if entry.exists():  # spoilt, or made by another program meanwhile
                shutil.rmtree(entry)
            new.rename(entry)
        finally:
            shutil.rmtree(new, ignore_errors=True)
        _remove_oldest(folder)
    except OSError as error:
        log.info("a description is not kept: %s", error)


def forget(xml: str) -> None:
    """Remove the cached results for a description: GenApi could not load it."""
    shutil.rmtree(_folder() / _key(xml), ignore_errors=True)


def _folder() -> Path:
    return folders.cache_home() / "grabbergui" / "descriptions"


def _key(xml: str) -> str:
    versions = f"{FORMAT} {grabbergui.__version__} {genicam.__version__}\n"
    return hashlib.sha256((versions + xml).encode()).hexdigest()


def _digest(made: Known) -> str:
    parts = (made.text.encode(), made.result_name.encode(), made.result)
    return hashlib.sha256(b"".join(hashlib.sha256(part).digest() for part in parts)).hexdigest()


def _require_private(folder: Path) -> None:
    status = folder.stat()
    if sys.platform == "win32" or status.st_uid != os.getuid() or stat.S_IMODE(status.st_mode) & 0o022:
        raise PermissionError(f"others can write to {folder}")


def _lock(entry: Path, stack: contextlib.ExitStack) -> None:
    """Lock an entry until the stack is left. The kernel frees the lock of a process that is killed."""
    if sys.platform == "win32":
        raise OSError("Windows has no flock")
    handle = os.open(entry / _LOCK, os.O_RDONLY)
    stack.callback(os.close, handle)
    deadline = time.monotonic() + PATIENCE
    while True:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return
        except BlockingIOError:
            if time.monotonic() > deadline:
                raise
        time.sleep(0.01)


def _read(entry: Path) -> Known:
    digest, _, name = (entry / _DIGEST).read_text().partition(" ")
    found = Known((entry / _TEXT).read_bytes().decode(), name, (entry / _RESULT).read_bytes())
    if digest != _digest(found) or Path(name).name != name:
        raise ValueError(f"{entry} is spoilt")
    return found


def _remove_oldest(folder: Path) -> None:
    by_age = sorted(folder.iterdir(), key=lambda entry: entry.stat().st_mtime, reverse=True)
    for entry in by_age[MOST_ENTRIES:]:
        shutil.rmtree(entry, ignore_errors=True)
