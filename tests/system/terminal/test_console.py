"""The interactive prompt on a terminal of its own: how it is ended."""

import fcntl
import os
import pty
import re
import select
import signal
import subprocess
import sys
import termios
import time

import pytest

from patience import PATIENCE, allowance

SMALL = "sim:?width=64&height=48&fps=2"
READY = r"(?s)camera>.*\x1b\[\?25h"
"""The prompt, and the cursor behind it."""


class Terminal:
    """A process whose controlling terminal is ours to type on."""

    def __init__(self, *arguments):
        self._ours, theirs = pty.openpty()
        self.text = ""
        self.process = subprocess.Popen(
            [sys.executable, "-m", "grabbergui", *arguments],
            stdin=theirs,
            stdout=theirs,
            stderr=theirs,
            start_new_session=True,
            preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0),
            env={**os.environ, "TERM": "xterm", "PROMPT_TOOLKIT_NO_CPR": "1"},
        )
        os.close(theirs)

    def expect(self, pattern, seconds=PATIENCE):
        """Read until the pattern is there; forgets what was read up to its end."""
        deadline = time.monotonic() + seconds
        while not (found := re.search(pattern, self.text)):
            assert time.monotonic() < deadline, self.text
            if select.select([self._ours], [], [], 0.1)[0]:
                self.text += os.read(self._ours, 4096).decode(errors="replace")
        self.text = self.text[found.end() :]

    def type(self, text):
        os.write(self._ours, text.encode())

    def ended_within(self, seconds):
        """The exit code, so soon on a desktop. What it prints is read meanwhile, or it would wait for us."""
        deadline = time.monotonic() + seconds * allowance()
        while self.process.poll() is None and time.monotonic() < deadline:
            if select.select([self._ours], [], [], 0.02)[0]:
                try:
                    os.read(self._ours, 4096)
                except OSError:  # the other side is closed
                    break
        return self.process.wait(max(0.1, deadline - time.monotonic()))

    def close(self):
        self.process.kill()
        self.process.wait()
        os.close(self._ours)


@pytest.fixture
def started():
    """Starts a command that prompts, and ends it."""
    terminals = []

    def started(*command):
        terminals.append(Terminal(*command))
        terminals[-1].expect(READY)
        return terminals[-1]

    yield started
    for terminal in terminals:
        terminal.close()


SERVE, TERMINAL = ("serve", SMALL, "--terminal"), ("terminal", SMALL)


@pytest.mark.parametrize("command", [SERVE, TERMINAL], ids=["serve", "terminal"])
def test_sigterm_ends_the_waiting_prompt_without_a_key(started, command):
    terminal = started(*command)

    terminal.process.send_signal(signal.SIGTERM)

    assert terminal.ended_within(2) == 0


def test_a_line_is_run_and_control_c_ends_the_prompt_that_waits_for_the_next(started):
    terminal = started(*SERVE)
    terminal.type("set Gain 3\r")
    terminal.expect("Gain = 3 dB")
    terminal.expect(READY)

    terminal.type("\x03")

    assert terminal.ended_within(1.5) == 0


@pytest.mark.parametrize(
    ("command", "line"), [(SERVE, "watch Gain 5"), (TERMINAL, "grab 100 FOLDER")], ids=["watch", "grab"]
)
def test_control_c_ends_a_command_that_goes_on(started, tmp_path, command, line):
    terminal = started(*command)
    terminal.type(line.replace("FOLDER", str(tmp_path)) + "\r")
    terminal.expect(r"\x1b\[\?2004l")  # the prompt has given the terminal back

    time.sleep(0.3)  # well into the command; earlier it would end as well
    terminal.type("\x03")

    assert terminal.ended_within(1.5) == 0
