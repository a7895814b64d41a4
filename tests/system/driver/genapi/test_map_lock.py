"""Ctrl-C while GenApi works, in a program with Python's own handler: KeyboardInterrupt, and no harm."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Iterator

import pytest

from patience import PROGRAM


@pytest.fixture(autouse=True)
def pythons_own_handler() -> Iterator[None]:
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def run(script: str) -> list[str]:
    """Run a program and return the lines that it prints; a crash would be ours otherwise."""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=PROGRAM)
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout.splitlines()


INTERRUPTING = """
import gc, signal, threading, grabbergui
from grabbergui.driver.genapi.port import RegisterPort

def attempt(access, call):
    carry_out = getattr(RegisterPort, access)
    interrupted = threading.Event()

    def interrupt(port, *arguments):
        if not interrupted.is_set() and threading.current_thread() is threading.main_thread():
            interrupted.set()
            signal.raise_signal(signal.SIGINT)
        return carry_out(port, *arguments)

    setattr(RegisterPort, access, interrupt)
    try:
        call()
    except KeyboardInterrupt:
        print("interrupted")
    setattr(RegisterPort, access, carry_out)
    gc.collect()
    print(signal.getsignal(signal.SIGINT) is signal.default_int_handler)
"""


def test_opening_a_camera_can_be_interrupted() -> None:
    script = INTERRUPTING + "attempt('read', lambda: grabbergui.open('sim:'))\n"
    script += "with grabbergui.open('sim:') as camera: print(camera.grab().complete)"
    assert run(script) == ["interrupted", "True", "True"]


def test_a_feature_s_access_is_finished_first() -> None:
    script = INTERRUPTING + "with grabbergui.open('sim:') as camera:\n"
    script += "    attempt('write', lambda: camera.write('Gain', 3))\n"
    script += "    print(camera.gain, camera.grab().complete)"
    assert run(script) == ["interrupted", "True", "3.0 True"]


@pytest.mark.parametrize("built", ["nothing", "all"])
def test_a_node_map_that_cannot_be_finished_does_no_harm(built: str) -> None:
    script = f"""
import gc
from grabbergui import sources
from grabbergui.driver.genapi.node_map import CameraNodeMap

listen = CameraNodeMap._listen

def fail(nodes):
    if {built!r} == "all":
        listen(nodes)
    raise MemoryError

CameraNodeMap._listen = fail
try:
    sources.create("sim:").open()
except MemoryError:
    gc.collect()
    print("alive")
"""
    assert run(script) == ["alive"]
