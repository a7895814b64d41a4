"""Typed commands, on the simulated camera."""

import subprocess
import sys
import threading

import pytest

from grabbergui import sources
from grabbergui.terminal import Interpreter
from patience import PROGRAM


@pytest.fixture(scope="module")
def grabber():
    grabber = sources.create("sim:?width=64&height=48&fps=100")
    grabber.open()
    yield grabber
    grabber.close()


@pytest.fixture
def terminal(grabber, tmp_path):
    return Interpreter(grabber, folder=tmp_path)


def test_frames_are_grabbed_and_a_value_is_watched(terminal, tmp_path):
    terminal.execute("start")
    assert (
        terminal.execute("grab 3 some").count("saved ") == 3 and len(list((tmp_path / "some").iterdir())) == 3
    )
    terminal.execute("set Gain 2")
    changing = threading.Timer(0.1, terminal.execute, ["set Gain 3"])
    changing.start()
    first, second = terminal.execute("watch Gain 0.5").splitlines()
    changing.join()
    assert "Gain = 2 dB" in first and "Gain = 3 dB" in second
    terminal.execute("stop")


def test_lines_from_a_pipe():
    result = subprocess.run(
        [sys.executable, "-m", "grabbergui", "terminal", "sim:"],
        input="set Gain 3\nget Nonsense\nexit\nget Width\n",
        capture_output=True,
        text=True,
        timeout=PROGRAM,
    )

    assert result.returncode == 1
    assert result.stdout.startswith("Gain = 3 dB") and result.stdout.count("\n") == 1
    assert "no feature Nonsense" in result.stderr
