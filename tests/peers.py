"""Starts and stops the simulated cameras of other projects.

Both listen on UDP port 3956, so a lock between processes lets one test at a time have it.
"""

from __future__ import annotations

import contextlib
import shutil
import socket
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import pytest

import isolation
from patience import PATIENCE

ARAVIS_PROGRAM = "arv-fake-gv-camera-0.8"
ADDRESS = "127.0.0.1"
GVCP_PORT = 3956
DISCOVERY = bytes.fromhex("420100020000ffff")
LOCK_WAIT = 45.0
"Seconds that another test run may hold the port."


@dataclass
class AravisCamera:
    """Aravis's fake camera in a process of its own: no resend, single-register reads, old feature names."""

    process: subprocess.Popen[bytes]
    serial: str
    address: str = ADDRESS

    def kill(self) -> None:
        """Kill the camera, which looks like a pulled cable."""
        self.process.kill()
        self.process.wait(PATIENCE)


@pytest.fixture
def gvcp_port() -> Iterator[None]:
    """Hold the lock for UDP port 3956 of 127.0.0.1."""
    with _port_lock():
        yield


@pytest.fixture
def start_aravis(gvcp_port: None) -> Iterator[Callable[..., AravisCamera]]:
    """Starts `arv-fake-gv-camera` with options, as in `start_aravis("-r", "20", serial="GV02")`."""
    program = shutil.which(ARAVIS_PROGRAM)
    if program is None:
        pytest.skip(f"{ARAVIS_PROGRAM} is not installed (Debian: aravis-tools-cli)")
    started: list[AravisCamera] = []

    def start(*options: str, serial: str = "GV01") -> AravisCamera:
        process = subprocess.Popen(
            [program, "-i", ADDRESS, "-s", serial, *options],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        camera = AravisCamera(process, serial)
        started.append(camera)
        _await_answer(lambda: process.poll() is None)
        return camera

    try:
        yield start
    finally:
        for camera in started:
            camera.kill()


@pytest.fixture
def aravis_camera(start_aravis: Callable[..., AravisCamera]) -> AravisCamera:
    """Aravis's fake camera at 127.0.0.1, serial GV01, which loses no packet."""
    return start_aravis()


@pytest.fixture
def start_viva(gvcp_port: None) -> Iterator[Callable[..., Any]]:
    """Starts `viva_genicam.testing.FakeGigeCamera` with its arguments, e.g. `drop_packets=[(1, 3)]`."""
    testing = pytest.importorskip("viva_genicam.testing")
    with contextlib.ExitStack() as stack:

        def start(**arguments: Any) -> Any:
            camera = stack.enter_context(testing.FakeGigeCamera(**arguments))
            _await_answer(lambda: True)
            return camera

        yield start


@pytest.fixture
def viva_camera(start_viva: Callable[..., Any]) -> Any:
    """viva-genicam's fake camera at 127.0.0.1, 640x480 Mono8, with packet resend."""
    return start_viva()


@contextlib.contextmanager
def _port_lock() -> Iterator[None]:
    if isolation.WORKER:  # in a network of its own
        yield
        return
    fcntl = pytest.importorskip("fcntl")
    path = Path(tempfile.gettempdir()) / "grabbergui-test-gvcp.lock"
    with path.open("a") as lock:
        deadline = time.monotonic() + LOCK_WAIT
        while not _locked(fcntl, lock):
            if time.monotonic() > deadline:
                pytest.fail(f"another test run holds {path} for more than {LOCK_WAIT:g} s")
            time.sleep(0.05)
        yield


def _locked(fcntl: Any, lock: IO[str]) -> bool:
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def _await_answer(alive: Callable[[], bool]) -> None:
    """Wait until something answers a DISCOVERY at the port."""
    deadline = time.monotonic() + PATIENCE
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as asker:
        asker.settimeout(0.05)
        while time.monotonic() < deadline and alive():
            with contextlib.suppress(OSError):
                asker.sendto(DISCOVERY, (ADDRESS, GVCP_PORT))
                if asker.recv(2048)[2:4] == b"\0\3":
                    return
    pytest.fail(f"no camera came up at {ADDRESS}:{GVCP_PORT}; is another program on that port?")
