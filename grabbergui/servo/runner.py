"""A run in real time: images from any source, detection, the loop, commands to a robot.

Threads: one takes images, detects and runs the control cycle; a watchdog stops the robot when commands cease,
for instance because a detection takes too long. `emergency_stop` may be called from any thread.
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

from grabbergui.calibration.calibration_choice import CalibrationWatch
from grabbergui.core.errors import FrameTimeoutError, GrabberError
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import FrameGrabber
from grabbergui.servo.config import Config
from grabbergui.servo.detection import Detector
from grabbergui.servo.errors import RobotStoppedError
from grabbergui.servo.gate import HERE, CommandGate
from grabbergui.servo.guardian_link import Guard
from grabbergui.servo.image_watch import ImageWatch, SenderStamps
from grabbergui.servo.loop import ServoLoop
from grabbergui.servo.robots.robot import Robot, RobotState
from grabbergui.servo.state_machine import State

log = logging.getLogger(__name__)

ENDED = "the loop ended"
HELD = "ready: nothing moves until Start is pressed"
STOPPED = "stopped in the window"
"Reason of a stop by the user of a window."
TIMES_KEPT = 100_000
"Number of images whose times are kept: about an hour's."
FEW_FROZEN = 1000
"Frozen objects: Python 3.12 itself starts with some hundreds, a program that called `gc.freeze` has more."


class Runner:
    """Runs the loop on a source and a robot that the caller opens and closes."""

    cycle_done = Signal(object, object)
    """A `ControlCycle`, and the `Frame` if a new image counted in it, else None; on the loop's thread."""
    failed = Signal(str)
    """The loop ended with an error, or no guardian lets it move after `request_start`; the reason as display
    text. On the loop's thread or the starting one."""

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
        """`detector` is called with the first image, as the calibration must fit its size.

        `guard` is the guardian of a robot that would continue to move without this program.
        A `dry_run` computes everything and sends the robot neither motion nor stop.
        """
        self.grabber, self.robot, self.dry_run = grabber, robot, dry_run
        self.config = config or Config()
        self.loop = ServoLoop(self.config, robot, dry_run=dry_run)
        self.gate = CommandGate(robot, self.config, guard, dry_run=dry_run)
        self.images = 0
        "Number of images that were searched."
        self.detection_ms: deque[float] = deque(maxlen=TIMES_KEPT)
        "Duration of the newest detections."
        self.latency_ms: deque[float] = deque(maxlen=TIMES_KEPT)
        "From the middle of an image's exposure to its command, of the newest images."
        self._make_detector = detector
        self._detector: Detector | None = None
        self._images, self._stamps = ImageWatch(), SenderStamps()
        self._calibrations = CalibrationWatch(grabber)
        self._renew = False
        self._tuned: Config | None = None
        self._running = threading.Event()
        self._starting = threading.Lock()
        self._threads: list[threading.Thread] = []
        self._froze = False
        "Whether this run called `gc.freeze`."

    def start(self, held: str = "") -> None:
        """Start the source and the loop, unless it runs. With `held`, a reason, nothing moves until `resume`.

        Any thread.
        """
        if held:
            self.gate.hold(held)
        with self._starting:  # two loops must not command one robot
            if not self.running:
                self._start()

    def request_start(self) -> None:
        """Start a loop that has ended, and let the robot move, without waiting for either. Any thread.

        A stop after this call prevails, and so does the end of the loop.
        """
        threading.Thread(target=self._let_move, args=(self.gate.stops,), name="start", daemon=True).start()

    def _let_move(self, stops: int) -> None:
        """Start the loop and release the gate, unless there were more than `stops` stops."""
        with self._starting:
            if self.gate.stops != stops:
                return
            if not self.running:
                self._start()
        try:
            self.gate.release(stops)
        except RobotStoppedError as error:
            log.info("not started: %s", error)
        except GrabberError as error:
            log.error("%s", error)
            self.failed.emit(str(error))

    def _start(self) -> None:
        self._release_threads()
        # A collection among all of the program's objects takes as long as an image: 14 to 33 ms.
        # If automatic collection is off, another part of the program collects: a window on its own thread.
        # Beyond `FEW_FROZEN`, `unfreeze` would undo another's freeze.
        self._froze = gc.isenabled() and gc.get_freeze_count() < FEW_FROZEN
        if self._froze:
            gc.collect()
            gc.freeze()
        self._running.set()
        self._threads = [
            threading.Thread(target=self._run, name="servo loop", daemon=True),
            threading.Thread(
                target=self.gate.watch, args=(self._running.is_set,), name="servo watchdog", daemon=True
            ),
        ]
        for thread in self._threads:
            thread.start()

    def stop(self) -> None:
        """End the loop, also one that is being started; the robot rests on return. May be called twice."""
        self._running.clear()
        # Before waiting for the threads: a detection may hang, and the watchdog has ended.
        self.gate.halt(ENDED)
        with self._starting:
            self._running.clear()
            self._release_threads()

    def _release_threads(self) -> None:
        """Wait for the threads of a loop that ends."""
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

    def emergency_stop(self, reason: str = "emergency stop", pressed: str = HERE) -> None:
        """Stop the robot and pass no command until `resume`; `pressed` is `HERE` or a network. Any thread."""
        self.gate.halt(reason, pressed)

    def resume(self, stops: int | None = None, pressed: str = HERE) -> str:
        """End an emergency stop, and start the guardian again if it has ended. Any thread.

        `stops` is the gate's number of stops when a person decided it, if that was earlier than now; a person
        on a network (`pressed`) ends no stop that was pressed elsewhere. Return why the robot is still
        stopped (the loop has ended, no guardian could stop it, or another stop came); empty if it is not.
        """
        if not self.running:
            return ENDED
        try:
            self.gate.release(stops, pressed)
        except RobotStoppedError as error:
            return f"it was stopped again: {error.reason}"
        except GrabberError as error:
            log.error("%s", error)
            return str(error)
        return ""

    def renew_detector(self) -> None:
        """Make a new detector for the next frame, for instance after a calibration. Any thread."""
        self._renew = True

    def tune(self, config: Config) -> None:
        """Change gains, limits and rate from the next cycle on. Any thread."""
        self._tuned = config

    def _run(self) -> None:
        failure: Exception | None = None
        queue = self.grabber.open_queue(1)
        try:
            self.grabber.start()
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
        except Exception as error:
            failure = error
        finally:
            self._running.clear()
            self.gate.halt(ENDED)
            queue.close()
            self._calibrations.close()
            self._close_detector()
        if isinstance(failure, GrabberError):
            log.error("servo loop: %s", failure)
            self.failed.emit(str(failure))
        elif failure is not None:
            log.error("servo loop", exc_info=failure)
            # psygnal wraps an exception of a listener to `cycle_done`.
            self.failed.emit(f"internal error, see the log: {failure.__cause__ or failure}")

    def _close_detector(self) -> None:
        """Release the detector; the next frame gets a new one."""
        detector, self._detector = self._detector, None
        if detector is not None:
            detector.close()

    def _see(self, frame: Frame) -> float | None:
        """Detect; return the image's time of exposure (monotonic), None for a frame that does not count.

        Raises UsageError if the calibration may not fit it.
        """
        if not frame.complete:
            return None
        began = time.monotonic()
        captured = min(frame.captured, began) - self._stamps.seconds_late(frame)
        # A renewed detector forgets which images it has seen, so it is renewed for nothing else.
        if self._calibrations.another(frame) or self._detector is None or self._renew:
            self._renew = False  # first: a request during this image is for the next one
            self._close_detector()
            self._detector, self._images = self._make_detector(frame), ImageWatch()
        grey, state = np.asarray(frame.mono()), self._reading()
        self.loop.no_image = self._images.problem_of(frame, grey, None if state is None else state.head)
        if self.loop.no_image:
            return None
        self.loop.see(self._detector.detect(grey, captured, frame.frame_id))
        self.images += 1
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
        # Only a stop of this cycle: an earlier one may have been released since.
        if cycle.state is State.STOPPED and not stopped_before:
            self.gate.halt(cycle.reason)
        self.gate.send(cycle.command, time.monotonic())
        self.loop.held_back(self.gate.hindrance)
        if captured is not None:
            self.latency_ms.append(1e3 * (time.monotonic() - captured))
        self.cycle_done.emit(cycle, frame)

    def _follow_stop(self, now: float) -> None:
        """Tell the state machine of a stop that went straight to the gate, and of its end."""
        machine, halted = self.loop.machine, self.gate.halted
        if not self.running:
            return  # the end of a run is no stop
        if halted:
            machine.stop(now, halted)  # again if it is stopped: a held robot gets another reason
        elif machine.state is State.STOPPED:
            machine.resume(now)

    def _reading(self) -> RobotState | None:
        try:
            return self.robot.state()
        except GrabberError as error:
            log.debug("%s: %s", self.robot.name, error)
            return None
