"""Signals that end a server: the first is a wish, one a moment later the same, a later one an order."""

import os
import subprocess
import sys

import av
import pytest

from grabbergui.cli import EXIT_FAILURE
from patience import PATIENCE, until

FAST = "sim:?width=320&height=240&fps=100&exposure=1000"


@pytest.mark.skipif(sys.platform == "win32", reason="it has no such terminals")
def test_a_movie_is_whole_when_its_terminal_is_closed(tmp_path):
    path = tmp_path / "run.mp4"
    ours, theirs = os.openpty()
    command = [sys.executable, "-m", "grabbergui", "record", FAST, "--out", path]
    with subprocess.Popen(
        command, stdin=theirs, stdout=theirs, stderr=theirs, start_new_session=True, preexec_fn=_take_terminal
    ) as program:
        os.close(theirs)
        until(lambda: path.exists() and path.stat().st_size > 10_000, "the recording")
        os.close(ours)  # the kernel sends SIGHUP to who has the terminal
        assert program.wait(PATIENCE) == EXIT_FAILURE, "its last line found no terminal"
    notes = (tmp_path / "run.frames.jsonl").read_text().splitlines()
    with av.open(str(path)) as movie:
        frames = sum(1 for _ in movie.decode(video=0))
    assert frames == sum('"frame_id"' in line for line in notes)


def _take_terminal():
    import fcntl
    import termios

    fcntl.ioctl(0, termios.TIOCSCTTY, 0)
