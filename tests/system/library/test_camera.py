"""`import grabbergui` as a program uses it, on the simulated camera and over the networks."""

from __future__ import annotations

import subprocess
import sys
import time

import pytest

import grabbergui
from patience import PROGRAM

FAST = "sim:?width=64&height=48&fps=200&exposure=1000"


def test_the_library_imports_no_qt() -> None:
    script = f"import sys, grabbergui\nwith grabbergui.open('{FAST}') as c: c.grab()\n"
    script += (
        "print([name for name in sys.modules if name.split('.')[0] in ('PyQt5', 'pyqtgraph', 'superqt')])"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=PROGRAM)
    assert (done.stdout, done.returncode) == ("[]\n", 0), done.stderr


@pytest.mark.parametrize(("given", "found"), [(None, "0"), ("2000", "2000")])
def test_opencv_s_idle_threads_sleep_unless_asked_otherwise(
    given: str | None, found: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    variable = "OPENCV_THREAD_POOL_ACTIVE_WAIT_WORKER"
    monkeypatch.delenv(variable, raising=False)
    if given is not None:
        monkeypatch.setenv(variable, given)
    # It is read when cv2 is loaded, so it must be set before.
    script = f"import os, sys, grabbergui\nprint('cv2' in sys.modules, os.environ['{variable}'])"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=PROGRAM)
    assert done.stdout == f"False {found}\n", done.stderr


def test_a_slow_loop_counts_what_it_missed(camera: grabbergui.Camera) -> None:
    frames = camera.frames(6, depth=2)
    assert frames.dropped == 0
    for _ in frames:
        time.sleep(0.05)
    assert frames.dropped > 0


def test_a_software_trigger_that_another_one_holds_back_names_that_one(camera: grabbergui.Camera) -> None:
    camera["TriggerMode[TriggerSelector=FrameBurstStart]"] = "On"
    with pytest.raises(
        grabbergui.FrameTimeoutError,
        match=r"another trigger, too: set TriggerMode\[TriggerSelector=FrameBurstStart\] to Off",
    ):
        camera.trigger(timeout=0.5)


def test_each_software_trigger_makes_a_frame(camera: grabbergui.Camera) -> None:
    ids = [camera.trigger().frame_id for _ in range(20)]
    assert ids == sorted(set(ids))


def test_discover_finds_what_open_opens() -> None:
    infos = grabbergui.discover(0.2)
    (simulated,) = [info for info in infos if info.uri == "sim:"]
    with grabbergui.open(simulated) as camera:
        assert camera.info.serial == "SIM001"
        assert "SIM001" in repr(camera)
