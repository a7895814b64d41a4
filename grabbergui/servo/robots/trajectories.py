"""Joint velocities as streamed trajectories or positions, and the controller that follows them. No I/O.

`Stream` is the sender. Each cycle it makes a short trajectory that replaces the one before. It starts in the
past, where the reference then was: `joint_trajectory_controller` (ros2_control, Humble and Jazzy) then
interpolates between our own points instead of starting from the measured angles, so a drive that lags is not
slowed down. It ends at rest, so that a robot that hears no more stops by itself.

`Follower` is the receiver, as that controller documents itself: used by the simulated robot.

`LeadingTarget` is for drives that go to a position and stay there. A target that is always just ahead keeps
them in even motion; when the commands cease, whatever the cause, the robot rests at the last one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from grabbergui.calibration import geometry
from grabbergui.calibration.geometry import Pose, Vector
from grabbergui.core.errors import RemoteProtocolError

LEAD = 0.15
"Radians by which the reference may be ahead of the measured angles, so that a blocked joint does not jump."


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Angles over time."""

    joints: tuple[str, ...]
    times: tuple[float, ...]
    "Seconds from the start, increasing."
    points: NDArray[np.float64]
    "(len(times), len(joints)), radians."
    start: float | None = None
    "Seconds on the robot's clock; None: at once, from wherever the joints are."


class Stream:
    """Turns velocities of some joints into references. Times are on any one clock; one thread."""

    def __init__(self, joints: Sequence[str], low: Vector, high: Vector, horizon: float) -> None:
        """`low` and `high` are limits, radians; `horizon` is how long a velocity lasts, seconds."""
        self.joints = tuple(joints)
        self._low, self._high, self._horizon = low, high, horizon
        self._reference: Vector | None = None
        self._velocity = np.zeros(len(low))
        self._time = 0.0

    @property
    def target(self) -> Vector | None:
        """The angles at which the newest trajectory ends; None before the first and after `forget`."""
        if self._reference is None:
            return None
        ahead: Vector = np.clip(self._reference + self._velocity * self._horizon, self._low, self._high)
        return ahead

    def forget(self) -> None:
        """Begin again from the measured angles."""
        self._reference = None

    def move(self, velocity: Vector, measured: Vector, now: float) -> Trajectory:
        """Make the trajectory that moves the joints at `velocity` (rad/s) from `now` for the horizon.

        Its `start` is on the clock of `now`. Joints whose velocity is 0 hold their place.
        """
        self._advance(velocity, measured, now)
        assert self._reference is not None and self.target is not None
        return Trajectory(
            self.joints, (0.0, self._horizon), np.vstack((self._reference, self.target)), start=now
        )

    def position(self, velocity: Vector, measured: Vector, now: float, period: float) -> Vector:
        """Return the angles to be reached within one `period`, for controllers that take positions alone."""
        self._advance(velocity, measured, now)
        assert self._reference is not None
        ahead: Vector = np.clip(self._reference + velocity * period, self._low, self._high)
        return ahead

    def _advance(self, velocity: Vector, measured: Vector, now: float) -> None:
        elapsed = now - self._time
        if self._reference is None or not 0 <= elapsed <= self._horizon:
            reference = measured
        else:
            reference = self._reference + self._velocity * elapsed
            reference = np.clip(reference, measured - LEAD, measured + LEAD)
        self._reference = np.clip(reference, self._low, self._high)
        self._velocity, self._time = np.array(velocity, np.float64), now


class Follower:
    """A joint trajectory controller: checks trajectories and samples the newest one. One thread."""

    def __init__(self, joints: Sequence[str], low: Vector, high: Vector) -> None:
        self.joints = tuple(joints)
        self._low, self._high = low, high
        self._times = np.zeros(0)
        self._points = np.zeros((0, len(low)))

    def accept(self, trajectory: Trajectory, angles: Vector, now: float) -> None:
        """Replace the trajectory in progress. `angles` are those measured `now`, on the robot's clock.

        Raises RemoteProtocolError, and the trajectory before goes on: for joints that are not exactly its
        own, no points, times that do not increase, an end in the past, angles that are not finite or beyond
        the limits.
        """
        if sorted(trajectory.joints) != sorted(self.joints):
            raise RemoteProtocolError(f"joints {list(trajectory.joints)}, not {list(self.joints)}")
        points, times = np.asarray(trajectory.points, np.float64), np.asarray(trajectory.times, np.float64)
        if not len(times) or points.shape != (len(times), len(self.joints)):
            raise RemoteProtocolError(f"{len(times)} times with positions of shape {points.shape}")
        if not (np.isfinite(points).all() and np.isfinite(times).all()):
            raise RemoteProtocolError("positions or times that are not finite")
        if times[0] < 0 or (np.diff(times) <= 0).any():
            raise RemoteProtocolError(f"times {times.tolist()} do not increase")
        start = now if trajectory.start is None else trajectory.start
        if start + times[-1] < now:
            raise RemoteProtocolError(f"it ended {now - start - times[-1]:.2f} s ago")
        points = points[:, [trajectory.joints.index(name) for name in self.joints]]
        beyond = (points < self._low - 1e-3) | (points > self._high + 1e-3)
        if beyond.any():
            row, joint = np.argwhere(beyond)[0]
            raise RemoteProtocolError(
                f"{self.joints[joint]} at {points[row, joint]:.3f} rad is beyond limits"
            )
        times = start + times
        if times[0] > now:
            times, points = np.insert(times, 0, now), np.vstack((angles, points))
        self._times, self._points = times, points

    def cancel(self) -> None:
        """Hold wherever the joints are."""
        self._times, self._points = self._times[:0], self._points[:0]

    def sample(self, now: float) -> Vector | None:
        """Return the desired angles; the last point's after the end, None where nothing was accepted."""
        if not len(self._times):
            return None
        columns = [np.interp(now, self._times, column) for column in self._points.T]
        return np.array(columns)


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
