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
from abc import ABC, abstractmethod
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass
from typing import Any

from grabbergui.core.json_text import to_json
from grabbergui.core.scheduling import lock_memory, run_first
from grabbergui.servo.monitor import Monitor, Observation

KINDS = {
    "yarp stream": "grabbergui.servo.guardian_yarp:FastTcpChannel",
    "yarp request": "grabbergui.servo.guardian_yarp:RequestChannel",
    "tiago": "grabbergui.servo.robots.tiago_channel:TiagoChannel",
}
"""Classes of channels, imported on demand."""

REPEATS = (0.0, 0.05, 0.2, 0.5, 1.0)
"""Seconds after an alarm at which the stop is sent: a command may still be on its way at the first."""
CHECK_S, RETRY_S = 1.0, 0.1
"""Seconds between two checks of a channel that works, and of one that does not."""
FAREWELL_S = 1.0
"""Seconds to wait for answers after the last repeat."""


class Channel(ABC):
    """One way to stop a robot. Used by one thread."""

    name = ""
    "Its port or topic, for messages."

    @abstractmethod
    def prepare(self) -> None:
        """Connect unless connected, and check that a stop would arrive. Raises GrabberError."""

    @abstractmethod
    def stop(self) -> None:
        """Send the stop, and wait for the answer if the protocol has one. Raises GrabberError."""

    @abstractmethod
    def close(self) -> None:
        """Disconnect for good. Never raises."""

    def reset(self) -> None:
        """Drop a connection that failed, so that the next call connects again. Never raises."""
        self.close()


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


class Vigil:
    """Decides when to stop. No I/O: time is an argument, in seconds on any clock."""

    def __init__(self, silence: float) -> None:
        """`silence` is how long heartbeats may stay away while the robot moves, seconds."""
        self.stops = 0
        "Alarms so far."
        self.why = ""
        "Reason of the last."
        self.fault = False
        "Whether the last was a fault of the robot's."
        self.asked_for = 0
        "Number of the last stop that the program requested."
        self._silence = silence
        self._limit = math.inf
        self._repeats: list[float] = []

    @property
    def stopping(self) -> bool:
        """Whether a stop is still to be sent."""
        return bool(self._repeats)

    @property
    def due(self) -> float:
        """When `stop_due` must be called at the latest."""
        return min([self._limit, *self._repeats[:1]])

    def beat(self, now: float, moving: bool, stops: int) -> None:
        """Handle a heartbeat; ignore it if the program does not know of the last stop yet."""
        if stops == self.stops:
            self._limit = now + self._silence if moving else math.inf

    def alarm(self, now: float, why: str, *, fault: bool = False) -> None:
        """Stop now, and repeat it a few times."""
        self.stops += 1
        self.why, self.fault, self._limit = why, fault, math.inf
        self._repeats = [now + seconds for seconds in REPEATS]

    def asked(self, now: float, number: int) -> None:
        """Stop because the program requested it."""
        self.asked_for, self._limit = number, math.inf
        self._repeats = [now, *self._repeats]

    def stop_due(self, now: float) -> bool:
        """Return whether the stop must be sent now."""
        if now >= self._limit:
            self.alarm(now, f"the servo program was silent for {1e3 * self._silence:.0f} ms")
        pending = [moment for moment in self._repeats if moment > now]
        due, self._repeats = len(pending) < len(self._repeats), pending
        return due


class Keeper:
    """Keeps one channel connected and sends the stop there, on a thread of its own. `stop` never waits.

    A stop that fails is tried again until it gets through; `close` gives it one more try.
    """

    def __init__(self, channel: Channel) -> None:
        self.problem = f"{channel.name} is not connected yet"
        "Why a stop would not arrive; empty when it would."
        self._channel = channel
        self._asked = self._done = 0
        self._closing = False
        self._wake = threading.Event()
        self._thread = threading.Thread(target=self._run, name=channel.name, daemon=True)
        self._thread.start()

    @property
    def stopping(self) -> bool:
        """Whether a stop has not been delivered yet."""
        return self._done < self._asked

    def stop(self) -> None:
        """Send the stop as soon as possible."""
        self._asked += 1
        self._wake.set()

    def close(self) -> None:
        """Begin to disconnect; does not wait."""
        self._closing = True
        self._wake.set()

    def join(self, deadline: float) -> None:
        """Wait until it is disconnected, or until a moment on the monotonic clock."""
        self._thread.join(max(0.0, deadline - time.monotonic()))

    def _run(self) -> None:
        closing = False
        while not closing:
            self._wake.clear()
            closing = self._closing  # before `asked`: a stop that was asked for before `close` is still sent
            asked = self._asked
            try:
                if asked > self._done:
                    self._channel.stop()
                    self._done = asked
                elif not closing:
                    self._channel.prepare()
                self.problem = ""
            except Exception as error:  # whatever a network's library raises, the stop must be tried again
                name, text = self._channel.name, str(error)
                self.problem = text if text.startswith(name) else f"{name}: {text}"
                self._channel.reset()
            if not closing:
                self._wake.wait(RETRY_S if self.problem else CHECK_S)
        self._channel.close()


class Guardian:
    """Listens to the servo program and stops the robot."""

    def __init__(self, keepers: list[Keeper], silence: float, lag: float, reports: int) -> None:
        """`reports` is the descriptor that reports are written to; for the others see `Vigil`, `Monitor`."""
        self._keepers = keepers
        self._monitor, self._faulty = Monitor(lag), False
        self._reports = reports
        self._vigil = Vigil(silence)
        self._ready = False

    def run(self, lines: Lines) -> None:
        """Serve until the program quits or ends. If it ends without quitting, stop the robot first."""
        try:
            while not self._obey(lines.read(self._vigil.due)):
                self._act()
        except BaseException as error:
            self._vigil.alarm(time.monotonic(), str(error))
            self._finish()
            if not isinstance(error, (EOFError, SystemExit)):
                raise
        finally:
            for keeper in self._keepers:
                keeper.close()
            deadline = time.monotonic() + FAREWELL_S
            for keeper in self._keepers:
                keeper.join(deadline)

    def _obey(self, messages: list[dict[str, Any]]) -> bool:
        """Handle messages of the program; return whether it quits."""
        for message in messages:
            now = time.monotonic()
            if "quit" in message:
                return True
            if "stop" in message:
                self._vigil.asked(now, message["stop"])
            elif "forget" in message:
                self._monitor.forget()
                self._faulty = False
            elif "seen" in message:
                problem = self._monitor.look(Observation.read(message["seen"]))
                if problem and not self._faulty:  # one alarm until a person resumes
                    self._faulty = True
                    self._vigil.alarm(now, problem, fault=True)
            else:
                self._vigil.beat(now, message["moving"], message["stops"])
            self._act()
            self._report()
        return False

    def _act(self) -> None:
        """Send the stop if it is due; report a new alarm."""
        before = self._vigil.stops
        if self._vigil.stop_due(time.monotonic()):
            for keeper in self._keepers:
                keeper.stop()
        if self._vigil.stops != before:
            self._report()
            _say(self._vigil.why)

    def _report(self) -> None:
        vigil, keepers = self._vigil, self._keepers
        problem = next((keeper.problem for keeper in keepers if keeper.problem), "")
        stopping = vigil.stopping or any(keeper.stopping for keeper in keepers)
        if not problem and not self._ready:
            # Slow imports and discovery are done, and the robot does not move yet.
            self._ready = True
            if refused := "; ".join(filter(None, (run_first(), lock_memory()))):
                _say(f"a stop may come late on a busy machine: {refused}")
        report = GuardianReport(vigil.stops, vigil.why, problem, vigil.asked_for, vigil.fault, stopping)
        with suppress(OSError):  # the program has ended: the next read reports it
            os.write(self._reports, to_json(asdict(report)).encode() + b"\n")

    def _finish(self) -> None:
        """Send the stop and its repeats, then wait for the answers for a limited time."""
        end = time.monotonic() + REPEATS[-1] + FAREWELL_S
        while (now := time.monotonic()) < end:
            self._act()
            if not self._vigil.stopping and not any(keeper.stopping for keeper in self._keepers):
                break
            time.sleep(max(0.0, min(self._vigil.due - now, 0.01)))
        problems = [keeper.problem for keeper in self._keepers if keeper.problem]
        _say(f"{self._vigil.why}: " + ("; ".join(problems) or "the robot was stopped"), FAREWELL_S)


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
    keepers = [Keeper(channel(each)) for each in start["channels"]]
    Guardian(keepers, start["silence"], start["lag"], reports).run(lines)


def _on_terminate(*_: object) -> None:
    raise SystemExit("the guardian was terminated")


def _say(text: str, timeout: float = 0.02) -> None:
    """Print a message; wait no longer than `timeout` seconds for a terminal that takes none (Ctrl-S)."""

    def say() -> None:
        with suppress(OSError):  # the terminal may be gone
            os.write(2, f"grabbergui guardian: {text}\n".encode())

    thread = threading.Thread(target=say, daemon=True)
    thread.start()
    thread.join(timeout)


if __name__ == "__main__":
    main()
