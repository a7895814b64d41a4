"""Each kind of window as a process: it shows an image or a message, and ends without a traceback."""

import sys
from pathlib import Path

import pytest
from PyQt5.QtGui import QColor, QImage

from patience import PROGRAM
from window_outcomes import window_outcomes

SMALL = "sim:?width=320&height=240&fps=10"
CASES = [
    # arguments, the text to be seen (or an image), whether it is closed as by its user (or by SIGTERM)
    (("gui", SMALL), "", False),
    (("gui", "file:recording"), "", True),
    (("gui", "gige:127.0.0.9"), "127.0.0.9", True),
    (("gui", "file:missing.mcap"), "There is no recording", False),
    (("serve", SMALL, "--window"), "", True),
    (("calibrate", SMALL, "--window"), "", False),
]


@pytest.mark.timeout(PROGRAM * len(CASES))
@pytest.mark.skipif(sys.platform == "win32", reason="forks, and ends processes by signals")
def test_each_kind_of_window_shows_something_and_ends_cleanly(tmp_path):
    image = QImage(32, 24, QImage.Format.Format_Grayscale8)
    image.fill(QColor("gray"))
    (tmp_path / "recording").mkdir()
    assert image.save(str(tmp_path / "recording" / "1.png"))
    program = Path(__file__).parents[2] / "support" / "each_window.py"
    for arguments, status, said in window_outcomes(program, CASES, tmp_path):
        assert status == 0, f"{arguments}: {said}"
        assert "SHOWN" in said and "Traceback" not in said, f"{arguments}: {said}"
