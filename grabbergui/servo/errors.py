"""Errors of robots, below `GrabberError`."""

from __future__ import annotations

from grabbergui.core.errors import GrabberError


class RobotStoppedError(GrabberError):
    """The robot takes no command until a person lets it move again."""

    def __init__(self, reason: str) -> None:
        super().__init__(f"the robot is stopped: {reason}")
        self.reason = reason
        "Why it was stopped, as display text."
