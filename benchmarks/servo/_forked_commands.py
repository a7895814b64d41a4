"""Starts `grabbergui` commands as forks of a process that has imported them, which saves seconds for each.

A fork runs the same command line with an environment and an output of its own. `python -m
benchmarks.servo._forked_commands DESCRIPTOR` is the process that forks: it gets requests over a socket.
"""

from __future__ import annotations

import importlib
import json
import os
import re
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

START_S = 60.0
"Longest time until a command says what is waited for."
END_S = 10.0
"Seconds after which a command that does not end is killed."
IMPORTED = (
    "cv2",
    "grabbergui.cli",
    "grabbergui.core.pixel_loops",
    "grabbergui.driver.sim.gige.server",
    "grabbergui.net.yarp.server",
    "grabbergui.servo.cli.servo",
    "grabbergui.servo.cli.servo_robots",
    "grabbergui.servo.cli.simulate_robots",
    "grabbergui.servo.closed_loop",
    "grabbergui.servo.robots.teo_ports",
    "grabbergui.servo.robots.teo_yarp",
    "grabbergui.servo.runner",
)
OF_TIAGO = ("grabbergui.servo.robots.tiago_nodes", "grabbergui.servo.robots.tiago_ros2")
"The same, for which ROS 2 and Pinocchio must be installed."


class Launcher:
    """The process that forks. Any thread; close it."""

    def __init__(self) -> None:
        self._asking = threading.Lock()
        self._door, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        with theirs:
            self._process = subprocess.Popen(
                [sys.executable, "-u", "-m", __name__, str(theirs.fileno())],
                cwd=Path(__file__).parents[2],
                stdin=subprocess.DEVNULL,
                pass_fds=[theirs.fileno()],
                env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
            )

    def start(self, arguments: Sequence[str], environment: dict[str, str], *, first: bool) -> tuple[int, int]:
        """Run a command; return its process id, and the descriptor of its output.

        `first` gives it real-time priority, as a robot's controllers have a computer of their own.
        """
        reads, writes = os.pipe()
        request = json.dumps({"arguments": list(arguments), "environment": environment, "first": first})
        with self._asking:
            try:
                socket.send_fds(self._door, [request.encode()], [writes])
            finally:
                os.close(writes)
            return int(self._door.recv(64)), reads

    def close(self) -> None:
        """End the process; commands that it started go on."""
        self._door.close()
        self._process.wait()


class Command:
    """A command whose lines are read on a thread."""

    def __init__(
        self, launcher: Launcher, arguments: Sequence[str], environment: dict[str, str], *, first: bool
    ) -> None:
        self.lines: list[tuple[float, str]] = []
        "What it said, and when, on the monotonic clock."
        self._pid, output = launcher.start(arguments, environment, first=first)
        self._thread = threading.Thread(target=self._read, args=(output,))
        self._thread.start()

    @property
    def running(self) -> bool:
        """Whether it has not ended."""
        return self._thread.is_alive()

    def said(self, pattern: str) -> re.Match[str] | None:
        """Return the first match of a pattern in its output."""
        return next(filter(None, (re.search(pattern, text) for _, text in list(self.lines))), None)

    def wait_for(self, pattern: str) -> re.Match[str]:
        """Return the first match as soon as there is one. Raises RuntimeError."""
        deadline = time.monotonic() + START_S
        while (found := self.said(pattern)) is None:
            if time.monotonic() > deadline or not self.running:
                raise RuntimeError(f"it never said {pattern!r}: {[text for _, text in self.lines]}")
            time.sleep(0.02)
        return found

    def end(self) -> None:
        """Let it end, without waiting for it; after `END_S` by force."""
        self._signal(signal.SIGTERM)
        threading.Thread(target=self._wait).start()

    def _wait(self) -> None:
        self._thread.join(END_S)
        self._signal(signal.SIGKILL)

    def _signal(self, number: int) -> None:
        if self.running:  # it has its output open, so no other process has its id
            with suppress(ProcessLookupError):
                os.kill(self._pid, number)

    def _read(self, output: int) -> None:
        with open(output, encoding="utf-8", errors="replace") as lines:
            for line in lines:
                self.lines.append((time.monotonic(), line.strip()))


def main(descriptor: int) -> int:
    """Fork for each request; return the exit code of the command in a fork."""
    for name in IMPORTED:
        importlib.import_module(name)
    with suppress(ImportError):
        for name in OF_TIAGO:
            importlib.import_module(name)
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # nobody waits for the forks
    with socket.socket(fileno=descriptor) as door:
        while True:
            text, descriptors, _, _ = socket.recv_fds(door, 65536, 1)
            if not text:
                return 0
            request, (output,) = json.loads(text), descriptors
            pid = os.fork()
            if not pid:
                break
            os.close(output)
            door.send(str(pid).encode())
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    for number in (1, 2):
        os.dup2(output, number)
    os.close(output)
    # Those that it has were opened on other files.
    sys.stdout, sys.stderr = (open(number, "w", buffering=1, closefd=False) for number in (1, 2))  # noqa: SIM115
    if request["first"]:
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(1))
    os.environ.update(request["environment"])
    sys.argv = ["grabbergui", *request["arguments"]]
    from grabbergui.__main__ import main as run

    return run()


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1])))
