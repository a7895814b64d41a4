"""Each window of a robot as a process: it shows an image or a question, and ends without a traceback."""

import sys
from pathlib import Path

import pytest

from grabbergui.calibration import camera_info
from grabbergui.cli import EXIT_FAILURE, EXIT_TERMINATED
from grabbergui.core.calibration import Calibration
from patience import PROGRAM
from window_outcomes import window_outcomes

ROBOT = ("--robot", "sim-teo", "--source", "sim:?width=320&height=240&fps=10")
CASES = {
    # arguments, text to be seen (or an image), whether it is closed as by its user (or by SIGTERM): status
    (("hand-eye", *ROBOT, "--field-of-view", "60", "--window"), "", True): EXIT_FAILURE,  # without a result
    (("servo", *ROBOT, "--calibration", "camera.yaml"), "", False): 0,
    (("servo", *ROBOT, "--field-of-view", "60"), "", True): 0,
    (("servo", *ROBOT), "is not calibrated", False): EXIT_TERMINATED,
}


@pytest.mark.timeout(PROGRAM * len(CASES))
@pytest.mark.skipif(sys.platform == "win32", reason="forks, and ends processes by signals")
def test_each_window_shows_something_and_ends_cleanly(tmp_path):
    camera_info.save(Calibration.from_field_of_view(320, 240, 60), tmp_path / "camera.yaml")
    program = Path(__file__).parents[3] / "support/servo/each_robot_window.py"
    outcomes = window_outcomes(program, list(CASES), tmp_path)
    for (arguments, status, said), expected in zip(outcomes, CASES.values(), strict=True):
        assert status == expected, f"{arguments}: {said}"
        assert "SHOWN" in said and "Traceback" not in said, f"{arguments}: {said}"
