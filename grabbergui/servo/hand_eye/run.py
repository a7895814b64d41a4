"""Hand–eye calibration: the robot moves to informative joint poses and observes the target from each.

Every motion passes the gate, which limits speed, workspace and clearance. The run skips a pose that the gate
refuses, that the arm does not reach, or that does not show the target. The target is fixed, or the hand holds
it (`EYES`). Each step of a run is reported as `Progress`.
"""

from __future__ import annotations

import logging
import math
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from grabbergui.calibration import geometry
from grabbergui.calibration.geometry import Pose, Vector
from grabbergui.calibration.marker_pose import MarkerDetection
from grabbergui.core.calibration import Calibration
from grabbergui.core.errors import CalibrationError, SourceUnavailableError, UsageError
from grabbergui.servo.config import Config
from grabbergui.servo.errors import RobotStoppedError
from grabbergui.servo.gate import Command, CommandGate
from grabbergui.servo.hand_eye.measurement import Arrangement, Guess, HandEyeMeasurement, Joints
from grabbergui.servo.hand_eye.proposals import propose
from grabbergui.servo.hand_eye.solver import FEWEST_VIEWS, HandEyeResult, solve
from grabbergui.servo.robots.robot import KinematicModel, Robot, RobotState

log = logging.getLogger(__name__)

EYES = ("head", "hand", "fixed")
"Where the camera is: on the head or the hand (the target is fixed), or fixed (the target is in the hand)."
VIEWS = 20
"Default number of views."
FIRST_VIEWS = 6
"Views from small moves around the first pose, if the model does not give the place of camera or target."
SMALL_DEGREES = 7.0
"Largest joint move for those views."
SPAN_DEGREES = 40.0
"Range of the arm's joints around the first pose."
PROPOSED = 3
"Poses proposed at a time; the run takes the first that it can reach."
SOLVED_EVERY = 5
"Number of new views after which the estimate of camera and target is updated."
NEAR_M, NEAR = 0.004, math.radians(0.6)
"Distance in metres and radians at which a pose counts as reached; the reported joint angles are used."
STALLED_S = 2.0
"Seconds without progress after which the run gives up a pose."
LONGEST_S = 30.0
"Longest duration of one move in seconds."
SETTLE_S = 0.4
"Seconds of rest before a frame is used."
STILL = math.radians(0.1)
"Largest joint motion during a view, in radians."
RAMP_S = 0.5
"Seconds in which a move reaches full speed."

Observe = Callable[[float], "MarkerDetection | None"]
"Returns the target in the first frame exposed after a time on the run's clock; None if it is not visible."


def arrangement(eye: str, model: KinematicModel) -> Arrangement:
    """Return which chains carry camera and target. Raises UsageError for no entry of `EYES`."""
    if eye not in EYES:
        raise UsageError(f"there is no place '{eye}' for the camera; there are {', '.join(EYES)}")
    if eye == "fixed":
        return Arrangement(None, model.arm)
    return Arrangement(model.head if eye == "head" else model.arm, None)


class Step(Enum):
    """Kinds of events."""

    MOVING = "moving"
    VIEW = "view"
    SKIPPED = "skipped"
    KNOWN = "known"
    COMPUTING = "computing"


class Skip(Enum):
    """Reasons for which a pose was skipped."""

    OBSTRUCTED = "the gate refuses it"
    NOT_REACHED = "it was not reached"
    NOT_SEEN = "the target is not seen surely"
    NOT_AT_REST = "the robot did not come to rest"


@dataclass(frozen=True)
class Progress:
    """State of a run for display."""

    views: int
    wanted: int
    text: str
    "Latest event as display text."
    step: Step
    skip: Skip | None = None
    "Why a pose was skipped; None if it was not."
    detail: str = ""
    "The gate's reason for a skipped pose; empty if it has none."
    known: tuple[float, float] | None = None
    "How well the camera is known, standard deviations in metres and radians; None if nothing was computed."


class HandEyeRun:
    """One calibration, from one thread, which any stop of the gate since its creation ends."""

    def __init__(
        self,
        eye: str,
        robot: Robot,
        gate: CommandGate,
        observe: Observe,
        calibration: Calibration,
        config: Config,
        *,
        clock: Callable[[], float] = time.monotonic,
        pause: Callable[[float], None] = time.sleep,
        report: Callable[[Progress], None] = lambda progress: None,
    ) -> None:
        """The robot is open, its guardian ready; `calibration` matches the frames that `observe` uses.

        Tests replace `clock` and `pause`.
        """
        self._eye, self._robot, self._gate, self._observe = eye, robot, gate, observe
        self._arrangement = arrangement(eye, robot.model)
        self._calibration, self._config = calibration, config
        self._clock, self._pause, self._report = clock, pause, report
        self._views: list[HandEyeMeasurement] = []
        self._wanted = 0
        self._stops = gate.stops

    def run(self, wanted: int = VIEWS) -> HandEyeResult:
        """Take `wanted` views and compute the result. The robot rests on return.

        Raises UsageError if so few views cannot be enough, CalibrationError if the target is not visible or
        too few poses show it, RobotStoppedError if the robot is stopped, SourceUnavailableError if it does
        not answer.
        """
        if wanted < FEWEST_VIEWS:  # before the robot moves for nothing
            raise UsageError(f"hand–eye calibration needs {FEWEST_VIEWS} views or more, not {wanted}")
        self._wanted = wanted
        start = self._state()
        if self._eye != "head" and start.arm is None:
            raise UsageError(f"{self._robot.name} does not report the angles of its arm")
        try:
            first = self._seen()
            if first is None or first.pose is None:
                raise CalibrationError("the target is not seen: bring it into the middle of the image first")
            guess = self._first_guess(start, first.pose)
            self._collect(start, guess, np.asarray(first.points))
        finally:
            self._gate.rest()
        return self.solve()

    @property
    def views(self) -> list[HandEyeMeasurement]:
        """The views taken so far. Any thread."""
        return list(self._views)

    def solve(self) -> HandEyeResult:
        """Compute the result from the views taken so far, for instance of a run that was stopped.

        Raises CalibrationError if they are too few or too similar.
        """
        self._say("computing", Step.COMPUTING)
        return solve(self._arrangement, self._views, self._calibration)

    def _first_guess(self, start: RobotState, target: Pose) -> Guess:
        if self._eye == "head":
            model, nothing = self._robot.model, np.zeros(0)
            camera = model.camera_pose(start.head)
            return Guess(model.camera, camera @ target, np.zeros_like(start.head), nothing)
        random = np.random.default_rng(1)
        angles = self._angles(start)
        for _ in range(4 * FIRST_VIEWS):
            if len(self._views) >= FIRST_VIEWS:
                break
            self._visit(angles + math.radians(SMALL_DEGREES) * random.uniform(-1, 1, angles.shape))
        return self._known()

    def _collect(self, start: RobotState, guess: Guess, points: Vector) -> None:
        near = self._near(start)
        tried = 0
        while len(self._views) < self._wanted:
            if tried > 4 * self._wanted:
                raise CalibrationError(
                    f"only {len(self._views)} of {self._wanted} views were possible: give the arm more room, "
                    "or move the target"
                )
            for camera, target in propose(
                near, guess, points, self._calibration, PROPOSED, self._views, seed=tried
            ):
                tried += 1
                if self._visit(camera if camera.size else target):
                    break
            if len(self._views) >= FIRST_VIEWS and len(self._views) % SOLVED_EVERY == 0:
                guess = self._known()

    def _near(self, start: RobotState) -> Arrangement:
        """Return the arrangement with the arm's joints limited to a range around the first pose."""
        if self._eye == "head":
            return self._arrangement
        chain: Joints = _Near(self._robot.model.arm, self._angles(start))
        return Arrangement(None, chain) if self._eye == "fixed" else Arrangement(chain, None)

    def _known(self) -> Guess:
        result = solve(self._arrangement, self._views, self._calibration)
        millimetres, degrees = 1e3 * result.uncertainty[0], math.degrees(result.uncertainty[1])
        text = f"the camera is known to {millimetres:.1f} mm and {degrees:.2f}°"
        self._say(text, Step.KNOWN, known=result.uncertainty)
        return Guess(result.camera, result.target, result.camera_offsets, result.target_offsets)

    def _visit(self, goal: Vector) -> bool:
        """Move to joint angles and take a view; return whether that succeeded."""
        if self._eye != "head" and (why_not := self._gate.obstruction(goal)):
            return self._skip(Skip.OBSTRUCTED, why_not)
        self._say(f"moving to view {len(self._views) + 1} of {self._wanted}", Step.MOVING)
        if not self._go(goal):
            return self._skip(Skip.NOT_REACHED, self._gate.hindrance)
        before = self._angles(self._state())
        seen = self._seen()
        after = self._angles(self._state())
        if seen is None or seen.points is None or seen.pixels is None:
            return self._skip(Skip.NOT_SEEN)
        if np.abs(after - before).max() > STILL:
            return self._skip(Skip.NOT_AT_REST)
        nothing = np.zeros(0)
        camera, target = (nothing, after) if self._eye == "fixed" else (after, nothing)
        self._views.append(HandEyeMeasurement(camera, target, seen.points, seen.pixels))
        self._say(f"view {len(self._views)} of {self._wanted}", Step.VIEW)
        return True

    def _skip(self, why: Skip, detail: str = "") -> bool:
        text = f"a pose is skipped: {detail or why.value}"
        self._say(text, Step.SKIPPED, skip=why, detail=detail)
        return False

    def _seen(self) -> MarkerDetection | None:
        """Return the target once the robot rests; None if its pose is missing or ambiguous."""
        self._gate.rest()
        began = self._clock()
        while self._clock() - began < SETTLE_S:
            self._check()
            self._pause(0.05)
        found = self._observe(self._clock())
        return found if found is not None and found.pose is not None else None

    def _go(self, goal: Vector) -> bool:
        """Move to joint angles; return whether they were reached. The robot rests on return."""
        began = improved = self._clock()
        nearest = math.inf
        try:
            while True:
                self._check()
                now, state = self._clock(), self._state()
                command, away = self._command(state, goal, min(1.0, (now - began) / RAMP_S))
                if not command.moves and away == 0:
                    return True
                if away < nearest - 0.002:
                    nearest, improved = away, now
                if now - improved > STALLED_S or now - began > LONGEST_S:
                    return False
                self._gate.send(command, now)
                self._pause(1 / self._config.loop.rate)
        finally:
            self._gate.rest()

    def _command(self, state: RobotState, goal: Vector, part: float) -> tuple[Command, float]:
        """Return the command towards joint angles at a fraction of the speed, and the distance left."""
        speed = part * self._config.loop.speed
        if self._eye == "head":
            off, fastest = goal - state.head, math.radians(self._config.head.fastest)
            away = float(np.abs(off).max())
            if away < NEAR:
                return Command(), 0.0
            return Command(head=speed * np.clip(self._config.head.gain * off, -fastest, fastest)), away
        angles, arm = self._angles(state), self._robot.model.arm
        place = geometry.diff(state.hand, arm.forward(goal))
        metres, radians = float(np.linalg.norm(place[:3])), float(np.linalg.norm(place[3:]))
        if metres < NEAR_M and radians < NEAR:
            return Command(), 0.0
        # Follow the joints, which keeps within their limits; go straight when only redundancy is left.
        twist = arm.jacobian(angles) @ (goal - angles)
        if np.linalg.norm(twist) < 0.3 * np.linalg.norm(place):
            twist = place
        twist = self._config.arm.gain * twist
        share = max(
            float(np.linalg.norm(twist[:3])) / self._config.arm.fastest,
            float(np.linalg.norm(twist[3:])) / math.radians(self._config.arm.fastest_turn),
            1.0,
        )
        away = float(np.linalg.norm(goal - angles)) if len(angles) <= 6 else metres + 0.3 * radians
        return Command(hand=speed * twist / share), away

    def _state(self) -> RobotState:
        """Return a fresh reading. Raises SourceUnavailableError if the robot sends none."""
        began = self._clock()
        while True:
            state, now = self._robot.state(), self._clock()
            fresh = state is not None and now - state.time <= self._config.safety.robot_timeout
            if state is not None and fresh and state.sound:
                return state
            self._check()
            if now - began > STALLED_S:
                raise SourceUnavailableError(f"{self._robot.name} does not report its joints")
            self._pause(0.02)

    def _angles(self, state: RobotState) -> Vector:
        angles = state.head if self._eye == "head" else state.arm
        if angles is None:
            raise SourceUnavailableError(f"{self._robot.name} no longer reports the angles of its arm")
        return angles

    def _check(self) -> None:
        # A stop ends the run also if somebody has let the robot move again.
        if self._gate.halted or self._gate.stops != self._stops:
            raise RobotStoppedError(self._gate.halted or "it may move again, but not for this calibration")

    def _say(
        self,
        text: str,
        step: Step,
        *,
        skip: Skip | None = None,
        detail: str = "",
        known: tuple[float, float] | None = None,
    ) -> None:
        log.info("%s", text)
        self._report(Progress(len(self._views), self._wanted, text, step, skip, detail, known))


@contextmanager
def watched(gate: CommandGate, clock: Callable[[], float] = time.monotonic) -> Iterator[None]:
    """Run a watchdog thread: it stops the robot when commands cease and sends the guardian's heartbeat."""
    going = threading.Event()
    going.set()
    thread = threading.Thread(
        target=gate.watch, args=(going.is_set, clock), name="hand-eye watchdog", daemon=True
    )
    thread.start()
    try:
        yield
    finally:
        going.clear()
        thread.join()
        gate.halt("the calibration ended")


class _Near:
    """A chain with its joint limits narrowed to `SPAN_DEGREES` around given angles."""

    def __init__(self, chain: Joints, angles: Vector) -> None:
        self._chain = chain
        span = math.radians(SPAN_DEGREES)
        self.low = np.maximum(chain.low, angles - span)
        self.high = np.minimum(chain.high, angles + span)

    def forward(self, angles: Vector) -> Pose:
        """Return the tool's pose in the base."""
        return self._chain.forward(angles)

    def jacobian(self, angles: Vector) -> NDArray[np.float64]:
        """Return the tool's twist for each joint's rad/s."""
        return self._chain.jacobian(angles)
