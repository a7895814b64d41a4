"""Ctrl-C at random moments reaches the program, whatever the library does then."""

from __future__ import annotations

import subprocess
import sys

import pytest

from patience import PROGRAM

COUNT = 40
"10,000 of each kind were sent once, and all arrived: docs/library.md."

SCRIPT = """
import os, random, signal, sys, threading, time
import grabbergui

camera, taken = grabbergui.open("sim:?width=16&height=8&fps=1000&exposure=20"), threading.Event()
ready = threading.Event()


def send():
    chance = random.Random(7)
    ready.wait()
    for number in range(int(sys.argv[2])):
        taken.clear()
        time.sleep(0.001 + chance.random() * 0.008)
        os.kill(os.getpid(), signal.SIGINT)
        if not taken.wait(30):
            print("interrupt", number, "vanished")
            os._exit(1)
    print("all taken")
    sys.stdout.flush()
    os._exit(0)


def use():
    while sys.argv[1] == "frames":
        for frame in camera.frames(5):
            frame.raw()
    while sys.argv[1] == "left loops":
        for frame in camera.frames():
            break
    while sys.argv[1] == "grab":
        camera.grab()
    while sys.argv[1] == "settings":
        camera.exposure_time = camera.gain + 20


threading.Thread(target=send, daemon=True).start()
while True:
    try:
        while True:
            try:
                ready.set()
                use()
            except KeyboardInterrupt:
                taken.set()
    except KeyboardInterrupt:
        taken.set()
"""


@pytest.mark.skipif(sys.platform == "win32", reason="Windows sends a process no SIGINT of its own")
@pytest.mark.parametrize("kind", ["frames", "left loops", "grab", "settings"])
def test_no_interrupt_vanishes(kind: str) -> None:
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, kind, str(COUNT)], capture_output=True, text=True, timeout=PROGRAM
    )
    assert (done.stdout, done.returncode) == ("all taken\n", 0), done.stderr


@pytest.mark.parametrize("left_by", ["break", "error"])
def test_no_python_code_runs_when_a_loop_is_left(left_by: str) -> None:
    """There a KeyboardInterrupt would be lost."""
    script = f"""
import sys, grabbergui
calls = []
with grabbergui.open("sim:?width=16&height=8&fps=1000&exposure=20") as camera:
    frames = camera.frames()
    next(iter(frames))
    def leave():
        for frame in frames:
            sys.setprofile(lambda frame, event, _: calls.append(frame.f_code) if event == "call" else None)
            if {left_by == "break"}:
                break
            1 / 0
    try:
        leave()
    except ZeroDivisionError:
        pass
    sys.setprofile(None)
    print(calls, camera.streaming)
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=PROGRAM)
    assert done.stdout == "[] False\n", done.stderr
