"""The servo program's end of its guardian: starts it, beats, and knows whether it is well."""

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
from dataclasses import dataclass
from typing import Any

from grabbergui.core.errors import SourceUnavailableError
from grabbergui.servo.guardian import Report

log = logging.getLogger(__name__)

READY_TIMEOUT = 20.0
"Seconds to find and connect every channel; a busy ROS network takes some."
DEAF_S = 0.5
"Seconds without an answer after which the guardian counts as hung."
HICCUP_S = 1.0
"Seconds that this program may have been silent and still go on by itself once the guardian has stopped it."
END_S, HUNG_S = 5.0, 0.1
"Seconds that it may take to end, and those for one that has not answered."
_PERIOD = 0.02


@dataclass(frozen=True)
class Verdict:
    """Whether the robot may move."""

    why_not: str = ""
    "Empty when it may."
    for_good: bool = False
    "Whether only a person may let it move again."


ALLOWED = Verdict()


class Guard:
    """For a robot that rests by itself when this program ends, as one simulated in it does."""

    def beat(self, moving: Callable[[], bool]) -> Verdict:
        """Whether the robot may move."""
        return ALLOWED

    def stop(self) -> None:
        """Nothing else could stop it."""

    def renew(self) -> None:
        """Nothing can have failed."""


class GuardianLink(Guard):
    """One guardian process, started again by `renew` where it has ended. Any thread."""

    def __init__(
        self,
        channels: Sequence[Mapping[str, Any]],
        silence: float,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """See `guardian` for the channels; `silence` is how many seconds without a beat make an alarm."""
        self._start = {"silence": silence, "channels": list(channels)}
        self._silence = silence
        self._clock = clock
        self._lock = threading.Lock()
        self._renewing = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self._report = Report()
        self._rest = b""
        self._failure = ""
        self._hung = False
        self._stops = self._asked = 0
        "Of the guardian's stops, those that are known here; and those that were asked for."
        self._beaten = self._answered = 0.0

    @property
    def pid(self) -> int:
        """Of the process; 0 without one."""
        return self._process.pid if self._process else 0

    def open(self) -> None:
        """Start the process, without waiting for it. Raises SourceUnavailableError."""
        if sys.platform == "win32":  # its pipes can be neither polled nor read without waiting there
            raise SourceUnavailableError("the guardian, without which no robot moves, needs Linux or macOS")
        # A process group of its own: signals to this program's group and its terminal's end spare it.
        environment = os.environ | {"PYTHONSAFEPATH": "1"}
        with self._lock:  # what it is to guard must come before any beat
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
            self._report, self._rest, self._failure, self._hung = Report(), b"", "", False
            self._stops = self._asked = 0
            for pipe in self._pipes():
                os.set_blocking(pipe, False)
            self._beaten = self._clock()
            # It has all the time it needs for its first answer: until then nothing moves.
            self._answered = self._beaten + READY_TIMEOUT
            self._write(self._start)

    def await_ready(self, timeout: float = READY_TIMEOUT) -> None:
        """Wait until it could stop the robot. Raises SourceUnavailableError with the reason if it cannot."""
        deadline = self._clock() + timeout
        while (verdict := self.beat(_resting)) != ALLOWED:
            if self._failure or self._clock() > deadline:
                raise SourceUnavailableError(f"the robot must not move: {verdict.why_not}")
            time.sleep(_PERIOD)

    def renew(self) -> None:
        """Forget what was, as a person wants to go on; start another process where it has ended.

        Several may want to go on at once, but only one starts a process. Raises SourceUnavailableError.
        """
        with self._renewing:
            if self._failure or self._process is None:
                self._end()
                self.open()
            self.await_ready()

    def beat(self, moving: Callable[[], bool]) -> Verdict:
        """Say that this program lives, and whether the robot is `moving`; whether it may. Never waits."""
        with self._lock:
            now = self._clock()
            # First: what it says may make this beat a late one.
            self._read(now)
            gap, self._beaten = now - self._beaten, now
            verdict = self._judged(now, gap)
            self._write({"moving": verdict == ALLOWED and moving(), "stops": self._stops})
            return verdict

    def stop(self) -> None:
        """Let the guardian stop the robot too, on its own connections. Never waits, never raises."""
        with self._lock:
            self._asked += 1
            self._write({"stop": self._asked})

    def close(self) -> None:
        """Let it end; the robot stands still by now, and must not move any more. May be called twice."""
        with self._lock:
            self._write({"quit": True})
            self._failure = self._failure or "the guardian was closed"
        self._end()

    # -- the pipes -------------------------------------------------------------------------------
    def _judged(self, now: float, gap: float) -> Verdict:
        report = self._report
        if gap > DEAF_S:
            self._answered = max(self._answered, now)  # it was not the guardian that was away
        if not self._failure and now - self._answered > DEAF_S:
            self._failure, self._hung = f"the guardian does not answer (process {self.pid})", True
        if self._failure:
            return Verdict(self._failure, for_good=True)
        if report.stops != self._stops:
            self._stops = report.stops
            why = f"the guardian stopped the robot: {report.why}"
            if gap < HICCUP_S:
                log.warning("%s; was this computer busy? it goes on", why)
            return Verdict(why, for_good=gap >= HICCUP_S)
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
            self._report, self._answered = Report(**json.loads(whole[-1])), now
        except (ValueError, TypeError) as error:
            self._failure = f"the guardian (process {self.pid}) sent {whole[-1][:60]!r}: {error}"

    def _write(self, message: Mapping[str, Any]) -> None:
        """Pass a line on; a pipe that is full or broken is noticed by the reader."""
        if self._process is not None:
            with suppress(OSError):
                os.write(self._pipes()[0], json.dumps(message).encode() + b"\n")

    def _pipes(self) -> tuple[int, int]:
        process = self._process
        assert process is not None
        assert process.stdin is not None
        assert process.stdout is not None
        return process.stdin.fileno(), process.stdout.fileno()

    def _end(self) -> None:
        """Close the pipes, which ends a guardian that is well, and see to it that none is left."""
        with self._lock:
            process, self._process = self._process, None
        if process is None:
            return
        for pipe in (process.stdin, process.stdout):
            if pipe is not None:
                pipe.close()
        try:
            process.wait(HUNG_S if self._hung else END_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def _resting() -> bool:
    return False
