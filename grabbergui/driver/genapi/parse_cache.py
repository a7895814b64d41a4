"""Parses a large description in a separate process, which returns the result through GenApi's cache.

GenApi can store parsed descriptions in a folder that an environment variable names (GENICAM_CACHE_V…, GenICam
Package documentation). While that variable is set, each load takes a named semaphore, whose name is a hash of
the XML. A process that is killed during the load leaves the semaphore taken forever, and every later load of
this description waits for it, in this program and in others. Therefore

- the variable is hidden except while a large description is loaded;
- each description gets a unique comment before it is parsed. So its semaphore is unique, no other process
  ever waits for it, and the parsing process may be killed at any time.

Vetting and parsing a description of 3,500 nodes takes a quarter of a second, each time a camera is opened.
Both depend on its text alone, so their results are stored in `XDG_CACHE_HOME/grabbergui/descriptions`, one
folder per description, named after the SHA-256 of its text and of the versions that vetted and parsed it. A
folder that others can write to is ignored, and so is an entry with a wrong digest. Only one program at a time
loads from an entry, so a semaphore found then was left by a process that has ended, and is removed.
"""

from __future__ import annotations

import ctypes
import fcntl
import hashlib
import logging
import os
import re
import secrets
import shutil
import signal
import stat
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, nullcontext, suppress
from dataclasses import dataclass
from pathlib import Path

import genicam

import grabbergui
from grabbergui.core import environment, shared_folder
from grabbergui.core.errors import RemoteProtocolError
from grabbergui.core.shared_folder import MEMORY
from grabbergui.driver.genapi.vetting import vetted

log = logging.getLogger(__name__)

if sys.platform != "linux":
    raise ImportError("the parse cache needs Linux, where GenApi's semaphores are files")

PATIENCE = 30.0
"Seconds to wait for the other process before this one parses the description itself."
MOST_CPU = 10
"CPU seconds to parse one description; the largest known takes 0.2."
ABANDONED = 60.0
"Age in seconds from which the folder of a process that has ended is removed."

_PREFIX = "grabbergui-description-"
_PARSE = f"""
import resource, sys
resource.setrlimit(resource.RLIMIT_CPU, ({MOST_CPU}, {MOST_CPU} + 2))
resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
sys.path.append(sys.argv[1])
from genicam import genapi
genapi.NodeMap().load_xml_from_string(sys.stdin.buffer.read().decode())
"""
_CRASHES = frozenset({signal.SIGSEGV, signal.SIGBUS, signal.SIGFPE, signal.SIGILL, signal.SIGABRT})
FORMAT = 3
"Increase it with every change to what vetting refuses or rewrites."
MOST_ENTRIES = 24
"A few megabytes each; then the least recently used entry is removed."
LOCK_PATIENCE = 2.0
"Seconds to wait for another program that loads the same description."
_TEXT, _RESULT, _DIGEST, _LOCK = "description.xml", "result", "digest", "lock"


class _Variable:
    """The environment variable for the cache of the installed GenApi; its name contains the version.

    The environment must not change while other threads run. So the variable is set once, to a fixed folder
    and with a wrong first letter; switching it on and off changes only that byte.
    """

    def __init__(self) -> None:
        self.folder = shared_folder.temporary() / f"{_PREFIX}{secrets.token_hex(8)}"
        self.name = _variable_name()
        # A vendor's cache would use the semaphores that all programs share.
        os.environ.pop(self.name, None)
        self._entry = ctypes.create_string_buffer(f"{self.name}={self.folder}".encode())
        self._entry[0] = b"_"
        if self.name:
            ctypes.CDLL(None).putenv(self._entry)

    @contextmanager
    def visible(self) -> Iterator[None]:
        self._entry[0] = self.name[0].encode()
        try:
            yield
        finally:
            self._entry[0] = b"_"


def _variable_name() -> str:
    for library in Path(genicam.__file__).parent.glob("*GenApi_*"):
        if version := re.search(r"_v(\d+_\d+)\.", library.name):
            return f"GENICAM_CACHE_V{version[1]}"
    return ""


_cache = _Variable()


@contextmanager
def parsed(xml: str) -> Iterator[str]:
    """Vet a description and parse it in another process; yield the text, which then loads quickly.

    Skips both steps for a cached description. If the other process fails, loading takes its full time. Raises
    RemoteProtocolError for a description that `vetting` refuses, that crashes GenApi, or that takes more than
    `MOST_CPU` seconds. One caller at a time.
    """
    remove_abandoned()
    with _own_folder() as ready, known_description(xml) if ready else nullcontext() as known:
        if known is not None and _handed_over(known):
            try:
                with _cache.visible():
                    yield known.text
            except BaseException:
                forget(xml)
                raise
            return
        with _ParserProcess() if ready else nullcontext() as parser:  # starts up while this process vets
            text = f"{vetted(xml)}<!--{secrets.token_hex(16)}-->"
            filled = parser is not None and parser.parse(text)
        if not filled:
            shutil.rmtree(_cache.folder, ignore_errors=True)  # GenApi fails on a partial result
            yield text
            return
        with _cache.visible():
            yield text
        for result in _cache.folder.glob("0x*.bin"):
            keep(xml, Known(text, result.name, result.read_bytes()))


def _handed_over(known: Known) -> bool:
    """Write a cached result to where GenApi looks for it.

    Returns False if the disk is full, or if another user has made the semaphore of this result, whose name
    everybody could see: GenApi would wait for it.
    """
    result = _cache.folder / known.result_name
    try:
        result.write_bytes(known.result)
        _semaphore_of(result).unlink(missing_ok=True)
    except OSError as error:
        log.info("a description is parsed again: %s", error)
        result.unlink(missing_ok=True)
        return False
    return True


def remove_abandoned() -> None:
    """Remove the folders of processes that were killed while they loaded a description."""
    for folder in shared_folder.temporary().glob(f"{_PREFIX}*"):
        with suppress(OSError), shared_folder.opened(folder, folder=True) as handle:
            if time.time() - os.fstat(handle).st_mtime > ABANDONED:
                fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
                _remove(folder)


@contextmanager
def _own_folder() -> Iterator[bool]:
    """Make the cache's folder, locked while this process lives; yield whether that worked."""
    lock = ExitStack()
    try:
        if not _cache.name or not os.access(MEMORY, os.W_OK):
            raise FileNotFoundError(f"{MEMORY} cannot be written, where GenApi keeps semaphores")
        _cache.folder.mkdir(mode=0o700)
        handle = lock.enter_context(shared_folder.opened(_cache.folder, folder=True))
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        log.info("a large description is parsed by this process: %s", error)
        yield False
    else:
        yield True
    finally:
        lock.close()
        _remove(_cache.folder)


class _ParserProcess:
    """The parsing process, which ends with the block. It imports GenApi before its first request."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        packages = str(Path(genicam.__file__).parents[1])
        try:
            self._process = subprocess.Popen(
                # -S: importing `site` takes longer than everything else.
                [sys.executable, "-I", "-S", "-c", _PARSE, packages],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,  # its end shows that the process has ended; `wait` polls every 50 ms
                stderr=subprocess.DEVNULL,
                env={**os.environ, _cache.name: str(_cache.folder)},
            )
        except OSError as error:
            log.info("a large description is parsed by this process: %s", error)

    def __enter__(self) -> _ParserProcess:
        return self

    def __exit__(self, *_: object) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.communicate()

    def parse(self, text: str) -> bool:
        """Return whether the result was written. Raises RemoteProtocolError."""
        if self._process is None:
            return False
        try:
            self._process.communicate(text.encode(), timeout=PATIENCE)
        except (OSError, subprocess.SubprocessError) as error:
            log.info("a large description is parsed by this process: %s", error)
            return False
        ended_by = -self._process.returncode
        if ended_by in _CRASHES:
            raise RemoteProtocolError(
                "the camera's description cannot be used: GenApi crashes on it "
                f"({signal.Signals(ended_by).name})"
            )
        if ended_by == signal.SIGXCPU:
            raise RemoteProtocolError(
                f"the camera's description cannot be used: GenApi needs more than {MOST_CPU} s to load it"
            )
        return ended_by == 0


def _remove(folder: Path) -> None:
    for result in folder.glob("0x*.bin"):
        with suppress(OSError, ValueError):
            _semaphore_of(result).unlink(missing_ok=True)
    shutil.rmtree(folder, ignore_errors=True)


def _semaphore_of(result: Path) -> Path:
    """Return the semaphore of a file in the cache (GenApi 3.5: CGlobalLock::HashSemName)."""
    content = int.from_bytes(bytes.fromhex(result.stem[2:10]), "little")
    name = f"GenICam_XML_{content}"
    digest = 5381
    for letter in name.encode():
        digest = (digest * 33 ^ letter) & 0xFFFF_FFFF_FFFF_FFFF
    return MEMORY / f"sem.{len(name):02X}{digest:x}{name[:11]}"


@dataclass(frozen=True)
class Known:
    """The cached results for one description."""

    text: str
    "The description as GenApi parsed it: vetted, with its unique comment."
    result_name: str
    "The name that GenApi gave to the file of its result."
    result: bytes


@contextmanager
def known_description(xml: str) -> Iterator[Known | None]:
    """Yield the cached results for a description; None if there are none that can be trusted.

    No other program uses the entry during the block, so GenApi's semaphore of this text can only be taken by
    a process that has ended.
    """
    entry = _entries() / _key(xml)
    with ExitStack() as stack:
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
    """Keep the parsed form of a description that this process has loaded. Failures are logged."""
    folder = _entries()
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
            if entry.exists():  # damaged, or just made by another program
                shutil.rmtree(entry)
            new.rename(entry)
        finally:
            shutil.rmtree(new, ignore_errors=True)
        _remove_oldest(folder)
    except OSError as error:
        log.info("a description is not kept: %s", error)


def forget(xml: str) -> None:
    """Remove the cached results for a description that GenApi could not load."""
    shutil.rmtree(_entries() / _key(xml), ignore_errors=True)


def _entries() -> Path:
    return environment.cache_home() / "grabbergui" / "descriptions"


def _key(xml: str) -> str:
    versions = f"{FORMAT} {grabbergui.__version__} {genicam.__version__}\n"
    return hashlib.sha256((versions + xml).encode()).hexdigest()


def _digest(made: Known) -> str:
    parts = (made.text.encode(), made.result_name.encode(), made.result)
    return hashlib.sha256(b"".join(hashlib.sha256(part).digest() for part in parts)).hexdigest()


def _require_private(folder: Path) -> None:
    status = folder.stat()
    if status.st_uid != os.getuid() or stat.S_IMODE(status.st_mode) & 0o022:
        raise PermissionError(f"others can write to {folder}")


def _lock(entry: Path, stack: ExitStack) -> None:
    """Lock an entry until the stack is left. The kernel frees the lock of a process that is killed."""
    handle = os.open(entry / _LOCK, os.O_RDONLY)
    stack.callback(os.close, handle)
    deadline = time.monotonic() + LOCK_PATIENCE
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
        raise ValueError(f"{entry} is damaged")
    return found


def _remove_oldest(folder: Path) -> None:
    by_age = sorted(folder.iterdir(), key=lambda entry: entry.stat().st_mtime, reverse=True)
    for entry in by_age[MOST_ENTRIES:]:
        shutil.rmtree(entry, ignore_errors=True)
