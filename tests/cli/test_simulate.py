"""The simulated camera as a process, opened over the wire."""

import signal
import subprocess
import sys

import pytest

from grabbergui import sources
from grabbergui.cli import main
from patience import PATIENCE


@pytest.fixture
def simulated(gvcp_port):
    """A camera on a bad network at 127.0.0.1."""
    command = [sys.executable, "-m", "grabbergui", "simulate", "--gige", "--serial", "WIRE7"]
    command += ["--loss", "2%", "--reorder", "--duplicate", "--camera", "sim:?width=320&height=240&fps=100"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert "WIRE7 is at 127.0.0.1" in process.stdout.readline()
    yield process
    process.kill()
    process.communicate()


def test_every_frame_of_a_bad_network_is_complete(simulated):
    grabber = sources.create("gige:WIRE7?packet_size=1500")
    grabber.open()
    queue = grabber.open_queue(64)
    grabber.start()

    frames = [queue.get(PATIENCE) for _ in range(60)]

    counters = grabber.statistics()
    grabber.close()
    assert all(frame.complete and frame.raw().shape == (240, 320) for frame in frames)
    assert (counters.incomplete, counters.lost) == (0, 0)
    assert counters.packets_resent > 0 and counters.packets_duplicate > 0

    simulated.send_signal(signal.SIGINT)
    assert simulated.wait(PATIENCE) == 0


@pytest.mark.parametrize(
    "arguments", [["--loss", "much"], ["--delay", "-5ms"], ["--camera", "gige:"], ["--camera", "sim:?fps=x"]]
)
def test_what_cannot_be_simulated_is_wrong_usage(capsys, arguments):
    try:
        code = main(["simulate", "--gige", *arguments])
    except SystemExit as error:
        code = error.code

    assert code == 2 and capsys.readouterr().err.strip()
