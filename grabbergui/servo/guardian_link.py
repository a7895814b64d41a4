"""The servo program's end of its guardian: starts the process, sends heartbeats, and checks its health."""

from __future__ import annotations

import json
import logging
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from typing import Any

from grabbergui.core.errors import SourceUnavailableError
from grabbergui.core.json_text import to_json
from grabbergui.servo.guardian import GuardianReport
from grabbergui.servo.monitor import Monitor, Observation

log = logging.getLogger(__name__)

READY_TIMEOUT = 20.0
"Seconds to find and connect every channel: discovery in a busy ROS network is slow."
LATE_S, HUNG_AFTER_S = 0.1, 0.5
"Seconds without an answer after which the robot waits for the guardian, and after which it counts as hung."
LONG_SILENCE_S = 1.0
"Seconds of this program's silence after which only a person may resume a robot that the guardian stopped."
END_S, HUNG_END_S = 5.0, 0.1
"Seconds that the process may take to end, and that a hung one may."
HEARTBEAT_S = 0.02
"Seconds between two heartbeats."


@dataclass(frozen=True)
class Verdict:
    """Whether the robot may move."""

    why_not: str = ""
    "Empty if it may."
    for_good: bool = False
    "Whether only a person may resume."


ALLOWED = Verdict()


class Guard:
    """No guardian, and nobody who compares readings with commands."""

    def observe(self, seen: Observation) -> None:
        """Compare a reading with what was commanded; the next verdict has the outcome."""

    def beat(self, moving: Callable[[], bool]) -> Verdict:
        """Return whether the robot may move."""
        return ALLOWED

    def stop(self) -> None:
        """Do nothing."""

    def renew(self) -> None:
        """Do nothing."""


class LocalGuard(Guard):
    """Only the monitor: for a robot that comes to rest when this program ends, as a simulated one does."""

    def __init__(self, lag: float) -> None:
        """For `lag` see `Monitor`."""
        self._monitor, self._problem = Monitor(lag), ""
        self._looking = threading.Lock()

    def observe(self, seen: Observation) -> None:
        """See Guard."""
        with self._looking:
            self._problem = self._problem or self._monitor.look(seen)

    def beat(self, moving: Callable[[], bool]) -> Verdict:
        """See Guard."""
        return Verdict(self._problem, for_good=bool(self._problem))

    def renew(self) -> None:
        """See Guard."""
        with self._looking:
            self._monitor.forget()
            self._problem = ""


class GuardianLink(Guard):
    """One guardian process; `renew` starts another if it has ended. Any thread."""

    def __init__(
        self,
        channels: Sequence[Mapping[str, Any]],
        silence: float,
        lag: float = 0.15,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """See `guardian` for the channels; after `silence` seconds without a heartbeat it raises an alarm.

        `lag` is that of its `Monitor`.
        """
        self._start = {"silence": silence, "lag": lag, "channels": list(channels)}
        self._silence = silence
        self._clock = clock
        self._lock = threading.Lock()
        self._renewing = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self._report = GuardianReport()
        self._rest = b""
        self._failure = ""
        self._hung = False
        self._stops = self._asked = 0
        "Numbers of the guardian's own stops that are known here, and of those requested from it."
        self._beaten = self._answered = 0.0

    @property
    def pid(self) -> int:
        """The process id; 0 without a process."""
        return self._process.pid if self._process else 0

    def open(self) -> None:
        """Start the process, without waiting for it. Raises SourceUnavailableError."""
        if sys.platform == "win32":  # pipes can be neither polled nor read without waiting there
            raise SourceUnavailableError("the guardian, without which no robot moves, needs Linux or macOS")
        # Detached: signals to this program's group and a closing terminal do not reach it.
        environment = os.environ | {"PYTHONSAFEPATH": "1"}
        with self._lock:  # the channels must be the first line, before any heartbeat
            try:
                self._process = subprocess.Popen(
                    [sys.executable, "-m", "grabbergui.servo.guardian"],
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    start_new_session=True,
                    env=environment,
                )
            except OSError as error:
                raise SourceUnavailableError(f"the guardian cannot be started: {error}") from error
            self._report, self._rest, self._failure, self._hung = GuardianReport(), b"", "", False
            self._stops = self._asked = 0
            for pipe in self._pipes():
                os.set_blocking(pipe, False)
            self._beaten = self._clock()
            # Its first answer may take long: nothing moves until then.
            self._answered = self._beaten + READY_TIMEOUT
            self._write(self._start)

    def await_ready(self, timeout: float = READY_TIMEOUT) -> None:
        """Wait until it could stop the robot. Raises SourceUnavailableError after `timeout` seconds."""
        deadline = self._clock() + timeout
        while (verdict := self.beat(_resting)) != ALLOWED:
            if self._failure or self._clock() > deadline:
                raise SourceUnavailableError(f"the robot must not move: {verdict.why_not}")
            time.sleep(HEARTBEAT_S)

    def renew(self) -> None:
        """Start another process if this one has ended, and wait until it is ready, because a person resumes.

        Of several threads only one starts a process. Raises SourceUnavailableError.
        """
        with self._renewing:
            if self._failure or self._process is None:
                self._end()
                self.open()
            with self._lock:
                self._write({"forget": True})
            self.await_ready()

    def beat(self, moving: Callable[[], bool]) -> Verdict:
        """Send a heartbeat with whether the robot is `moving`; return whether it may. Never waits."""
        with self._lock:
            now = self._clock()
            # First, as the heartbeat must contain the number of stops that the report has.
            self._read(now)
            gap, self._beaten = now - self._beaten, now
            verdict = self._judged(now, gap)
            self._write({"moving": verdict == ALLOWED and moving(), "stops": self._stops})
            return verdict

    def observe(self, seen: Observation) -> None:
        """See Guard. Never waits."""
        with self._lock:
            self._write({"seen": asdict(seen)})

    def stop(self) -> None:
        """Request a stop on the guardian's own connections. Never waits, never raises."""
        with self._lock:
            self._asked += 1
            self._write({"stop": self._asked})

    def close(self) -> None:
        """End the process. The robot must be at rest, and must not move afterwards. May be called twice."""
        with self._lock:
            self._write({"quit": True})
            self._failure = self._failure or "the guardian was closed"
        self._end()

    def _judged(self, now: float, gap: float) -> Verdict:
        report = self._report
        if gap > HUNG_AFTER_S:
            self._answered = max(self._answered, now)  # this program was silent, not the guardian
        if not self._failure and now - self._answered > HUNG_AFTER_S:
            self._failure, self._hung = f"the guardian does not answer (process {self.pid})", True
        if self._failure:
            return Verdict(self._failure, for_good=True)
        if report.stops != self._stops:
            self._stops = report.stops
            why = f"the guardian stopped the robot: {report.why}"
            for_good = report.fault or gap >= LONG_SILENCE_S
            if not for_good:
                log.warning("%s; motion continues (was this computer busy?)", why)
            return Verdict(report.why if report.fault else why, for_good)
        if now - self._answered > LATE_S:
            return Verdict("the guardian is late")
        if report.problem:
            return Verdict(f"the guardian could not stop the robot: {report.problem}", for_good=True)
        if report.stopping or report.asked != self._asked:
            return Verdict("the guardian is stopping the robot")
        return ALLOWED

    def _read(self, now: float) -> None:
        if self._process is None or self._failure:
            return
        try:
            data = os.read(self._pipes()[1], 65536)
        except BlockingIOError:
            return
        if not data:
            self._failure = f"the guardian has ended (process {self.pid})"
            return
        *whole, self._rest = (self._rest + data).split(b"\n")
        if not whole:
            return
        try:
            self._report, self._answered = GuardianReport(**json.loads(whole[-1])), now
        except (ValueError, TypeError) as error:
            self._failure = f"the guardian (process {self.pid}) sent {whole[-1][:60]!r}: {error}"

    def _write(self, message: Mapping[str, Any]) -> None:
        """Write a line; `_read` detects a pipe that is full or broken."""
        if self._process is not None:
            with suppress(OSError):
                os.write(self._pipes()[0], to_json(message).encode() + b"\n")

    def _pipes(self) -> tuple[int, int]:
        process = self._process
        assert process is not None
        assert process.stdin is not None
        assert process.stdout is not None
        return process.stdin.fileno(), process.stdout.fileno()

    def _end(self) -> None:
        """Close the pipes, which ends a healthy guardian, and kill one that does not end."""
        with self._lock:
            process, self._process = self._process, None
        if process is None:
            return
        for pipe in (process.stdin, process.stdout):
            if pipe is not None:
                pipe.close()
        try:
            process.wait(HUNG_END_S if self._hung else END_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def _resting() -> bool:
    return False
