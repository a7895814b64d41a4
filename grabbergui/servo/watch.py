"""Notices what does not happen though it should: encoders that stand still, a hand that comes no nearer."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from grabbergui.calibration import geometry
from grabbergui.calibration.geometry import Pose, Vector
from grabbergui.servo.gate import Command
from grabbergui.servo.robots.robot import RobotState

_SLOW_HEAD = 0.02
"Rad/s of a command below which nothing need be seen of it."
_SLOW_HAND = 0.01
"M/s or rad/s likewise."

_NEARER = 0.002
"Metres by which a hand must come nearer to its goal to make progress."
_LEVER = 0.1
"Metres that a radian off counts for."
_OTHER_GOAL = (0.02, np.radians(5))
"Metres or radians by which a goal has moved so that it is worth another try."


_COUNTED = 0.2
"Seconds that one reading counts for at most; without another command a robot stands still by then."


class EncoderWatch:
    """Compares readings with the commands that reached the robot. No clock: readings carry their time.

    Readings that do not come are another fault, and no repetition: a busy computer is no dead encoder.
    It adds up the seconds of commanded motion without a change of the readings. Pauses do not count, nor do
    they begin the count again: a camera that loses every tenth frame must not hide dead encoders.
    """

    def __init__(self, patience: float) -> None:
        """`patience` is how many seconds of commanded motion may pass while the readings stand still."""
        self._patience = patience
        self._head, self._hand = _Still(_SLOW_HEAD), _Still(_SLOW_HAND)
        self._last = 0.0

    @property
    def head_frozen(self) -> bool:
        """Whether the head's readings stand still against its commands."""
        return self._head.seconds > self._patience

    @property
    def arm_frozen(self) -> bool:
        """Whether the arm's readings stand still against its commands."""
        return self._hand.seconds > self._patience

    def commanded(self, command: Command) -> None:
        """Note the command that the robot follows from now on."""
        self._head.moves = command.head_step is not None or self._head.is_fast(command.head)
        self._hand.moves = self._hand.is_fast(command.hand)

    def look(self, robot: RobotState) -> None:
        """Judge the newest reading."""
        elapsed, self._last = min(max(robot.time - self._last, 0.0), _COUNTED), robot.time
        self._head.look(elapsed, robot.head)
        self._hand.look(elapsed, robot.hand)


class _Still:
    """Seconds that one part of the robot has been commanded to move while its readings were the same."""

    def __init__(self, slow: float) -> None:
        self.seconds = 0.0
        self.moves = False
        self._slow = slow
        self._reading: NDArray[np.float64] = np.empty(0)

    def is_fast(self, velocity: Vector) -> bool:
        return float(np.abs(velocity).max()) > self._slow

    def look(self, elapsed: float, reading: NDArray[np.float64]) -> None:
        # An encoder's noise would be motion enough; a dead one repeats itself to the last bit.
        if not np.array_equal(reading, self._reading):
            self.seconds = 0.0
        elif self.moves:
            self.seconds += elapsed
        self._reading = reading


class ProgressWatch:
    """Tells when a hand has come as near to its goal as it ever will. No clock: time is an argument."""

    def __init__(self, patience: float) -> None:
        """`patience` is how many seconds of approaching may pass without progress."""
        self.stuck = False
        "Whether the hand cannot come nearer to the goal that it has."
        self._patience = patience
        self._goal: Pose | None = None
        self._best = np.inf
        self._waiting = 0.0
        self._last = 0.0

    def give_up(self) -> None:
        """There is no need to wait: it is known that the hand cannot get on."""
        self.stuck = True

    def reset(self) -> None:
        """Allow another attempt."""
        self.stuck, self._goal = False, None

    def update(self, now: float, hand: Pose, goal: Pose, approaching: bool, speed: float = 1.0) -> None:
        """Take in where hand and goal are; time counts while it is `approaching`, less at a lower `speed`."""
        seconds, self._last = now - self._last, now
        if self._goal is None or self._moved(goal):
            self.stuck, self._goal, self._best, self._waiting = False, goal, np.inf, 0.0
        off = geometry.distance(hand, goal) + _LEVER * geometry.angle_between(hand, goal)
        if off < self._best - _NEARER:
            self._best, self._waiting = off, 0.0
        elif approaching:
            self._waiting += seconds * speed
        self.stuck = self.stuck or self._waiting > self._patience

    def _moved(self, goal: Pose) -> bool:
        before = self._goal
        return before is not None and (
            geometry.distance(before, goal) > _OTHER_GOAL[0]
            or geometry.angle_between(before, goal) > _OTHER_GOAL[1]
        )
