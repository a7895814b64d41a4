"""Hand–eye calibration in the window: moves the robot from pose to pose on a thread of its own."""

from __future__ import annotations

import logging
import queue
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from psygnal import Signal

from grabbergui.calibration import geometry
from grabbergui.calibration.marker_pose import MarkerDetection
from grabbergui.core.errors import GrabberError, UsageError
from grabbergui.core.frame import Frame
from grabbergui.core.pixels import Region
from grabbergui.models.calibrating import Preview
from grabbergui.models.image.display_settings import DisplaySettings
from grabbergui.models.image.rendering import render
from grabbergui.models.language import driver_text, translate
from grabbergui.servo.config import Config, MarkerConfig
from grabbergui.servo.errors import RobotStoppedError
from grabbergui.servo.hand_eye import hand_eye_file
from grabbergui.servo.hand_eye.hand_eye_file import CameraMount
from grabbergui.servo.hand_eye.plan import RunPlan, plan
from grabbergui.servo.hand_eye.run import VIEWS, HandEyeRun, Progress, Step, watched
from grabbergui.servo.hand_eye.solver import FEWEST_VIEWS, HandEyeResult
from grabbergui.servo.hand_eye.stand import HandEyeStand, TargetWatch
from grabbergui.servo.models.hand_eye_text import ended_text, progress_text
from grabbergui.servo.robots.robot import CameraPlace
from grabbergui.servo.runner import STOPPED

log = logging.getLogger(__name__)

SILENCE = 1.0
"Seconds without a frame after which the silence is shown."
TAKE_WAIT = 0.5
"Seconds after which an image that was not taken is replaced; the window may be hidden."


@dataclass(frozen=True)
class Setup:
    """The operator's choices."""

    eye: str
    marker: MarkerConfig
    views: int = VIEWS
    speed: float = 1.0
    "Factor by which all motion is slowed down, 0.01 to 1."


@dataclass(frozen=True, eq=False)
class TargetPreview(Preview):
    """The newest frame with the corners of the target."""

    problem: str
    "Why this view is unusable, as display text; empty if the target is seen reliably."


@dataclass(frozen=True)
class Happened:
    """One event of a run."""

    seconds: float
    "Seconds since the run began."
    step: Step
    text: str
    views: int
    wanted: int
    remaining: float
    "Estimated seconds until the last pose."


@dataclass(frozen=True, eq=False)
class Solution:
    """A result, with the figures by which an operator judges it."""

    setup: Setup
    result: HandEyeResult
    placement: CameraMount
    joints: list[NDArray[np.float64]]
    "The joint angles of each pose in radians."
    compared: tuple[str, float, float] | None
    "Origin of the transform in use (`HandEyeStand.in_use`), metres and radians from it; None without one."


class HandEyeModel:
    """The model of the wizard. Only `close` blocks; signals are emitted on the model's own threads."""

    ready = Signal()
    """`take` returns a new preview."""
    happened = Signal(Happened)
    solved = Signal(Solution)
    ended = Signal(str, bool)
    """A run ended without a result: a sentence, and whether `compute` can use its views."""
    saved = Signal(Path)
    published = Signal(bool)
    """Whether the camera's frame is on `/tf_static`."""
    failed = Signal(str)
    """A request failed; a sentence as display text."""

    def __init__(self, stand: HandEyeStand) -> None:
        self.stand = stand
        self.setup = Setup(stand.eye, stand.config.marker, stand.views, stand.config.loop.speed)
        self.solution: Solution | None = None
        self._jobs: queue.SimpleQueue[Callable[[], None] | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._work, name="hand-eye", daemon=True)
        self._watch: TargetWatch | None = None
        self._watched: tuple[str, MarkerConfig] | None = None
        self._run: HandEyeRun | None = None
        self._running, self._closed = False, False
        self._began = 0.0
        self._view: tuple[Region | None, tuple[int, int] | None] = (None, None)
        self._offer: TargetPreview | None = None
        self._offered = self._seen_at = 0.0
        self._lock = threading.Lock()
        self._before: CameraPlace | None = None
        self._in_use = False

    @property
    def running(self) -> bool:
        """Whether the robot may move, or a result is being computed."""
        return self._running

    @property
    def in_use(self) -> bool:
        """Whether servoing uses the newest result."""
        return self._in_use

    @property
    def nominal(self) -> bool:
        """Whether the camera's calibration is only assumed."""
        watch = self._watch
        return watch is not None and watch.nominal

    def open(self) -> None:
        """Start to detect the target. The robot does not move."""
        self._seen_at = time.monotonic()
        self._thread.start()
        self._jobs.put(self._look_again)

    def close(self, timeout: float = 0.0) -> bool:
        """Stop the robot; return whether the model's thread ended within `timeout` seconds.

        It ends by itself after a computation in progress. May be called twice.
        """
        if not self._closed:
            self._closed = True
            if self._running:
                self.stop()
            self._jobs.put(None)
        if self._thread.ident is not None:
            self._thread.join(timeout)
        return not self._thread.is_alive()

    def take(self) -> TargetPreview | None:
        """Return the newest preview, once."""
        with self._lock:
            offer, self._offer = self._offer, None
        return offer

    def set_viewport(self, region: Region | None, size: tuple[int, int] | None) -> None:
        """Set the viewport: a region of the image (None: all of it), in `size` screen pixels."""
        self._view = region, size

    def choose(self, setup: Setup) -> None:
        """Choose eye, target, number of poses and speed. Raises UsageError for invalid values."""
        _ = replace(self.stand.config, marker=setup.marker).marker.board  # checks them
        self.setup = setup
        self._jobs.put(self._look_again)

    def why_not(self) -> str:
        """Return why the robot cannot be calibrated with this setup, as display text; empty if it can."""
        return driver_text(self.stand.why_not(self.setup.eye))

    def plan(self) -> RunPlan:
        """Return what the robot will do."""
        return plan(self.setup.eye, self.stand.robot.model, self._config(self.setup), self.setup.views)

    def start(self) -> None:
        """Let the robot move through the poses; `happened` follows, then `solved` or `ended`."""
        if not self._running:
            self._running = True
            self._jobs.put(partial(self._calibrate, self.stand.gate.stops))

    def stop(self) -> None:
        """Stop the robot immediately."""
        # A thread for each stop: a hanging network must delay neither the caller nor a second stop.
        halt = partial(self.stand.gate.halt, STOPPED)
        threading.Thread(target=halt, name="hand-eye stop", daemon=True).start()

    def compute(self) -> None:
        """Compute the result from the views of a run that ended early; `solved` or `ended` follows."""
        if not self._running:
            self._running = True
            self._jobs.put(self._compute)

    def save(self, path: Path, placement: CameraMount) -> None:
        """Write the robot's file; `saved` or `failed` follows."""
        solution = self.solution

        def write() -> None:
            if solution is None:
                return
            try:
                hand_eye_file.save(solution.result, path, placement)
            except OSError as error:
                text = translate("HandEye", "the result could not be saved as {0}: {1}")
                self.failed.emit(text.format(path, error.strerror or error))
            else:
                self.stand.file = path
                self.saved.emit(path)

        self._jobs.put(write)

    def use(self, on: bool) -> None:
        """Use the newest result for servoing, or return to the previous calibration."""
        if self.solution is None or on == self._in_use:
            return
        if on:
            self._before = self.stand.use(self.solution.result)
        else:
            self.stand.use_again(self._before)
        self._in_use = on

    def publish(self, on: bool, placement: CameraMount) -> None:
        """Publish the camera's frame on `/tf_static`, or withdraw it; `published` or `failed` follows."""
        solution = self.solution

        def change() -> None:
            try:
                if on and solution is not None:
                    self.stand.publish(placement, solution.result.camera)
                else:
                    self.stand.withdraw()
            except GrabberError as error:
                self.failed.emit(driver_text(error))
            self.published.emit(self.stand.published)

        self._jobs.put(change)

    def _work(self) -> None:
        while (job := self._jobs.get()) is not None:
            try:
                job()
            except Exception as error:
                self.failed.emit(_problem_of(error))
        if self._watch is not None:
            self._watch.close()
        self.stand.leave()

    def _config(self, setup: Setup) -> Config:
        config = self.stand.config
        return replace(config, marker=setup.marker, loop=replace(config.loop, speed=setup.speed))

    def _look_again(self) -> None:
        setup = self.setup
        wanted = setup.eye, setup.marker
        if wanted == self._watched or self._closed:
            return
        if self._watch is not None:
            self._watch.close()
            self._watch = self._watched = None
        try:
            self._watch = self.stand.watch(*wanted, self._on_seen, self._on_failed, self._on_silence)
        except GrabberError as error:
            self.failed.emit(driver_text(error))
            return
        self._watched = wanted

    def _calibrate(self, stops: int) -> None:
        """Run, unless there was a stop since the user's decision, when there were `stops`."""
        stand, setup = self.stand, self.setup
        self._run, problem = None, ""
        self._began = stand.clock()
        try:
            if why_not := stand.why_not(setup.eye):
                raise UsageError(why_not)
            if self._watch is None:
                raise UsageError("there is no camera to look with")
            run = HandEyeRun(
                setup.eye, stand.robot, stand.gate, self._watch, self._watch.calibration, self._config(setup),
                clock=stand.clock, pause=stand.pause, report=self._on_progress,
            )  # fmt: skip
            self._run = run
            stand.gate.release(stops)
            with watched(stand.gate, stand.clock):
                result = run.run(setup.views)
            self._publish_solution(result, run)
        except Exception as error:
            problem = _problem_of(error)
        if not stand.gate.halted:
            stand.gate.halt("the calibration ended")
        self._end(problem)

    def _compute(self) -> None:
        run, problem = self._run, ""
        try:
            if run is not None:
                self._publish_solution(run.solve(), run)
        except Exception as error:
            problem = _problem_of(error)
        self._end(problem)

    def _end(self, problem: str) -> None:
        views = 0 if self._run is None else len(self._run.views)
        self._running = False
        if problem:
            self.ended.emit(ended_text(problem, views), views >= FEWEST_VIEWS)

    def _publish_solution(self, result: HandEyeResult, run: HandEyeRun) -> None:
        known, compared = self.stand.in_use(self.setup.eye), None
        if known is not None:
            origin, camera = known
            compared = (
                origin,
                geometry.distance(result.camera, camera),
                geometry.angle_between(result.camera, camera),
            )
        joints = [np.concatenate((view.camera_angles, view.target_angles)) for view in run.views]
        self._in_use = False
        placement = self.stand.placement(self.setup.eye)
        self.solution = Solution(self.setup, result, placement, joints, compared)
        self.solved.emit(self.solution)

    def _on_progress(self, progress: Progress) -> None:
        seconds, views, wanted = self.stand.clock() - self._began, progress.views, progress.wanted
        each = seconds / views if views > 1 else self.plan().seconds / max(wanted, 1)
        remaining = max(wanted - views, 0) * each
        text = progress_text(progress)
        self.happened.emit(Happened(seconds, progress.step, text, views, wanted, remaining))

    def _on_seen(self, frame: Frame, found: MarkerDetection | None) -> None:
        now = self._seen_at = time.monotonic()
        if self._offer is not None and now - self._offered < TAKE_WAIT:
            return
        corners, problem = None, ""
        if found is None:
            problem = translate("HandEye", "the target is not seen")
        else:
            corners = found.corners if found.pixels is None else found.pixels
            problem = driver_text(found.problem)
        image = render(frame, *self._view, DisplaySettings())
        self._put(TargetPreview(image, (frame.width, frame.height), corners, problem))

    def _on_failed(self, error: GrabberError) -> None:
        self._put(TargetPreview(None, (0, 0), None, driver_text(error)))

    def _on_silence(self) -> None:
        if time.monotonic() - self._seen_at > SILENCE and not self._closed:
            self._put(
                TargetPreview(None, (0, 0), None, translate("HandEye", "no images arrive from the camera"))
            )

    def _put(self, preview: TargetPreview) -> None:
        with self._lock:
            self._offer, self._offered = preview, time.monotonic()
        self.ready.emit()


def _problem_of(error: Exception) -> str:
    """Return an error as display text, and log one that is a bug."""
    if isinstance(error, RobotStoppedError) and error.reason == STOPPED:
        return translate("HandEye", "Stopped")
    if isinstance(error, GrabberError):
        return driver_text(error)
    log.error("hand-eye calibration", exc_info=error)
    return translate("HandEye", "internal error, see the log: {0}").format(error)
