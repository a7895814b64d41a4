"""The application of the simulated TEO, as YARP's own manager reads it."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from patience import PROGRAM

APPLICATION = Path(__file__).parents[3] / "resources/servo/applications/teo-demo.xml"

pytestmark = [
    pytest.mark.yarp,
    pytest.mark.skipif(not shutil.which("yarpmanager-console"), reason="yarpmanager-console is not on PATH"),
]


def test_yarps_manager_reads_the_application(tmp_path):
    done = subprocess.run(
        ["yarpmanager-console", "--application", str(APPLICATION)],
        input="list app\nlist mod\nexit\n",
        capture_output=True,
        text=True,
        timeout=PROGRAM,
        env={**os.environ, "HOME": str(tmp_path), "YARP_CONFIG_HOME": str(tmp_path)},
    )
    assert "TEO_follows_and_reaches_(simulated)" in done.stdout
    assert "[simulate-teo --name /teoSim]" in done.stdout
    assert "[servo --robot teo --remote /teoSim" in done.stdout
    assert "/teoSim/rightArm/CartesianControl/state:o" in done.stdout, "it waits for the robot's ports"
