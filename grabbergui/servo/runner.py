"""A run in real time: images from any source, detection, the loop, commands to a robot.

Threads: one takes images, detects and runs the control cycle; a watchdog stops a robot that hears nothing
any more, for instance because a detection takes too long. `emergency_stop` may come from any thread.
"""

from __future__ import annotations

import gc
import logging
import threading
import time
from collections import deque
from collections.abc import Callable

import numpy as np
from psygnal import Signal

from grabbergui.core.errors import FrameTimeoutError, GrabberError
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import FrameGrabber
from grabbergui.servo.config import Config
from grabbergui.servo.detection import Detector
from grabbergui.servo.gate import Command, CommandGate
from grabbergui.servo.guardian_link import Guard
from grabbergui.servo.loop import ServoLoop
from grabbergui.servo.robots.robot import Robot, RobotState
from grabbergui.servo.state_machine import State

log = logging.getLogger(__name__)

_WATCH_S = 0.02
ENDED = "the loop ended"
TIMES_KEPT = 100_000
"Images whose times are kept: about an hour's."
FEW_FROZEN = 1000
"Python 3.12 itself starts with some hundred objects that its collector passes over; a program has many more."


class Runner:
    """Runs the loop on a source and a robot that others opened, and will close."""

    cycle_done = Signal(object, object)
    """A `ControlCycle`, and the `Frame` if a new image counted in it, else None; on the loop's thread."""
    failed = Signal(str)
    """The loop ended by an error; the reason as display text. On the loop's thread."""
    calibrates_hand_eye = False
    "Whether the runner starts that calibration on request. This one does not: a window does, given a stand."

    def __init__(
        self,
        grabber: FrameGrabber,
        robot: Robot,
        detector: Callable[[Frame], Detector],
        config: Config | None = None,
        guard: Guard | None = None,
        *,
        dry_run: bool = False,
    ) -> None:
        """`detector` is called with the first image, whose size a calibration must fit.

        `guard` is the guardian of a robot that would go on moving without this program.
        In a `dry_run` everything is computed, and neither motion nor stop reaches the robot.
        """
        self.dry_run = dry_run
        self.config = config or Config()
        self.loop = ServoLoop(self.config, robot, dry_run=dry_run)
        self.gate = CommandGate(robot, self.config, guard, dry_run=dry_run)
        self.pictures = 0
        "How many were looked at."
        self.detection_ms: deque[float] = deque(maxlen=TIMES_KEPT)
        "Time that each image's detection took, of the newest ones."
        self.latency_ms: deque[float] = deque(maxlen=TIMES_KEPT)
        "From the middle of an image's exposure to the command that followed from it, of the newest ones."
        self._grabber, self._robot = grabber, robot
        self._make_detector = detector
        self._detector: Detector | None = None
        self._renew = False
        self._tuned: Config | None = None
        self._running = threading.Event()
        self._starting = threading.Lock()
        self._threads: list[threading.Thread] = []
        self._froze = False
        "Whether the collector passes over all that was there before, because of this run."

    def start(self, held: str = "") -> None:
        """Start the source and the loop, unless it runs. With `held`, a reason, nothing moves until `resume`.

        Any thread.
        """
        if held:
            self.gate.halt(held)
        with self._starting:  # two loops must not command one robot
            if not self.running:
                self._start()

    def _start(self) -> None:
        # Looking for garbage among all that the program is made of takes as long as an image: 14 to 33 ms.
        self._froze = gc.get_freeze_count() < FEW_FROZEN  # `unfreeze` would release what others have frozen
        if self._froze:
            gc.collect()
            gc.freeze()
        self._running.set()
        self._threads = [
            threading.Thread(target=self._run, name="servo loop", daemon=True),
            threading.Thread(target=self._watch, name="servo watchdog", daemon=True),
        ]
        for thread in self._threads:
            thread.start()

    def stop(self) -> None:
        """End; the robot stands still on return. May be called twice."""
        self._running.clear()
        # Before waiting for them: a detection may hang, and the watchdog has gone.
        self.gate.halt(ENDED)
        for thread in self._threads:
            if thread is not threading.current_thread():
                thread.join()
        self._threads = []
        if self._froze:
            gc.unfreeze()
            self._froze = False

    @property
    def running(self) -> bool:
        """Whether the loop runs."""
        return self._running.is_set()

    def emergency_stop(self, reason: str = "emergency stop") -> None:
        """Stop the robot at once and let no command follow until `resume`. Any thread."""
        self.gate.halt(reason)

    def resume(self) -> str:
        """End an emergency stop, and start the guardian again if it has ended. Any thread.

        Returns why the robot is still stopped (no guardian could stop it, or it was stopped again), else "".
        """
        try:
            self.gate.release()
        except GrabberError as error:
            log.error("%s", error)
            return str(error)
        return ""

    @property
    def robot(self) -> Robot:
        """The robot that is moved."""
        return self._robot

    @property
    def grabber(self) -> FrameGrabber:
        """Whose images are looked at."""
        return self._grabber

    def renew_detector(self) -> None:
        """Make a new detector for the next frame, for instance after a calibration. Any thread."""
        self._renew = True

    def tune(self, config: Config) -> None:
        """Other gains, limits and rate from the next cycle on. Any thread."""
        self._tuned = config

    def _run(self) -> None:
        failure = ""
        queue = self._grabber.open_queue(1)
        try:
            self._grabber.start()
            due = time.monotonic()
            while self._running.is_set():
                frame = None
                try:
                    frame = queue.get(max(due - time.monotonic(), 0.001))
                except FrameTimeoutError as error:
                    if queue.closed:
                        raise FrameTimeoutError("the source was closed") from error
                captured = self._see(frame) if frame is not None else None
                now = time.monotonic()
                if captured is None and now < due:
                    continue
                self._cycle(now, captured, None if captured is None else frame)
                due = max(due + 1 / self.config.loop.rate, now)
        except GrabberError as error:
            log.error("servo loop: %s", error)
            failure = str(error)
        except Exception as error:
            log.exception("servo loop")
            # psygnal wraps an exception of a listener to `cycle_done`.
            failure = f"internal error, see the log: {error.__cause__ or error}"
        finally:
            self.gate.halt(ENDED)
            queue.close()
            self._close_detector()
            self._running.clear()
        if failure:
            self.failed.emit(failure)

    def _close_detector(self) -> None:
        """Release the detector; the next frame gets a new one."""
        detector, self._detector = self._detector, None
        if detector is not None:
            detector.close()

    def _see(self, frame: Frame) -> float | None:
        """Detect; when the image was exposed, on the monotonic clock. None for one that is not whole."""
        if not frame.complete:
            return None
        began = time.monotonic()
        captured = min(frame.captured, began)
        if self._detector is None or self._renew:
            self._renew = False  # first: a wish that comes meanwhile is for the next image
            self._close_detector()
            self._detector = self._make_detector(frame)
        grey = frame.mono()
        self.loop.see(self._detector.detect(np.asarray(grey), captured, frame.frame_id))
        self.pictures += 1
        self.detection_ms.append(1e3 * (time.monotonic() - began))
        return captured

    def _cycle(self, now: float, captured: float | None, frame: Frame | None) -> None:
        tuned, self._tuned = self._tuned, None
        if tuned is not None:
            self.loop.tune(tuned)
            self.config = self.loop.config
            self.gate.tune(self.config)
        self._follow_stop(now)
        stopped_before = self.loop.machine.state is State.STOPPED
        cycle = self.loop.cycle(now, self._reading())
        # Only a stop of this very cycle: one that was there before may have been ended in the meantime.
        if cycle.state is State.STOPPED and not stopped_before:
            self.gate.halt(cycle.reason)
        passed = self.gate.send(cycle.command, time.monotonic())
        self.loop.commanded(cycle.command if passed else Command(halt=True), self.gate.hindrance)
        if captured is not None:
            self.latency_ms.append(1e3 * (time.monotonic() - captured))
        self.cycle_done.emit(cycle, frame)

    def _follow_stop(self, now: float) -> None:
        """Let the state machine know of a stop that went straight to the robot, and of its end."""
        machine = self.loop.machine
        if not self.running:
            return  # its end is no event of the run
        if self.gate.halted and machine.state is not State.STOPPED:
            machine.stop(now, self.gate.halted)
        elif not self.gate.halted and machine.state is State.STOPPED:
            machine.resume(now)

    def _reading(self) -> RobotState | None:
        try:
            return self._robot.state()
        except GrabberError as error:
            log.debug("%s: %s", self._robot.name, error)
            return None

    def _watch(self) -> None:
        while self._running.is_set():
            self.gate.expire(time.monotonic())
            self.gate.beat()
            time.sleep(_WATCH_S)
