"""A process of its own that stops the robot when the servo program no longer can.

The servo program starts it before the first motion (`guardian_link`) and sends it a heartbeat every 20 ms.
When the program is killed, the pipe ends; when it is frozen, the heartbeats cease. Either way the guardian
sends the stop on connections that it opened beforehand. It also compares what the robot does with what it was
commanded. It imports Qt and numpy only if a channel needs them, so that it starts fast.

Both directions carry lines of JSON. From the servo program, on standard input:

- `{"silence": 0.08, "lag": 0.15, "channels": [{"kind": "yarp stream", …}, …]}`: first, and once; the other
  keys of a channel are the arguments of its class;
- `{"moving": true, "stops": 0}`: a heartbeat. `stops` is the number of the guardian's stops that the program
  knows of, so that a program that was frozen cannot continue as if nothing had happened;
- `{"seen": {…}}`: an `Observation` for its `Monitor`, and `{"forget": true}`: the monitor starts again;
- `{"stop": 3}`: stop now; numbered, so that the guardian can report when it is done;
- `{"quit": true}`: the robot is at rest, end.

To the program, on standard output: a `GuardianReport` after every line and every stop.
"""

from __future__ import annotations

import importlib
import json
import math
import os
import select
import signal
import sys
import threading
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass
from typing import Any

from grabbergui.core.json_text import to_json
from grabbergui.core.scheduling import lock_memory, run_first
from grabbergui.servo.monitor import Monitor, Observation
from grabbergui.servo.stop_channel import Channel, ChannelThread
from grabbergui.servo.stop_scheduler import REPEATS, StopScheduler

KINDS = {
    "yarp stream": "grabbergui.servo.guardian_yarp:FastTcpChannel",
    "yarp request": "grabbergui.servo.guardian_yarp:RequestChannel",
    "tiago": "grabbergui.servo.robots.tiago_channel:TiagoChannel",
}
"""Classes of channels, imported on demand."""

CLOSING_S = 1.0
"""Seconds to wait for answers after the last repeat."""


@dataclass(frozen=True)
class GuardianReport:
    """State of the guardian."""

    stops: int = 0
    "Number of stops that it has decided on itself."
    why: str = ""
    "Reason of the last of them."
    problem: str = "the guardian has not answered yet"
    "Why it could not stop the robot; empty if it could."
    asked: int = 0
    "Number of the last stop that the program requested."
    fault: bool = False
    "Whether the reason is that the robot does not do what it was commanded: only a person may resume it."
    stopping: bool = False
    "Whether a stop is in progress or will be repeated; it would end a motion that begins now."


class Guardian:
    """Listens to the servo program and stops the robot."""

    def __init__(self, threads: list[ChannelThread], silence: float, lag: float, reports: int) -> None:
        """Reports are written to the descriptor `reports`; for the others see `StopScheduler`, `Monitor`."""
        self._threads = threads
        self._monitor, self._faulty = Monitor(lag), False
        self._reports = reports
        self._scheduler = StopScheduler(silence)
        self._ready = False

    def run(self, lines: Lines) -> None:
        """Serve until the program quits or ends. If it ends without quitting, stop the robot first."""
        try:
            while not self._obey(lines.read(self._scheduler.due)):
                self._act()
        except BaseException as error:
            self._scheduler.alarm(time.monotonic(), str(error))
            self._finish()
            if not isinstance(error, (EOFError, SystemExit)):
                raise
        finally:
            for thread in self._threads:
                thread.close()
            deadline = time.monotonic() + CLOSING_S
            for thread in self._threads:
                thread.join(deadline)

    def _obey(self, messages: list[dict[str, Any]]) -> bool:
        """Handle messages of the program; return whether it quits."""
        for message in messages:
            now = time.monotonic()
            if "quit" in message:
                return True
            if "stop" in message:
                self._scheduler.request(now, message["stop"])
            elif "forget" in message:
                self._monitor.forget()
                self._faulty = False
            elif "seen" in message:
                problem = self._monitor.look(Observation.read(message["seen"]))
                if problem and not self._faulty:  # one alarm until a person resumes
                    self._faulty = True
                    self._scheduler.alarm(now, problem, fault=True)
            else:
                self._scheduler.beat(now, message["moving"], message["stops"])
            self._act()
            self._report()
        return False

    def _act(self) -> None:
        """Send the stop if it is due; report a new alarm."""
        before = self._scheduler.stops
        if self._scheduler.stop_due(time.monotonic()):
            for thread in self._threads:
                thread.stop()
        if self._scheduler.stops != before:
            self._report()
            _print_error(self._scheduler.why)

    def _report(self) -> None:
        scheduler, threads = self._scheduler, self._threads
        problem = next((thread.problem for thread in threads if thread.problem), "")
        stopping = scheduler.stopping or any(thread.stopping for thread in threads)
        if not problem and not self._ready:
            # Slow imports and discovery are done, and the robot does not move yet.
            self._ready = True
            if refused := "; ".join(filter(None, (run_first(), lock_memory()))):
                _print_error(f"a stop may come late on a busy machine: {refused}")
        report = GuardianReport(
            scheduler.stops, scheduler.why, problem, scheduler.requested, scheduler.fault, stopping
        )
        with suppress(OSError):  # the program has ended: the next read reports it
            os.write(self._reports, to_json(asdict(report)).encode() + b"\n")

    def _finish(self) -> None:
        """Send the stop and its repeats, then wait for the answers for a limited time."""
        end = time.monotonic() + REPEATS[-1] + CLOSING_S
        while (now := time.monotonic()) < end:
            self._act()
            if not self._scheduler.stopping and not any(thread.stopping for thread in self._threads):
                break
            time.sleep(max(0.0, min(self._scheduler.due - now, 0.01)))
        problems = [thread.problem for thread in self._threads if thread.problem]
        _print_error(f"{self._scheduler.why}: " + ("; ".join(problems) or "the robot was stopped"), CLOSING_S)


class Lines:
    """Messages from the servo program."""

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor
        self._rest = b""
        self._early: list[dict[str, Any]] = []

    def first(self) -> dict[str, Any]:
        """Wait for the first message; others that came along with it are read next. Raises EOFError."""
        while not (messages := self.read(math.inf)):
            pass
        first, *self._early = messages
        return first

    def read(self, until: float) -> list[dict[str, Any]]:
        """Return the messages that have arrived; wait for one until a moment on the monotonic clock at most.

        Raises EOFError at the end. Heartbeats that arrived are read even after the deadline: on a busy
        machine the guardian may be late, not the program.
        """
        if self._early:
            early, self._early = self._early, []
            return early
        wait = None if math.isinf(until) else max(0.0, until - time.monotonic())
        if not select.select([self._descriptor], [], [], wait)[0]:
            return []
        data = os.read(self._descriptor, 65536)
        if not data:
            raise EOFError("the servo program ended without stopping the robot")
        *whole, self._rest = (self._rest + data).split(b"\n")
        return [json.loads(line) for line in whole]


def channel(declared: Mapping[str, Any]) -> Channel:
    """Return the channel declared as `{"kind": …, arguments}`; imports its class."""
    arguments = dict(declared)
    module, _, name = KINDS[arguments.pop("kind")].partition(":")
    made: Channel = getattr(importlib.import_module(module), name)(**arguments)
    return made


def main() -> None:
    """Guard the program that started this process."""
    # Ctrl-C and a closing terminal signal the whole process group; only the servo program handles them.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if sys.platform != "win32":
        signal.signal(signal.SIGHUP, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, _on_terminate)
    # Libraries may print, ROS for instance with RCUTILS_LOGGING_USE_STDOUT. The program expects only reports.
    reports = os.dup(1)
    with suppress(OSError):  # standard error may be closed
        os.dup2(2, 1)
    lines = Lines(sys.stdin.fileno())
    try:
        start = lines.first()
    except EOFError:
        return
    threads = [ChannelThread(channel(each)) for each in start["channels"]]
    Guardian(threads, start["silence"], start["lag"], reports).run(lines)


def _on_terminate(*_: object) -> None:
    raise SystemExit("the guardian was terminated")


def _print_error(text: str, timeout: float = 0.02) -> None:
    """Print a message; wait no longer than `timeout` seconds for a terminal that takes none (Ctrl-S)."""

    def say() -> None:
        with suppress(OSError):  # the terminal may be gone
            os.write(2, f"grabbergui guardian: {text}\n".encode())

    thread = threading.Thread(target=say, daemon=True)
    thread.start()
    thread.join(timeout)


if __name__ == "__main__":
    main()
