"""Targets just ahead of a robot, which make a motion of commands that end by themselves."""

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
"""Metres and radians by which a target may always be ahead. Without it, the target of a resting joint would
follow the joint's own deviation, and the joint would sink."""
_FIRST_S = 0.02
"Seconds of motion in the first target after a pause."


class LeadingTarget(Generic[Place]):
    """The target of one part, for drives that go to a position and stay there.

    A target that is always just ahead keeps the motion even; when the commands cease for any reason, the
    robot rests at the last target.
    """

    def __init__(
        self,
        ahead: Callable[[Place, Vector], Place],
        leashed: Callable[[Place, Place, Vector], Place],
    ) -> None:
        """`ahead` adds a motion to a place; `leashed` keeps a target within a motion of the part."""
        self._ahead, self._leashed = ahead, leashed
        self._target: Place | None = None
        self._time = -math.inf

    def advance(self, here: Place, velocity: Vector, seconds: float, now: float) -> Place:
        """Return the next target of a part that is `here`: at most `seconds` ahead of it."""
        elapsed = now - self._time
        if self._target is None or elapsed > seconds:
            self._target, elapsed = here, _FIRST_S
        self._time = now
        target = self._ahead(self._target, velocity * min(elapsed, seconds))
        self._target = self._leashed(here, target, velocity * seconds)
        return self._target

    def forget(self) -> None:
        """Start from the part's place next time."""
        self._target = None


def leading_head() -> LeadingTarget[Vector]:
    """Return the target of a head, in joint angles (radians)."""

    def leashed(here: Vector, target: Vector, motion: Vector) -> Vector:
        leash = np.abs(motion) + HEAD_SLACK
        return here + np.clip(target - here, -leash, leash)

    return LeadingTarget(lambda place, motion: place + motion, leashed)


def leading_hand() -> LeadingTarget[Pose]:
    """Return the target of a hand: its pose, moved by twists in the base."""

    def leashed(here: Pose, target: Pose, motion: Vector) -> Pose:
        off = geometry.diff(here, target)
        for part, slack in zip((slice(3), slice(3, 6)), HAND_SLACK, strict=True):
            leash = float(np.linalg.norm(motion[part])) + slack
            off[part] *= min(1.0, leash / max(float(np.linalg.norm(off[part])), 1e-9))
        return geometry.add_delta(here, off)

    return LeadingTarget(geometry.add_delta, leashed)
