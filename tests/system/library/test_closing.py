"""What a program leaves open: it is closed when nobody refers to it any more, and at the program's end."""

from __future__ import annotations

import gc
import os
import subprocess
import sys
import weakref
from collections.abc import Iterator
from pathlib import Path

import av
import pytest

import grabbergui
from grabbergui.core.errors import AccessDeniedError
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.gige import registers as gev
from grabbergui.driver.sim.gige.server import GigeCamera
from patience import PROGRAM, until

ADDRESS = "127.20.1.7"
FAST = "sim:?width=64&height=48&fps=200&exposure=1000"


@pytest.fixture
def simulated() -> Iterator[GigeCamera]:
    """A camera that waits a minute for the heartbeat of its controller."""
    small = {reg.WIDTH: 64, reg.HEIGHT: 48}
    camera = GigeCamera(ADDRESS, power_on=small)
    camera.control.memory.set(gev.HEARTBEAT_TIMEOUT, 60_000)
    yield camera
    camera.close()


def run(script: str) -> str:
    """Run a program and return what it prints."""
    # Python 3.12 and later warn of each fork, as the library has threads.
    command = [sys.executable, "-W", "ignore:This process:DeprecationWarning", "-c", script]
    done = subprocess.run(command, capture_output=True, text=True, timeout=PROGRAM)
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout


def test_a_program_that_ends_releases_its_camera(simulated: GigeCamera) -> None:
    script = f"import grabbergui\ncamera = grabbergui.open('gige:{ADDRESS}')\nprint(camera.grab().width)"
    for _ in range(2):
        assert run(script) == "64\n"
        assert not simulated.control.controlled


def test_a_camera_that_nobody_refers_to_is_released(simulated: GigeCamera) -> None:
    for _ in range(2):
        camera = grabbergui.open(f"gige:{ADDRESS}")
        camera.grab(ExposureTime=2000.0)
        assert simulated.control.controlled
        del camera
        gc.collect()
    until(lambda: not simulated.control.controlled, "the release")


def test_what_is_made_of_a_camera_keeps_it_open(simulated: GigeCamera, tmp_path: Path) -> None:
    uri = f"gige:{ADDRESS}"
    assert len(list(grabbergui.open(uri).frames(5))) == 5
    gc.collect()
    assert grabbergui.open(uri).files.list()
    gc.collect()
    recording = grabbergui.open(uri).record(tmp_path / "kept.mcap", frames=5)
    gc.collect()
    assert recording.wait().frames == 5
    del recording
    camera = grabbergui.open(uri)
    camera.on("lost", print)
    watched = weakref.ref(camera)
    del camera
    gc.collect()
    assert simulated.control.controlled
    with pytest.raises(AccessDeniedError, match=r"this program controls .* already; close it first"):
        grabbergui.open(uri)
    kept = watched()
    assert kept is not None
    kept.close()


def test_a_second_closing_does_nothing(simulated: GigeCamera) -> None:
    first = grabbergui.open(f"gige:{ADDRESS}")
    first.close()
    with grabbergui.open(f"gige:{ADDRESS}"):
        first.close()
        del first
        gc.collect()
        assert simulated.control.controlled
    assert not simulated.control.controlled


def test_a_recording_is_whole_when_its_program_has_ended(tmp_path: Path) -> None:
    path = tmp_path / "run.mp4"
    script = f"""
import grabbergui, time
recording = grabbergui.open({FAST!r}).record({str(path)!r})
while recording.progress.frames < 40:
    time.sleep(0.01)
"""
    assert run(script) == ""
    with av.open(str(path)) as movie:
        assert sum(1 for _ in movie.decode(video=0)) >= 40


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork processes")
def test_a_forked_process_leaves_the_camera_to_its_parent(simulated: GigeCamera, tmp_path: Path) -> None:
    script = f"""
import gc, multiprocessing, os, sys, grabbergui
camera = grabbergui.open('gige:{ADDRESS}')
recording = camera.record({str(tmp_path / "run.mcap")!r})
child = os.fork()
if not child:
    sys.exit()
os.waitpid(child, 0)
def forget():
    global camera
    camera = None
    gc.collect()
def use():
    for call in (camera.grab, lambda: camera.gain, lambda: list(camera.frames(2)), camera.files.list):
        try:
            call()
        except grabbergui.GrabberError as error:
            assert "is open in the process that this one was forked from" in str(error), error
        else:
            sys.exit("used")
    repr(camera)
users = multiprocessing.get_context("fork").Process(target=use)
users.start()
users.join()
assert users.exitcode == 0
process = multiprocessing.get_context("fork").Process(target=forget)
process.start()
process.join()
camera.exposure_time = 1500
print(camera.grab().complete, recording.progress.ended)
"""
    assert run(script) == "True False\n"


def test_a_process_forked_inside_a_loop_leaves_the_stream_to_its_parent(simulated: GigeCamera) -> None:
    script = f"""
import os, sys, grabbergui
camera = grabbergui.open('gige:{ADDRESS}')
frames = iter(camera.frames())
next(frames)
child = os.fork()
if not child:
    frames.close()
    sys.exit()
os.waitpid(child, 0)
for _ in range(20):  # more than waited for it
    next(frames)
print(camera.streaming)
"""
    assert run(script) == "True\n"


def test_a_camera_whose_closing_is_interrupted_is_closed_later(simulated: GigeCamera) -> None:
    script = f"""
import gc, signal, grabbergui
from grabbergui.driver.genapi.port import RegisterPort

camera = grabbergui.open('gige:{ADDRESS}')
camera.grab()
write = RegisterPort.write

def interrupt(port, address, value):
    RegisterPort.write = write
    signal.raise_signal(signal.SIGINT)
    write(port, address, value)

RegisterPort.write = interrupt
try:
    camera.close()
except KeyboardInterrupt:
    print("interrupted")
del camera
gc.collect()
with grabbergui.open('gige:{ADDRESS}') as camera:
    print(camera.grab().width)
"""
    assert run(script) == "interrupted\n64\n"


def test_a_camera_whose_opening_is_interrupted_at_its_end_is_closed(simulated: GigeCamera) -> None:
    script = f"""
import grabbergui
from grabbergui.library import Camera

make = Camera.__init__

def interrupt(camera, grabber):
    Camera.__init__ = make
    raise KeyboardInterrupt

Camera.__init__ = interrupt
try:
    grabbergui.open('gige:{ADDRESS}')
except KeyboardInterrupt:
    print("interrupted")
with grabbergui.open('gige:{ADDRESS}') as camera:
    print(camera.grab().width)
"""
    assert run(script) == "interrupted\n64\n"
