"""The servo loop's connection to a window in another process, which receives reports and sends requests.

A window paints for a quarter of the time, mostly with Python's global lock. In the loop's process that would
delay commands, most of all on a busy computer, which may preempt the painting thread while it holds the lock.
`RunnerServer` is the loop's end, `RunnerProxy` the window's, with the interface of a `Runner`. Two pipes
carry pickles: `ProxyReport`s one way, `ProxyRequest`s the other.
"""

from __future__ import annotations

import itertools
import logging
import pickle
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum
from functools import partial
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray
from psygnal import Signal

from grabbergui.calibration.calibration_choice import CalibrationFor
from grabbergui.calibration.geometry import Pose, Vector
from grabbergui.core.calibration import Calibration
from grabbergui.core.errors import GrabberError, SourceUnavailableError
from grabbergui.core.frame import Frame
from grabbergui.servo.config import Config
from grabbergui.servo.loop import ControlCycle, Moment
from grabbergui.servo.robots.robot import RobotState
from grabbergui.servo.runner import Runner

log = logging.getLogger(__name__)

PERIOD = 0.04
"Seconds between two reports."
HEARTBEAT_PERIOD = 0.05
"Seconds between two heartbeats of the window."
HEARTBEAT_LATE, HEARTBEAT_TIMEOUT = 0.2, 2.0
"""Seconds without a heartbeat, when the window's stop button is dead, after which the robot waits at rest,
and after which it is stopped until *Start*."""
CONFIRMATION_TIMEOUT = 0.5
"Seconds within which the loop confirms a stop."
_MOST_CYCLES = 200
CLOSED = "the window has ended"
NOT_ANSWERING = "the window does not answer"
HAND_EYE = "stopped to calibrate hand and eye"
"Reasons of a stop."


@dataclass(frozen=True, eq=False)
class ProxyReport:
    """The events since the previous report."""

    moments: list[Moment]
    running: bool
    halted: str
    "Why the emergency stop is on; empty if it is off."
    config: Config
    confirmed: int
    "Number of the newest stop that was carried out."
    failures: list[str]
    "Why the loop ended or did not start."
    frame: Frame | None = None
    "The newest image, if the window has taken the previous one."
    calibration: Calibration | None = None
    "The calibration of `frame`."
    skeleton: tuple[NDArray[np.float64], ...] = ()
    camera: Pose | None = None
    "The camera in the robot's base."


class RequestKind(Enum):
    """Kinds of messages from a window."""

    STOP = "stop"
    START = "start"
    TUNE = "tune"
    HEARTBEAT = "heartbeat"
    IMAGE_TAKEN = "image taken"
    "The loop may send the next image."
    CLOSED = "closed"


@dataclass(frozen=True)
class ProxyRequest:
    """A message from the window; STOP has `reason` and `number`, TUNE has `config`."""

    kind: RequestKind
    reason: str = ""
    number: int = 0
    config: Config | None = None


def write(pipe: IO[bytes], message: ProxyReport | ProxyRequest) -> None:
    """Write one message. Raises OSError, ValueError once the pipe is closed."""
    pickle.dump(message, pipe, pickle.HIGHEST_PROTOCOL)
    pipe.flush()


def read(pipe: IO[bytes]) -> Any:
    """Wait for the next message; return None at the end of the pipe, even within a message."""
    try:
        return pickle.load(pipe)
    except (EOFError, OSError, ValueError, pickle.UnpicklingError):
        return None


class RunnerServer:
    """The loop's end. Stops the robot when the window ends or hangs."""

    def __init__(
        self, runner: Runner, calibration: CalibrationFor, to_window: IO[bytes], from_window: IO[bytes]
    ) -> None:
        self.closed = threading.Event()
        "Set when the window has ended, after the robot was stopped for it."
        self._runner, self._calibration = runner, calibration
        self._to, self._from = to_window, from_window
        self._moments: deque[Moment] = deque(maxlen=_MOST_CYCLES)
        self._frame: tuple[float, Frame] | None = None
        "The newest image that was not sent, and the time of its cycle, with which or after which it is sent."
        self._taken = True
        self._failures: deque[str] = deque(maxlen=10)
        self._confirmed = 0
        self._confirming = threading.Lock()
        self._last_heartbeat: float | None = None
        self._not_answering = False
        self.shown = False
        "Whether the window is there: it has sent a heartbeat."
        self._threads = [
            threading.Thread(target=self._send, name="servo reports", daemon=True),
            threading.Thread(target=self._receive, name="servo requests", daemon=True),
        ]

    def open(self) -> None:
        """Begin to send reports and to receive requests."""
        self._runner.cycle_done.connect(self._on_cycle)
        self._runner.failed.connect(self._on_failed)
        for thread in self._threads:
            thread.start()

    def close(self) -> None:
        """Stop sending reports; the threads end with the window. May be called twice."""
        self.closed.set()
        self._runner.cycle_done.disconnect(self._on_cycle, missing_ok=True)
        self._runner.failed.disconnect(self._on_failed, missing_ok=True)

    def _on_cycle(self, cycle: ControlCycle, frame: Frame | None) -> None:
        if frame is not None:
            self._frame = cycle.time, frame
        self._moments.append(self._runner.loop.moment(cycle))
        self._check_heartbeat()  # here, because a hanging window may block the reporting thread

    def _on_failed(self, reason: str) -> None:
        self._failures.append(reason)

    def _send(self) -> None:
        try:
            while not self.closed.wait(PERIOD):
                write(self._to, self._report())
        except (OSError, ValueError):
            log.debug("the window has closed its pipe")

    def _report(self) -> ProxyReport:
        runner, moments, failures = self._runner, _emptied(self._moments), _emptied(self._failures)
        frame = calibration = None
        waiting = self._frame
        if moments and self._taken and waiting is not None and waiting[0] <= moments[-1].cycle.time:
            self._frame, self._taken = None, False
            frame = replace(waiting[1], parts=(), chunks={}, chunk_payload=None)
            try:
                calibration = self._calibration(frame.width, frame.height)
            except GrabberError as error:
                log.debug("no calibration to show: %s", error)
        state = moments[-1].cycle.robot if moments else None
        return ProxyReport(
            moments,
            runner.running,
            runner.gate.halted,
            runner.config,
            self._confirmed,
            failures,
            frame,
            calibration,
            () if state is None else tuple(runner.robot.skeleton(state)),
            None if state is None else runner.robot.camera_pose(state.head),
        )

    def _check_heartbeat(self) -> None:
        """Stop the robot if the window hangs, because its stop button is dead then."""
        age = 0.0 if self._last_heartbeat is None else time.monotonic() - self._last_heartbeat
        self._runner.gate.paused = NOT_ANSWERING if age > HEARTBEAT_LATE else ""
        silent = age > HEARTBEAT_TIMEOUT
        if silent and not self._not_answering:
            _start_thread(partial(self._runner.emergency_stop, NOT_ANSWERING), "emergency stop")
            log.error("%s: the robot is stopped", NOT_ANSWERING)
        self._not_answering = silent

    def _receive(self) -> None:
        while (request := read(self._from)) is not None:
            if request.kind is not RequestKind.IMAGE_TAKEN:  # which a window sends although it hangs
                self._last_heartbeat, self.shown = time.monotonic(), True
            if request.kind is RequestKind.STOP:
                # A thread for each stop: a hanging network must not delay a second stop.
                _start_thread(partial(self._stop, request), "emergency stop")
            elif request.kind is RequestKind.START and not self.closed.is_set():
                self._runner.request_start()
            elif request.kind is RequestKind.TUNE and request.config is not None:
                self._runner.tune(request.config)
            elif request.kind is RequestKind.IMAGE_TAKEN:
                self._taken = True
            elif request.kind is RequestKind.CLOSED:
                break
        self._last_heartbeat, self._runner.gate.paused = None, ""
        if not self.closed.is_set():
            self._runner.emergency_stop(CLOSED)
        self.closed.set()

    def _stop(self, request: ProxyRequest) -> None:
        self._runner.emergency_stop(request.reason)
        with self._confirming:  # a later stop may be carried out first
            self._confirmed = max(self._confirmed, request.number)


class RunnerProxy:
    """The window's end: the part of a `Runner` that a window needs, without the camera.

    Reports arrive on a thread of its own, which emits the signals.
    """

    cycle_done = Signal(object, object)
    """As `Runner.cycle_done`, but not with every frame."""
    failed = Signal(str)
    """As `Runner.failed`, and if a stop is not confirmed."""

    def __init__(self, from_loop: IO[bytes], to_loop: IO[bytes], ended: Callable[[], None]) -> None:
        """Wait for the first report. `ended` is called when the loop's process closes its end or dies."""
        self.running = True
        self.loop, self.robot, self.gate = _Loop(), _Robot(), _Gate()
        self._from, self._to = from_loop, to_loop
        self._ended = ended
        self._lock = threading.Lock()
        self._numbers = itertools.count(1)
        self._confirmed = threading.Condition()
        self._newest_stop = 0
        self._calibration: Calibration | None = None
        first = read(from_loop)
        if first is None:
            raise SourceUnavailableError("the servo program has ended before its window was there")
        self.config: Config = first.config
        self._first: ProxyReport | None = first
        self._reported = time.monotonic()
        self._thread = threading.Thread(target=self._receive, name="servo reports", daemon=True)

    def open(self) -> None:
        """Begin to receive reports."""
        self._thread.start()

    def close(self) -> None:
        """Report that the window was closed, and wait for the loop's end of the pipe to close."""
        self._request(ProxyRequest(RequestKind.CLOSED))
        self._thread.join(HEARTBEAT_TIMEOUT)

    def calibration(self, width: int, height: int) -> Calibration:
        """Return the newest image's calibration. Raises SourceUnavailableError if the size differs."""
        known = self._calibration
        if known is None or (known.width, known.height) != (width, height):
            raise SourceUnavailableError(f"the loop has no calibration for images of {width}×{height}")
        return known

    def heartbeat(self) -> None:
        """Send a heartbeat; call it on the GUI thread, every `HEARTBEAT_PERIOD`.

        Does nothing while the loop hangs: unread heartbeats would fill the pipe and block the GUI thread.
        """
        if time.monotonic() - self._reported < HEARTBEAT_TIMEOUT:
            self._request(ProxyRequest(RequestKind.HEARTBEAT))

    def emergency_stop(self, reason: str = "emergency stop") -> None:
        """Stop the robot and wait for the loop's confirmation; emit `failed` without one. Any thread."""
        number = next(self._numbers)
        self._request(ProxyRequest(RequestKind.STOP, reason, number))
        with self._confirmed:
            if not self._confirmed.wait_for(lambda: self._newest_stop >= number, CONFIRMATION_TIMEOUT):
                self.failed.emit(f"the loop has not confirmed the stop within {CONFIRMATION_TIMEOUT:g} s")

    def request_start(self) -> None:
        """See `Runner.request_start`; if the robot may not move, `failed` follows with the reason."""
        self._request(ProxyRequest(RequestKind.START))

    def tune(self, config: Config) -> None:
        """Use other gains, limits and rate from the next cycle on."""
        self._request(ProxyRequest(RequestKind.TUNE, config=config))

    def _request(self, request: ProxyRequest) -> None:
        try:
            with self._lock:
                write(self._to, request)
        except (OSError, ValueError):
            log.debug("the loop has closed its pipe")

    def _receive(self) -> None:
        report, self._first = self._first, None
        while report is not None:
            self._reported = time.monotonic()
            self._take(report)
            report = read(self._from)
        self.running = False
        self._ended()

    def _take(self, report: ProxyReport) -> None:
        self.running, self.gate.halted, self.config = report.running, report.halted, report.config
        self._calibration = report.calibration or self._calibration
        if report.camera is not None:
            self.robot.lines, self.robot.camera = list(report.skeleton), report.camera
        with self._confirmed:
            self._newest_stop = report.confirmed
            self._confirmed.notify_all()
        for moment in report.moments:
            self.loop.newest = moment
            newest = moment is report.moments[-1]
            self.cycle_done.emit(moment.cycle, report.frame if newest else None)
        if report.frame is not None:
            self._request(ProxyRequest(RequestKind.IMAGE_TAKEN))
        for failure in report.failures:
            self.failed.emit(failure)


class _Loop:
    """The part of a `ServoLoop` that a window reads."""

    def __init__(self) -> None:
        self.newest: Moment | None = None

    def moment(self, cycle: ControlCycle) -> Moment:
        """Return the newest moment, which is that of `cycle`."""
        return self.newest or Moment(cycle)


class _Robot:
    """The part of a `Robot` that a window reads, always from the newest report."""

    def __init__(self) -> None:
        self.lines: list[NDArray[np.float64]] = []
        self.camera: Pose = np.eye(4)

    def skeleton(self, state: RobotState) -> list[NDArray[np.float64]]:
        """Return the newest lines, see `Robot.skeleton`."""
        return self.lines

    def camera_pose(self, head: Vector) -> Pose:
        """Return the newest pose, see `Robot.camera_pose`."""
        return self.camera


class _Gate:
    """The part of a `CommandGate` that a window reads."""

    halted = ""


Run = Runner | RunnerProxy
"A run in this process or in another one."


def _emptied(waiting: deque[Any]) -> list[Any]:
    """Remove and return the present items; other threads may append in the meantime."""
    return [waiting.popleft() for _ in range(len(waiting))]


def _start_thread(function: Callable[[], None], name: str) -> None:
    threading.Thread(target=function, name=name, daemon=True).start()
