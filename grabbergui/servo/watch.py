"""Notices encoders that stand still while their joints should move."""

from __future__ import annotations

import numpy as np

from grabbergui.servo.gate import Command
from grabbergui.servo.robots.robot import RobotState

_SLOW_HEAD = 0.02
"Rad/s of a command below which nothing need be seen of it."
_SLOW_HAND = 0.01
"M/s or rad/s likewise."


class EncoderWatch:
    """Compares readings with what was commanded. No clock: time is an argument."""

    def __init__(self, patience: float) -> None:
        """`patience` is how many seconds of commanded motion may pass without any of it."""
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

    def frozen(self, now: float, robot: RobotState) -> str:
        """What stands still though it should move, for people; empty where nothing does."""
        # An encoder's noise would be motion enough; one that is dead repeats itself to the last bit.
        if not np.array_equal(robot.head, self._head):
            self._head_since = None if self._head_since is None else now
        if not np.array_equal(robot.hand, self._hand):
            self._hand_since = None if self._hand_since is None else now
        self._head, self._hand = robot.head, robot.hand
        if self._head_since is not None and now - self._head_since > self._patience:
            return "the head's encoders stand still though it is commanded to move"
        if self._hand_since is not None and now - self._hand_since > self._patience:
            return "the arm's encoders stand still though it is commanded to move"
        return ""
