"""A chain of rotary joints: pose, Jacobian, joint velocities, and what keeps it from moving as it should."""

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
"Singular value of the Jacobian (m/rad or rad/rad) below which a direction is as good as closed."


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
        """The poses of base, every link in turn, and the tool."""

    @abstractmethod
    def jacobian(self, angles: ArrayLike) -> NDArray[np.float64]:
        """(6, joints): the tool's twist for each joint's rad/s."""

    def forward(self, angles: ArrayLike) -> Pose:
        """The tool's pose."""
        return self.frames(angles)[-1]

    def checked(self, angles: ArrayLike) -> Vector:
        """The angles as an array. Raises UsageError where they are too few, too many or not finite."""
        array = np.asarray(angles, np.float64)
        if array.shape != self.low.shape or not np.isfinite(array).all():
            raise UsageError(f"{self.name} has {len(self.low)} joints; {array.tolist()} are not their angles")
        return array

    def clamped(self, angles: Vector) -> Vector:
        """The nearest angles within the limits."""
        return np.clip(angles, self.low, self.high)

    def limited(self, velocities: Vector) -> Vector:
        """The same direction of motion at no more than every joint's highest speed."""
        excess = float(np.max(np.abs(velocities) / self.fastest))
        return velocities / excess if excess > 1 else velocities

    def velocities_for(self, angles: Vector, twist: Vector, damping: float = 0.02) -> Vector:
        """Joint speeds whose tool twist comes nearest to `twist`, no joint running into its limit.

        Damped least squares: near singular postures it gives way instead of racing. A joint at its limit
        that would go on outwards is held, and the others share its work.
        """
        jacobian = self.jacobian(angles)
        free = np.ones(len(self.low), bool)
        velocities = np.zeros(len(self.low))
        for _ in self.low:
            part = jacobian[:, free]
            system = part @ part.T + damping**2 * np.eye(6)
            velocities[:] = 0.0
            velocities[free] = part.T @ np.linalg.solve(system, twist)
            outwards = self._outwards(angles, velocities, 1e-6)
            if not (outwards & free).any():
                break
            free &= ~outwards
            if not free.any():
                return np.zeros(len(self.low))
        return self.limited(velocities)

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

    def inverse(
        self, goal: Pose, start: ArrayLike, steps: int = 300, tolerance: float = 1e-6
    ) -> Vector | None:
        """Angles that bring the tool to `goal`, found from `start` within the limits; None if none are."""
        angles: Vector = self.checked(start).copy()
        for _ in range(steps):
            error = diff(self.forward(angles), goal)
            if float(np.abs(error).max()) < tolerance:
                return angles
            moved = self.velocities_for(angles, error, damping=1e-3)
            angles = self.clamped(angles + np.clip(moved, -0.2, 0.2))
        return None

    def _outwards(self, angles: Vector, velocities: Vector, margin: float) -> NDArray[np.bool_]:
        """Joints at a limit that such velocities would drive further."""
        outwards: NDArray[np.bool_] = ((angles <= self.low + margin) & (velocities < 0)) | (
            (angles >= self.high - margin) & (velocities > 0)
        )
        return outwards
