"""A simulated robot, whose kinematics are integrated over time, within its limits.

It has no thread: every query and command first integrates up to the present, in small steps, so that the
robot behaves the same under a real clock and under a test's.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike
from typing_extensions import override

from grabbergui.calibration.geometry import Pose, Vector
from grabbergui.servo.kinematics import Chain
from grabbergui.servo.robots.faults import STARTED, Faults
from grabbergui.servo.robots.robot import JointHistory, KinematicModel, Robot, RobotState

STEP = 0.01
"Seconds of one step of integration."
RESOLUTION = 0.002
"Seconds within which it is not integrated again: several readings of one moment are one step."
FORESEEN_S = 0.02
"Seconds by which `camera_at` extrapolates."
SETTLED = 1.0
"Seconds without a query after which the integration skips the time of a robot at rest."
RESPONSE = 0.03
"Seconds that drives take to follow a command to 63 %."
STEP_SPEED = math.radians(25)
"Speed of relative moves of the head."
AIM_S = 0.08
"Seconds before the target of a move at which the part slows down."


class SimRobot(Robot):
    """A simulated head and arm. Any thread."""

    def __init__(
        self,
        model: KinematicModel,
        clock: Callable[[], float] = time.monotonic,
        head: ArrayLike = (0.0, 0.0),
        arm: ArrayLike | None = None,
        faults: Faults | None = None,
    ) -> None:
        """`head` and `arm` are the joints' first angles, radians."""
        super().__init__(model, f"simulated {model.name}")
        self.faults = faults or Faults()
        "What is wrong with this robot; read them on its `clock`."
        self.limit_violations = 0
        "Number of steps after which a joint was beyond its limits or too fast; stays 0."
        self._clock = clock
        self._lock = threading.RLock()
        self._time = clock()
        self._head = _Drive(model.head, np.asarray(head, np.float64))
        self._arm = _Drive(model.arm, model.home if arm is None else np.asarray(arm, np.float64))
        self._head_target: Vector | None = None
        self._arm_target: Vector | None = None
        self._head_velocity = np.zeros(2)
        "The commanded velocity, or the highest speed on the way to `_head_target`."
        self._twist = np.zeros(6)
        self._arm_velocity: Vector | None = None
        "The joints' commanded velocity, instead of a twist."
        self._head_until = self._arm_until = -math.inf
        self._true: RobotState | None = None
        "The true state at `_time`, once it was requested."
        self._state: RobotState | None = None
        "The reading at that time."
        self._history = JointHistory(400)
        self._history.add(self._time, self._head.angles)

    @override
    def open(self) -> None:
        self._advance()

    @override
    def close(self) -> None:
        self.stop()

    @override
    def state(self) -> RobotState:
        """Return a reading of the present moment; the last one from a robot that sends no more."""
        with self._lock:
            true = self.truth()
            if self._state is None:
                self._state = self.faults.reading(true, self.model.arm)
            return self._state

    def truth(self) -> RobotState:
        """Return where the joints and the hand are, whatever the robot reports."""
        with self._lock:
            self._advance()
            if self._true is None:
                hand = self.model.arm.forward(self._arm.angles)
                self._true = RobotState(self._time, self._head.angles, hand, self._arm.angles)
            return self._true

    @override
    def move_head(self, velocity: Vector) -> None:
        with self._lock:
            self._advance()
            self._head_target = None
            self._head_velocity = _finite(velocity, 2)
            self._head_until = self._time + self.COMMAND_TIMEOUT

    @override
    def step_head(self, move: Vector) -> None:
        """Move from where the joints are, as a control board's relative moves do."""
        with self._lock:
            self._advance()
            self.point_head(self._head.angles + _finite(move, 2), np.full(2, STEP_SPEED))

    def point_head(self, target: Vector, fastest: Vector) -> None:
        """Go to pan and tilt (radians), each at no more than its speed (rad/s), and stay there."""
        with self._lock:
            self._advance()
            if np.shape(target) == (2,) and np.isfinite(target).all():
                self._head_target = self.model.head.clamped(target)
                self._head_velocity = np.asarray(fastest, np.float64)

    def point_arm(self, target: Vector) -> None:
        """Go to joint angles (radians) at the joints' highest speed, and stay there."""
        with self._lock:
            self._advance()
            if np.shape(target) == self._arm.angles.shape and np.isfinite(target).all():
                self._arm_target, self._arm_velocity = self.model.arm.clamped(target), None

    def move_arm(self, velocity: Vector) -> None:
        """Move the joints at velocities, rad/s, each within its limits, as a board in velocity mode does."""
        with self._lock:
            self._advance()
            self._arm_target = None
            self._arm_velocity = _finite(velocity, len(self.model.arm.low))
            self._arm_until = self._time + self.COMMAND_TIMEOUT

    @override
    def move_hand(self, twist: Vector) -> None:
        with self._lock:
            self._advance()
            self._arm_target = self._arm_velocity = None
            self._twist = _finite(twist, 6)
            self._arm_until = self._time + self.COMMAND_TIMEOUT

    def obey_stranger(self, twist: Vector) -> None:
        """Follow a twist from another program while twists are obeyed: from `move_hand` until `stop`."""
        with self._lock:
            if self._arm_until > -math.inf:
                self.move_hand(twist)

    @override
    def stop(self) -> bool:
        with self._lock:
            self._advance()
            self._head_target = self._arm_target = self._arm_velocity = None
            self._head_until = self._arm_until = -math.inf
            self._head.halt()
            self._arm.halt()
        return True

    def camera_at(self, moment: float) -> Pose:
        """Return the camera's pose in the room at a moment on the robot's clock, or in the near future."""
        with self._lock:
            self._advance()
            angles = self._history.at(moment) if moment <= self._time else None
            if angles is None:
                ahead = min(max(moment - self._time, 0.0), FORESEEN_S)
                angles = self.model.head.clamped(self._head.angles + self._head.velocity * ahead)
            return self.model.stands @ self.model.camera_pose(angles)

    @property
    def silent(self) -> bool:
        """Whether the robot sends no readings at present."""
        return self.faults.since("readings-stop", self.truth().time) is not None

    @property
    def speed(self) -> float:
        """The speed of the fastest joint, rad/s."""
        with self._lock:
            self._advance()
            return max(self._head.fastest, self._arm.fastest)

    def _advance(self) -> None:
        with self._lock:
            now = self._clock()
            if now - self._time < RESOLUTION - 1e-9:
                return
            self._true = self._state = None
            while self._time < now - 1e-9:
                if now - self._time > SETTLED and self._rests():
                    self._time = now - STEP
                seconds = min(STEP, now - self._time)
                self._integrate(seconds)
                self._time += seconds
                if self._arm.fastest > STARTED:
                    self.faults.moved(self._time)
                self._history.add(self._time, self._head.angles)

    def _rests(self) -> bool:
        commanded = self._time < max(self._head_until, self._arm_until)
        off = max(_off(self._head_target, self._head), _off(self._arm_target, self._arm))
        return not commanded and max(off, self._head.fastest, self._arm.fastest) < 1e-9

    def _integrate(self, seconds: float) -> None:
        head = self._head_velocity if self._time < self._head_until else np.zeros(2)
        if self._head_target is not None:
            fastest = self._head_velocity
            head = np.clip((self._head_target - self._head.angles) / AIM_S, -fastest, fastest)
        obeyed = self._time < self._arm_until
        twist = self._twist if obeyed else np.zeros(6)
        arm = np.zeros_like(self._arm.angles)
        if self._arm_velocity is not None:
            arm = self._arm_velocity if obeyed else arm
        elif twist.any():
            arm = self.model.arm.velocities_for(self._arm.angles, twist)
        elif self._arm_target is not None:
            fastest = self.model.arm.fastest
            arm = np.clip((self._arm_target - self._arm.angles) / AIM_S, -fastest, fastest)
        if self.faults.since("arm-blocked", self._time) is not None:
            self._arm.halt()
            arm = np.zeros_like(arm)
        for drive, velocity in ((self._head, head), (self._arm, arm)):
            self.limit_violations += drive.advance(velocity, seconds)


class _Drive:
    """The joints of one chain."""

    def __init__(self, chain: Chain, angles: Vector) -> None:
        self._chain = chain
        self.angles = chain.clamped(chain.checked(angles))
        self.velocity = np.zeros_like(chain.low)

    def advance(self, wanted: Vector, seconds: float) -> bool:
        """Follow a velocity, rad/s, for some time; return whether a limit was violated (a bug)."""
        chain = self._chain
        wanted = np.clip(wanted, -chain.fastest, chain.fastest)
        self.velocity = self.velocity + (wanted - self.velocity) * (1 - math.exp(-seconds / RESPONSE))
        moved = self.angles + self.velocity * seconds
        self.velocity = np.where((moved < chain.low) | (moved > chain.high), 0.0, self.velocity)
        before, self.angles = self.angles, chain.clamped(moved)
        too_fast = np.abs(self.angles - before) > chain.fastest * seconds + 1e-9
        beyond = (self.angles < chain.low - 1e-9) | (self.angles > chain.high + 1e-9)
        return bool((too_fast | beyond).any())

    @property
    def fastest(self) -> float:
        """Speed of the fastest joint, rad/s."""
        return float(np.abs(self.velocity).max())

    def halt(self) -> None:
        """Brake."""
        self.velocity = np.zeros_like(self.velocity)


def _off(target: Vector | None, drive: _Drive) -> float:
    """Return the largest distance of a joint from its target, radians."""
    return 0.0 if target is None else float(np.abs(target - drive.angles).max())


def _finite(values: Vector, size: int) -> Vector:
    """Return a command's numbers, or zeros unless they are `size` finite ones: drives reject others."""
    array = np.asarray(values, np.float64)
    return array.copy() if array.shape == (size,) and np.isfinite(array).all() else np.zeros(size)
