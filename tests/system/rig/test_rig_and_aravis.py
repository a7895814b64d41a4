"""Aravis opens each camera of a rig alone, before the rig, and after it as it was set before."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from grabbergui.cli import main
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.gige.server import GigeCamera
from grabbergui.rig import rig_file
from grabbergui.rig.rig_file import CameraEntry, RigEntry, TriggerEntry
from patience import PATIENCE

NET = f"127.91.{os.getpid() % 250 + 1}"
"Network of this test run alone: others may run at the same time."
NAMES = ("left", "right")
pytestmark = pytest.mark.skipif(
    not (shutil.which("arv-tool-0.8") and shutil.which("arv-camera-test-0.8")),
    reason="the programs of Aravis are not installed",
)


@pytest.fixture
def cameras() -> Iterator[list[str]]:
    small = {reg.WIDTH: 320, reg.HEIGHT: 240, reg.EXPOSURE_TIME: 2000.0, reg.FRAME_RATE: 25.0}
    started = [GigeCamera(f"{NET}.{number}", power_on=small) for number in (1, 2)]
    yield [camera.address for camera in started]
    for camera in started:
        camera.close()


def settings_of(address: str) -> str:
    names = ("TriggerMode", "ExposureTime", "AcquisitionFrameRate", "Gain")
    done = subprocess.run(
        ["arv-tool-0.8", "-a", address, "control", *names], capture_output=True, text=True, timeout=PATIENCE
    )
    assert not done.returncode, done.stderr + done.stdout
    return done.stdout


def test_each_camera_is_opened_alone(
    cameras: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = [settings_of(address) for address in cameras]
    assert all("TriggerMode = Off" in text for text in before)
    file = tmp_path / "stereo.yaml"
    rig = RigEntry(
        {
            name: CameraEntry(f"gige:{address}", {"ExposureTime": 3000, "Gain": 2})
            for name, address in zip(NAMES, cameras, strict=True)
        },
        trigger=TriggerEntry("action", 10),
    )
    rig_file.write(file, rig)
    main(["rig", "check", str(file), "-t", "1", "--json"])
    assert '"complete"' in capsys.readouterr().out
    assert [settings_of(address) for address in cameras] == before
    for address in cameras:
        done = subprocess.run(
            ["arv-camera-test-0.8", "-n", address, "--duration=2"],
            capture_output=True,
            text=True,
            timeout=PATIENCE,
        )
        assert "n_completed_buffers" in done.stdout, done.stdout + done.stderr
        completed = next(line for line in done.stdout.splitlines() if "n_completed_buffers" in line)
        assert int(completed.split("=")[1]) >= 10
