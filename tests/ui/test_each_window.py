"""Each kind of window as a process: it shows an image or a message, and ends without a traceback."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from PyQt5.QtGui import QColor, QImage

from grabbergui.calibration import camera_info
from grabbergui.cli import EXIT_FAILURE, EXIT_TERMINATED
from grabbergui.core.calibration import Calibration
from patience import PROGRAM

SMALL = "sim:?width=320&height=240&fps=10"
QUESTION = "is not calibrated"
ROBOT = ("--robot", "sim-teo", "--source", SMALL)
CASES = [
    # arguments, the text to be seen (or an image), whether it is closed as by its user (or by SIGTERM)
    (("gui", SMALL), "", False),
    (("gui", "file:recording"), "", True),
    (("gui", "gige:127.0.0.9"), "127.0.0.9", True),
    (("gui", "file:missing.mcap"), "There is no recording", False),
    (("serve", SMALL, "--window"), "", True),
    (("calibrate", SMALL, "--window"), "", False),
    (("hand-eye", *ROBOT, "--field-of-view", "60", "--window"), "", True),
    (("servo", *ROBOT, "--calibration", "camera.yaml"), "", False),
    (("servo", *ROBOT, "--field-of-view", "60"), "", True),
    (("servo", *ROBOT), QUESTION, False),
]


@pytest.mark.skipif(sys.platform == "win32", reason="forks, and ends processes by signals")
def test_each_kind_of_window_shows_something_and_ends_cleanly(tmp_path):
    camera_info.save(Calibration.from_field_of_view(320, 240, 60), tmp_path / "camera.yaml")
    image = QImage(32, 24, QImage.Format.Format_Grayscale8)
    image.fill(QColor("gray"))
    (tmp_path / "recording").mkdir()
    assert image.save(str(tmp_path / "recording" / "1.png"))
    own = {"HOME": tmp_path, "XDG_RUNTIME_DIR": tmp_path, "PYTHONPATH": os.pathsep.join(sys.path)}
    program = subprocess.run(
        [sys.executable, str(Path(__file__).with_name("each_window.py"))],
        input=json.dumps(CASES),
        stdout=subprocess.PIPE,
        text=True,
        timeout=PROGRAM,
        cwd=tmp_path,
        env=os.environ | own,
    )
    assert program.returncode == 0
    outcomes = [json.loads(line) for line in program.stdout.splitlines() if line.startswith("[")]
    for (arguments, wanted, _), (status, said) in zip(CASES, outcomes, strict=True):
        expected = EXIT_TERMINATED if wanted == QUESTION else 0
        if arguments[0] == "hand-eye":
            expected = EXIT_FAILURE  # closed without a result
        assert status == expected, f"{arguments}: {said}"
        assert "SHOWN" in said and "Traceback" not in said, f"{arguments}: {said}"
