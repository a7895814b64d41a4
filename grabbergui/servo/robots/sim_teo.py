"""TEO, simulated: its kinematics integrated in the time that passes, within its limits.

Nothing runs of its own: whoever asks or commands brings the robot up to date first, in small steps, so that
it behaves the same under a real clock and under one that a test turns.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grabbergui.servo.geometry import Pose, Vector
from grabbergui.servo.kinematics import Chain
from grabbergui.servo.robots import teo
from grabbergui.servo.robots.robot import Robot, RobotState
from grabbergui.servo.tracking import JointHistory

STEP = 0.01
"Seconds of one step of integration."
RESPONSE = 0.03
"Seconds that drives take to follow a command to 63 %."
STEP_SPEED = math.radians(25)
"Of relative moves of the head."
HOME = (-20.0, -5.0, 0.0, -80.0, 0.0, 20.0)
"Degrees of the arm's joints on waking up: the hand before the body, the elbow bent."


class SimTeo(Robot):
    """TEO's head and right arm. Any thread."""

    name = "simulated TEO"

    def __init__(
        self,
        clock: Callable[[], float] = time.monotonic,
        head: ArrayLike = (0.0, 0.0),
        arm: ArrayLike | None = None,
    ) -> None:
        """`head` and `arm` are the joints' first angles, radians."""
        self.head_low, self.head_high = teo.HEAD.low, teo.HEAD.high
        self.limit_violations = 0
        "Steps after which a joint was beyond its limits or faster than it can be; stays 0."
        self._clock = clock
        self._lock = threading.RLock()
        self._time = clock()
        self._head = _Drive(teo.HEAD, np.asarray(head, np.float64))
        self._arm = _Drive(teo.RIGHT_ARM, np.radians(HOME) if arm is None else np.asarray(arm, np.float64))
        self._head_target: Vector | None = None
        self._head_velocity = np.zeros(2)
        self._twist = np.zeros(6)
        self._head_until = self._arm_until = -math.inf
        self._history = JointHistory(400)
        self._history.add(self._time, self._head.angles)

    def open(self) -> None:
        """See Robot."""
        self._advance()

    def close(self) -> None:
        """See Robot."""
        self.stop()

    def state(self) -> RobotState:
        """See Robot; always of this moment."""
        with self._lock:
            self._advance()
            return RobotState(
                self._time,
                self._head.angles.copy(),
                teo.RIGHT_ARM.forward(self._arm.angles),
                self._arm.angles.copy(),
            )

    def move_head(self, velocity: Vector) -> None:
        """See Robot."""
        with self._lock:
            self._advance()
            self._head_target = None
            self._head_velocity = _finite(velocity, 2)
            self._head_until = self._time + self.COMMAND_TIMEOUT

    def step_head(self, move: Vector) -> None:
        """See Robot. Moves add up, as a control board's relative moves do from where the joint is."""
        with self._lock:
            self._advance()
            self._head_target = teo.HEAD.clamped(self._head.angles + _finite(move, 2))
            self._head_until = math.inf

    def move_hand(self, twist: Vector) -> None:
        """See Robot."""
        with self._lock:
            self._advance()
            self._twist = _finite(twist, 6)
            self._arm_until = self._time + self.COMMAND_TIMEOUT

    def stop(self) -> None:
        """See Robot."""
        with self._lock:
            self._advance()
            self._head_target = None
            self._head_until = self._arm_until = -math.inf
            self._head.halt()
            self._arm.halt()

    def camera_pose(self, head: Vector) -> Pose:
        """See Robot."""
        return teo.HEAD.forward(head) @ teo.CAMERA_ON_HEAD

    def skeleton(self, state: RobotState) -> list[NDArray[np.float64]]:
        """See Robot."""
        return teo.skeleton(state.head, state.arm)

    def camera_at(self, moment: float) -> Pose:
        """Where the camera was at a moment on the robot's clock, or is now if that is to come."""
        with self._lock:
            self._advance()
            angles = self._history.at(min(moment, self._time))
            return self.camera_pose(self._head.angles if angles is None else angles)

    @property
    def speed(self) -> float:
        """Of the fastest joint, rad/s."""
        with self._lock:
            self._advance()
            return float(max(np.abs(self._head.velocity).max(), np.abs(self._arm.velocity).max()))

    def _advance(self) -> None:
        with self._lock:
            now = self._clock()
            while self._time < now - 1e-9:
                seconds = min(STEP, now - self._time)
                self._integrate(seconds)
                self._time += seconds
                self._history.add(self._time, self._head.angles)

    def _integrate(self, seconds: float) -> None:
        head = self._head_velocity if self._time < self._head_until else np.zeros(2)
        if self._head_target is not None:
            head = np.clip((self._head_target - self._head.angles) / 0.08, -STEP_SPEED, STEP_SPEED)
        twist = self._twist if self._time < self._arm_until else np.zeros(6)
        arm = teo.RIGHT_ARM.velocities_for(self._arm.angles, twist) if twist.any() else np.zeros(6)
        for drive, velocity in ((self._head, head), (self._arm, arm)):
            self.limit_violations += drive.advance(velocity, seconds)


class _Drive:
    """The joints of one chain."""

    def __init__(self, chain: Chain, angles: Vector) -> None:
        self._chain = chain
        self.angles = chain.clamped(chain.checked(angles))
        self.velocity = np.zeros(len(chain.joints))

    def advance(self, wanted: Vector, seconds: float) -> bool:
        """Follow a velocity, rad/s, for some time; whether a limit was broken, which must not be."""
        chain = self._chain
        wanted = np.clip(wanted, -chain.fastest, chain.fastest)
        self.velocity = self.velocity + (wanted - self.velocity) * (1 - math.exp(-seconds / RESPONSE))
        moved = self.angles + self.velocity * seconds
        self.velocity = np.where((moved < chain.low) | (moved > chain.high), 0.0, self.velocity)
        before, self.angles = self.angles, chain.clamped(moved)
        too_fast = np.abs(self.angles - before) > chain.fastest * seconds + 1e-9
        beyond = (self.angles < chain.low - 1e-9) | (self.angles > chain.high + 1e-9)
        return bool((too_fast | beyond).any())

    def halt(self) -> None:
        """Brakes on."""
        self.velocity = np.zeros_like(self.velocity)


def _finite(values: Vector, size: int) -> Vector:
    """A command's numbers; zeros where one of them is none, as drives refuse such a command."""
    array = np.asarray(values, np.float64)
    return array.copy() if array.shape == (size,) and np.isfinite(array).all() else np.zeros(size)
