"""The keys of a run without a window: Enter stops, r resumes, q ends."""

import os
import pty
import subprocess
import sys
import threading
from types import SimpleNamespace

import pytest

from grabbergui.cli import CommandParser
from grabbergui.core.errors import UsageError
from grabbergui.servo.cli import servo as command
from patience import PATIENCE, PROGRAM, until

LEADER = """
import os
from grabbergui.servo.cli import servo
print("foreground", servo._at_terminal(), flush=True)
child = os.fork()
if child == 0:
    os.setpgid(0, 0)
    print("background", servo._at_terminal(), flush=True)
    os._exit(0)
os.waitpid(child, 0)
print("done", flush=True)
"""


def test_a_background_job_does_not_read_the_keyboard():
    """It was frozen as soon as anything was typed into its terminal, with the robot in motion."""
    child, terminal = pty.fork()
    if child == 0:
        os.execv(sys.executable, [sys.executable, "-c", LEADER])
    said = b""
    try:
        while b"done" not in said:
            said += os.read(terminal, 4096)
    finally:
        os.close(terminal)
        os.waitpid(child, 0)
    assert said.split()[:4] == [b"foreground", b"True", b"background", b"False"]


def test_a_pipe_is_no_keyboard():
    program = "from grabbergui.servo.cli import servo; print(servo._at_terminal())"
    run = subprocess.run([sys.executable, "-c", program], input=b"", capture_output=True, timeout=PROGRAM)
    assert run.stdout.split() == [b"False"]


class Stopped:
    """A runner whose guardian takes long to start again."""

    def __init__(self):
        self.gate, self.started, self.calls = SimpleNamespace(stops=3), threading.Event(), []

    def emergency_stop(self, reason):
        self.gate.stops += 1
        self.calls.append(reason)

    def resume(self, stops):
        assert self.started.wait(PATIENCE)
        why_not = "" if stops == self.gate.stops else "it was stopped again"
        self.calls.append(why_not or "resumed")
        return why_not


@pytest.fixture
def keyboard(monkeypatch):
    """Write lines to it."""
    ours, theirs = os.pipe()
    monkeypatch.setattr(command, "_at_terminal", lambda: True)
    with os.fdopen(ours) as stdin, os.fdopen(theirs, "w", buffering=1) as keys:
        monkeypatch.setattr(sys, "stdin", stdin)
        yield keys


def typed(keyboard, runner, text):
    keyboard.write(text)
    return command._typed(PATIENCE, runner, threading.Event())


def test_the_keys_do_what_the_terminal_says(keyboard):
    runner = Stopped()
    runner.started.set()
    assert typed(keyboard, runner, "R\n") == "r"
    until(lambda: runner.calls == ["resumed"])
    assert typed(keyboard, runner, "  \n") == ""
    assert runner.calls[1:] == ["stopped from the keyboard"]
    assert typed(keyboard, runner, "q\n") == "q"
    assert len(runner.calls) == 2


def test_a_stop_is_not_held_up_by_a_guardian_that_starts_again(keyboard, capsys):
    """The robot moved for a moment: Enter was read only when it had been let to move."""
    runner = Stopped()
    typed(keyboard, runner, "r\n")
    typed(keyboard, runner, "\n")
    assert runner.calls == ["stopped from the keyboard"]
    runner.started.set()
    until(lambda: len(runner.calls) == 2)
    assert runner.calls[1] == "it was stopped again"
    until(lambda: "still stopped: it was stopped again" in capsys.readouterr().out)


@pytest.mark.parametrize(
    ("arguments", "refused"),
    [
        (["--robot", "teo", "--headless"], True),
        (["--robot", "tiago", "--headless"], True),
        (["--robot", "teo", "--headless", "--no-keyboard"], False),
        (["--robot", "teo", "--headless", "--publish"], False),
        (["--robot", "tiago", "--headless", "--publish-ros2"], False),
        (["--robot", "teo", "--headless", "--dry-run"], False),
        (["--robot", "teo"], False),
        (["--headless"], False),
    ],
)
def test_no_real_robot_moves_if_nobody_could_stop_it(monkeypatch, arguments, refused):
    """Enter was the emergency stop although standard input was a pipe: nothing happened."""
    monkeypatch.setattr(sys, "stdin", None)
    parser = CommandParser()
    command.add_commands(parser.add_subparsers(parser_class=CommandParser))
    options = parser.parse_args(["servo", *arguments])
    if refused:
        with pytest.raises(UsageError, match="--no-keyboard"):
            command._check_stop(options)
    else:
        command._check_stop(options)
