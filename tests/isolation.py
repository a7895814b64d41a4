"""The processes of one run of the tests: what keeps them apart, and what they share.

pytest-xdist runs the tests in several workers. Cameras are found by broadcast and at fixed ports (GVCP's
3956, YARP's 10000, ROS's discovery), so tests that run at once would meet each other's cameras; and
they would see each other's shared memory (GenApi's semaphores, DDS). Therefore each worker has a network
namespace with nothing in it but a loopback, and a /dev/shm of its own, which needs Linux and root.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

WORKERS = 6
"""Tests wait more than they compute: four of them leave a fifth of two cores idle."""
WORKER_BYTES = 3 << 30
"""Memory that a worker may need at most."""

WORKER = os.environ.get("PYTEST_XDIST_WORKER")
"The name of this worker; None in the process that began the run."
FIRST_WORKER = WORKER in (None, "gw0")

_FOLDER = "GRABBERGUI_TEST_RUN"
_CLONE_NEWNS, _CLONE_NEWNET = 0x20000, 0x40000000
_MS_REC, _MS_PRIVATE = 0x4000, 0x40000
_SIOCSIFFLAGS = 0x8914
_IFF_UP = 0x1


def workers_allowed() -> int:
    """Return how many workers may run at once, or 0 (one process) where they cannot be kept apart."""
    if sys.platform != "linux":
        return 0
    try:
        separable = subprocess.run(["unshare", "--net", "--mount", "true"], capture_output=True, timeout=60)
    except (OSError, subprocess.TimeoutExpired):
        return 0
    if separable.returncode:
        return 0
    fitting = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") // WORKER_BYTES
    return int(os.environ.get("GRABBERGUI_TEST_WORKERS", max(1, min(WORKERS, fitting))))


def enter_own_namespaces() -> None:
    """Give the calling thread and all that it starts a network and a /dev/shm of its own. Raises OSError."""
    import fcntl

    libc = ctypes.CDLL(None, use_errno=True)

    def mount_memory(options: bytes | None) -> int:
        failed: int = libc.mount(b"tmpfs", b"/dev/shm", b"tmpfs", 0, options)
        return failed

    if (
        libc.unshare(_CLONE_NEWNET | _CLONE_NEWNS)
        or libc.mount(b"none", b"/", None, _MS_REC | _MS_PRIVATE, None)
        # Each ROS node fills 64 MiB: in pages of 4 KiB that takes 60 of the 75 ms that a node costs.
        or (mount_memory(b"huge=within_size") and mount_memory(None))
    ):
        code = ctypes.get_errno()
        raise OSError(code, f"this process may not make namespaces: {os.strerror(code)}")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        fcntl.ioctl(probe, _SIOCSIFFLAGS, struct.pack("16sh22x", b"lo", _IFF_UP))


def sendable(report: Any) -> Any:
    """Return a test's report, of dicts, lists and values, with invalid UTF-8 in its texts escaped."""
    if isinstance(report, str):
        return report if report.isascii() else report.encode("utf-8", "backslashreplace").decode()
    if isinstance(report, dict):
        return {key: sendable(value) for key, value in report.items()}
    if isinstance(report, (list, tuple)):
        return type(report)(map(sendable, report))
    return report


def begin_run() -> None:
    """Make the folder that all workers share, also for caches; they inherit its name."""
    os.environ[_FOLDER] = tempfile.mkdtemp(prefix="grabbergui-tests-")
    os.environ["XDG_CACHE_HOME"] = str(run_folder() / "cache")


def run_folder() -> Path:
    """Return the folder that all processes of this run share."""
    return Path(os.environ[_FOLDER])


@contextlib.contextmanager
def made_once(name: str) -> Iterator[Path | None]:
    """Hold off the other workers while one of them makes something in a folder of `run_folder()`.

    Yields the folder, which is empty, to the first worker; None to all that come after it succeeded.
    """
    folder, made = run_folder() / name, run_folder() / f"{name}.made"
    with made.with_suffix(".lock").open("w") as lock:
        if WORKER:
            import fcntl

            fcntl.flock(lock, fcntl.LOCK_EX)
        if made.exists():
            yield None
            return
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        yield folder
        made.touch()


def start_for_the_run(command: Sequence[str | Path], cwd: Path) -> None:
    """Start a program that may outlive this worker; it ends with the run at the latest.

    It is in the network of the process that began the run: it may have something to fetch.
    """
    outside = ["nsenter", f"--net=/proc/{os.getppid()}/ns/net"] if WORKER else []
    process = subprocess.Popen(
        [*outside, *command], cwd=cwd, stdin=subprocess.DEVNULL, start_new_session=True
    )
    (run_folder() / f"{process.pid}.pid").touch()
    process.returncode = 0  # nobody here waits for it


def end_run() -> None:
    """End the programs that were started for the run, and remove its folder."""
    for started in run_folder().glob("*.pid"):
        with contextlib.suppress(ProcessLookupError):
            os.killpg(int(started.stem), signal.SIGTERM)
    shutil.rmtree(run_folder(), ignore_errors=True)
