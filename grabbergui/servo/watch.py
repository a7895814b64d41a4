"""Notices what does not happen though it should: encoders that stand still, a hand that comes no nearer."""

from __future__ import annotations

import numpy as np

from grabbergui.calibration import geometry
from grabbergui.calibration.geometry import Pose
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


class EncoderWatch:
    """Compares readings with what was commanded. No clock: time is an argument."""

    def __init__(self, patience: float) -> None:
        """`patience` is how many seconds of commanded motion may pass without any of it."""
        self.head_frozen = self.arm_frozen = False
        self._patience = patience
        self._head_since: float | None = None
        self._hand_since: float | None = None
        self._head = np.full(2, np.nan)
        self._hand = np.full((4, 4), np.nan)

    def commanded(self, now: float, command: Command) -> None:
        """Note what was sent."""
        stepped = command.head_step is not None
        if stepped or np.abs(command.head).max() > _SLOW_HEAD:
            self._head_since = now if self._head_since is None else self._head_since
        else:
            self._head_since = None
        if np.abs(command.hand).max() > _SLOW_HAND:
            self._hand_since = now if self._hand_since is None else self._hand_since
        else:
            self._hand_since = None

    def look(self, now: float, robot: RobotState) -> None:
        """Take in a reading."""
        # An encoder's noise would be motion enough; one that is dead repeats itself to the last bit.
        if not np.array_equal(robot.head, self._head):
            self._head_since = None if self._head_since is None else now
        if not np.array_equal(robot.hand, self._hand):
            self._hand_since = None if self._hand_since is None else now
        self._head, self._hand = robot.head, robot.hand
        self.head_frozen = self._head_since is not None and now - self._head_since > self._patience
        self.arm_frozen = self._hand_since is not None and now - self._hand_since > self._patience


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
        """Let it be tried anew."""
        self.stuck, self._goal = False, None

    def update(self, now: float, hand: Pose, goal: Pose, approaching: bool) -> None:
        """Take in where hand and goal are; time counts while it is `approaching`."""
        seconds, self._last = now - self._last, now
        if self._goal is None or self._moved(goal):
            self.stuck, self._goal, self._best, self._waiting = False, goal, np.inf, 0.0
        off = geometry.distance(hand, goal) + _LEVER * geometry.angle_between(hand, goal)
        if off < self._best - _NEARER:
            self._best, self._waiting = off, 0.0
        elif approaching:
            self._waiting += seconds
        self.stuck = self.stuck or self._waiting > self._patience

    def _moved(self, goal: Pose) -> bool:
        before = self._goal
        return before is not None and (
            geometry.distance(before, goal) > _OTHER_GOAL[0]
            or geometry.angle_between(before, goal) > _OTHER_GOAL[1]
        )
