"""The watch that ends an approach whose hand comes no nearer to its goal. No clock: time is an argument."""

from __future__ import annotations

import numpy as np

from grabbergui.calibration import geometry
from grabbergui.calibration.geometry import Pose
from grabbergui.servo.kinematics import LEVER

_NEARER = 0.002
"Metres by which the hand must come nearer to its goal to make progress."
_OTHER_GOAL = (0.02, np.radians(5))
"Metres or radians by which a goal must have moved for another attempt."


class ProgressWatch:
    """Detects a hand that comes no nearer to its goal. No clock: time is an argument."""

    def __init__(self, patience: float) -> None:
        """`patience` is the longest approach without progress, seconds."""
        self.stuck = False
        "Whether the hand cannot come nearer to its present goal."
        self._patience = patience
        self._goal: Pose | None = None
        self._best = np.inf
        self._waiting = 0.0
        self._last = 0.0

    def reset(self) -> None:
        """Allow another attempt."""
        self.stuck, self._goal = False, None

    def update(self, now: float, hand: Pose, goal: Pose, approaching: bool, speed: float = 1.0) -> None:
        """Compare hand and goal; time counts only while `approaching`, and less at a lower `speed`."""
        seconds, self._last = now - self._last, now
        if self._goal is None or self._moved(goal):
            self.stuck, self._goal, self._best, self._waiting = False, goal, np.inf, 0.0
        off = geometry.distance(hand, goal) + LEVER * geometry.angle_between(hand, goal)
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
