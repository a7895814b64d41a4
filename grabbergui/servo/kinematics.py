"""Chains of rotary joints: poses, Jacobians, joint velocities, and what hinders a motion. No I/O."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grabbergui.calibration.geometry import Pose, Vector, diff
from grabbergui.core.errors import UsageError

AT_LIMIT = 1e-3
"Radians from a joint's limit within which the joint counts as being at it."
STRETCHED = 0.05
"Singular value of the Jacobian (m/rad or rad/rad) below which the arm hardly moves in a direction."
LEVER = 0.1
"Metres that an error of one radian counts as."
DAMPING = 0.01
"Damping of the least squares by which motion is planned, m/rad."
_INVERSE_STEPS = 300
_REACHED = 1e-6
"Largest remaining error, metres or radians, at which the goal counts as reached."


class Chain(ABC):
    """Joints between a fixed base and a tool. Angles are radians. Any thread."""

    def __init__(
        self, name: str, joint_names: Sequence[str], low: ArrayLike, high: ArrayLike, fastest: ArrayLike
    ) -> None:
        """`low` and `high` are each joint's limits, radians; `fastest` its highest speed, rad/s."""
        self.name = name
        self.joint_names = tuple(joint_names)
        self.low = np.asarray(low, np.float64)
        self.high = np.asarray(high, np.float64)
        self.fastest = np.asarray(fastest, np.float64)

    @abstractmethod
    def frames(self, angles: ArrayLike) -> list[Pose]:
        """Return the poses of the base, each link in turn, and the tool."""

    @abstractmethod
    def jacobian(self, angles: ArrayLike) -> NDArray[np.float64]:
        """Return (6, joints): the tool's twist for each joint's rad/s."""

    def forward(self, angles: ArrayLike) -> Pose:
        """Return the tool's pose."""
        return self.frames(angles)[-1]

    def checked(self, angles: ArrayLike) -> Vector:
        """Return the angles as an array. Raises UsageError if they are too few, too many or not finite."""
        array = np.asarray(angles, np.float64)
        if array.shape != self.low.shape or not np.isfinite(array).all():
            raise UsageError(f"{self.name} has {len(self.low)} joints; {array.tolist()} are not their angles")
        return array

    def clamped(self, angles: Vector) -> Vector:
        """Return the nearest angles within the limits."""
        return np.clip(angles, self.low, self.high)

    def limited(self, velocities: Vector) -> Vector:
        """Return the same direction of motion within each joint's highest speed."""
        return velocities / max(1.0, self.excess(velocities))

    def excess(self, velocities: Vector) -> float:
        """Return the largest ratio of a joint's speed to its highest one."""
        return float(np.max(np.abs(velocities) / self.fastest))

    def velocities_for(self, angles: Vector, twist: Vector, damping: float = 0.02) -> Vector:
        """Return `response`, slowed down so that no joint exceeds its highest speed."""
        return self.limited(self.response(angles, twist, damping))

    def response(self, angles: Vector, twist: Vector, damping: float = 0.02) -> Vector:
        """Return the joint velocities whose tool twist is nearest to `twist`, as a Cartesian controller does.

        Damped least squares keep velocities finite near singular poses. A joint at its limit that would move
        outwards is held, and the others compensate; metres then count as much as radians, so the tool may
        become faster than `twist`.
        """
        low = np.where(angles <= self.low + 1e-6, 0.0, -np.inf)
        high = np.where(angles >= self.high - 1e-6, 0.0, np.inf)
        return _least_squares(self.jacobian(angles), twist, low, high, damping)

    def attainable(self, angles: Vector, twist: Vector, seconds: float) -> Vector:
        """Return the tool's twist nearest to `twist` that lasts for `seconds` within the joints' limits.

        A controller with any solver follows it, as the tool can do exactly that. A radian counts as `LEVER`
        metres: the tool turns less before it leaves its line.
        """
        jacobian, weight = self.jacobian(angles), np.repeat((1.0, LEVER), 3)
        low, high = (np.minimum(self.low - angles, 0.0), np.maximum(self.high - angles, 0.0))
        velocities = _least_squares(
            weight[:, None] * jacobian, weight * twist, low / seconds, high / seconds, DAMPING
        )
        found: Vector = jacobian @ velocities
        return found

    def hindrance(self, angles: Vector, twist: Vector) -> str:
        """Return why the tool cannot follow a twist, as display text; empty if it can."""
        jacobian = self.jacobian(angles)
        wanted = jacobian.T @ np.linalg.solve(jacobian @ jacobian.T + 0.02**2 * np.eye(6), twist)
        limited = self._outwards(angles, wanted, AT_LIMIT)
        if limited.any():
            names = [name for name, there in zip(self.joint_names, limited, strict=True) if there]
            return f"{' and '.join(names)} {'is at its limit' if len(names) == 1 else 'are at their limits'}"
        directions, strengths, _ = np.linalg.svd(jacobian)
        share = np.abs(directions.T @ twist)
        if (share[strengths < STRETCHED] > 0.3 * np.linalg.norm(twist)).any():
            return f"{self.name} is stretched or folded so that it cannot move that way"
        return ""

    def inverse(self, goal: Pose, start: ArrayLike) -> Vector | None:
        """Return angles within the limits that bring the tool to `goal`; None if none are found."""
        angles: Vector = self.checked(start).copy()
        for _ in range(_INVERSE_STEPS):
            error = diff(self.forward(angles), goal)
            if float(np.abs(error).max()) < _REACHED:
                return angles
            moved = self.velocities_for(angles, error, damping=1e-3)
            angles = self.clamped(angles + np.clip(moved, -0.2, 0.2))
        return None

    def _outwards(self, angles: Vector, velocities: Vector, margin: float) -> NDArray[np.bool_]:
        """Return the joints at a limit that such velocities would drive further."""
        outwards: NDArray[np.bool_] = ((angles <= self.low + margin) & (velocities < 0)) | (
            (angles >= self.high - margin) & (velocities > 0)
        )
        return outwards


def _least_squares(
    jacobian: NDArray[np.float64], twist: Vector, low: Vector, high: Vector, damping: float
) -> Vector:
    """Return the joint velocities from `low` to `high` whose twist is nearest to `twist`, damped."""
    velocities, free = np.zeros(len(low)), np.ones(len(low), bool)
    while free.any():
        part = jacobian[:, free]
        left = twist - jacobian[:, ~free] @ velocities[~free]
        velocities[free] = part.T @ np.linalg.solve(part @ part.T + damping**2 * np.eye(6), left)
        beyond = free & ((velocities < low) | (velocities > high))
        if not beyond.any():
            break
        velocities[beyond] = np.clip(velocities, low, high)[beyond]
        free &= ~beyond
    return velocities
