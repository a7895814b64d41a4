"""`grabbergui experiment`: the commands that it runs begin in order, and all of them end with it."""

import signal
import subprocess
import sys
from pathlib import Path

import pytest

from grabbergui.cli import EXIT_USAGE, CommandParser
from grabbergui.core.errors import SourceUnavailableError, UsageError
from grabbergui.servo.cli import experiment
from grabbergui.servo.cli.child_command import ChildCommand
from patience import PROGRAM, until

RUN = """
import sys
from grabbergui.cli import CommandParser
from grabbergui.servo.cli import experiment

parser = CommandParser(prog="grabbergui")
experiment.add_commands(parser.add_subparsers())
options = parser.parse_args(["experiment", *sys.argv[1:]])
sys.exit(options.run(options))
"""
"The command, also where the installed program does not know it yet."


@pytest.fixture
def child():
    """Starts a command of this program; ends it after the test."""
    started = []

    def start(*arguments):
        started.append(ChildCommand("child", arguments))
        return started[-1]

    yield start
    for command in started:
        command.end()


def test_a_command_prints_behind_its_name_and_its_exit_code_is_known(child, capsys):
    command = child("diff", "nowhere.json", "sim:")
    until(lambda: command.code is not None, seconds=PROGRAM)
    command.end()
    assert command.code == EXIT_USAGE
    assert capsys.readouterr().out.startswith("child: grabbergui: ")
    with pytest.raises(SourceUnavailableError, match=f"child ended with exit code {EXIT_USAGE}"):
        command.printed("serving ")


def test_a_command_that_runs_on_is_ended(child):
    command = child("yarp-server", "--port", "0")
    until(lambda: command.printed("YARP name server "), seconds=PROGRAM)
    command.end()
    assert command.code == 0


@pytest.mark.parametrize("robots", ["", "teo,teo", "dalek"])
def test_robots_that_there_are_not_are_refused(robots):
    parser = CommandParser(prog="grabbergui")
    experiment.add_commands(parser.add_subparsers())
    with pytest.raises(UsageError, match="write teo, tiago or both"):
        parser.parse_args(["experiment", "--robots", robots])


def children(pid):
    """The processes that a process has started, and those that these have."""
    try:
        found = [int(each) for each in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]
    except FileNotFoundError:
        return []
    return [*found, *(each for child in found for each in children(child))]


def runs(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False


@pytest.mark.parametrize("end", [signal.SIGINT, signal.SIGKILL], ids=["ctrl-c", "killed"])
@pytest.mark.skipif(sys.platform != "linux", reason="only Linux ends the children of a killed process")
def test_no_process_stays_behind(end):
    pytest.importorskip("rclpy")
    command = ["--headless", "--robots", "teo", "--address", "127.0.41.7", "--nameserver", "127.0.0.1:0"]
    run = subprocess.Popen([sys.executable, "-c", RUN, *command], stdout=subprocess.PIPE, text=True)
    try:
        until(lambda: run.stdout.readline().startswith("camera: serving "), seconds=PROGRAM)
        until(lambda: run.stdout.readline().startswith("teo: "), seconds=PROGRAM)
        started = children(run.pid)
        assert len(started) >= 3, "camera, servo and its guardian"
        run.send_signal(end)
        run.communicate(timeout=PROGRAM)
        assert run.returncode == (0 if end == signal.SIGINT else -end)
        until(lambda: not any(map(runs, started)), seconds=PROGRAM)
    finally:
        run.kill()
        run.wait()
