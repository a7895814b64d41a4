"""A target that runs a little ahead of a robot: motion by short positions. No clock: time is an argument.

Drives that are given a position go there and stay. One that is always just ahead keeps them in even motion;
when the commands cease, whatever the cause, the robot rests at the last.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Generic, TypeVar

import numpy as np

from grabbergui.calibration import geometry
from grabbergui.calibration.geometry import Pose, Vector

Place = TypeVar("Place", bound=np.ndarray)

HEAD_SLACK = math.radians(0.5)
HAND_SLACK = (0.002, math.radians(0.5))
"""Metres and radians by which a target may always be ahead. A joint that is held must not follow its own
deviation, or it would sink."""
FIRST_S = 0.02
"Seconds of motion in the first target after a pause."


class LeadingTarget(Generic[Place]):
    """The target of one part."""

    def __init__(
        self,
        ahead: Callable[[Place, Vector], Place],
        leashed: Callable[[Place, Place, Vector], Place],
    ) -> None:
        """`ahead` adds a motion to a place; `leashed` keeps a target within a motion of where the part is."""
        self._ahead, self._leashed = ahead, leashed
        self._target: Place | None = None
        self._time = -math.inf

    def advance(self, here: Place, velocity: Vector, seconds: float, now: float) -> Place:
        """The next target for a part that is `here`: at most `seconds` ahead of it."""
        elapsed = now - self._time
        if self._target is None or elapsed > seconds:
            self._target, elapsed = here, FIRST_S
        self._time = now
        target = self._ahead(self._target, velocity * min(elapsed, seconds))
        self._target = self._leashed(here, target, velocity * seconds)
        return self._target

    def forget(self) -> None:
        """Begin where the part is the next time."""
        self._target = None


def leading_head() -> LeadingTarget[Vector]:
    """For joint angles, radians."""

    def leashed(here: Vector, target: Vector, motion: Vector) -> Vector:
        leash = np.abs(motion) + HEAD_SLACK
        return here + np.clip(target - here, -leash, leash)

    return LeadingTarget(lambda place, motion: place + motion, leashed)


def leading_hand() -> LeadingTarget[Pose]:
    """For a hand's pose, and twists in the base."""

    def leashed(here: Pose, target: Pose, motion: Vector) -> Pose:
        off = geometry.diff(here, target)
        for part, slack in zip((slice(3), slice(3, 6)), HAND_SLACK, strict=True):
            leash = float(np.linalg.norm(motion[part])) + slack
            off[part] *= min(1.0, leash / max(float(np.linalg.norm(off[part])), 1e-9))
        return geometry.add_delta(here, off)

    return LeadingTarget(geometry.add_delta, leashed)
