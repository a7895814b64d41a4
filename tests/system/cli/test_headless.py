"""`serve` in an image without the window's libraries."""

import signal
import subprocess
import sys

import pytest

from patience import PROGRAM

QT = ("PyQt5", "pyqtgraph", "superqt")
CODE = f"""
import sys
for name in {QT}:
    sys.modules[name] = None  # importing it fails, as where it is not installed
from grabbergui.cli import main
code = main(sys.argv[1:])
print([name for name in sys.modules if name.startswith({QT}) and sys.modules[name] is not None])
sys.exit(code)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="ended by SIGTERM")
def test_a_camera_is_served_without_qt():
    command = ["serve", "sim:?width=64&height=48", "--yarp", "/headless", "--metrics", "127.0.0.1:0"]
    process = subprocess.Popen(
        [sys.executable, "-c", CODE, *command, "--with-name-server", "--nameserver", "127.0.0.1:0"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        shown = iter(process.stdout.readline, "")
        assert any("serving" in line for line in shown), process.stderr.read()
        process.send_signal(signal.SIGTERM)
        rest, errors = process.communicate(timeout=PROGRAM)
    finally:
        process.kill()
        process.wait()
    assert (process.returncode, rest) == (0, "[]\n"), errors


def test_the_window_says_what_it_lacks():
    done = subprocess.run(
        [sys.executable, "-c", CODE, "sim:", "--offscreen"], capture_output=True, text=True, timeout=PROGRAM
    )
    assert done.returncode == 1
    assert len(done.stderr.splitlines()) == 1 and "the window needs PyQt5" in done.stderr
