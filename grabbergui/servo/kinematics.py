"""A chain of rotary joints in classic Denavit–Hartenberg parameters: pose, Jacobian, joint velocities."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grabbergui.core.errors import UsageError
from grabbergui.servo.geometry import Pose, Vector, diff


@dataclass(frozen=True)
class Joint:
    """One link of the table and the joint that moves it; degrees and metres, as tables have them."""

    name: str
    offset: float
    d: float
    a: float
    alpha: float
    low: float
    high: float
    fastest: float
    "Degrees per second."

    def frame(self, angle: float) -> Pose:
        """The link's end as seen from its start, the joint at `angle` radians."""
        theta, twist = angle + math.radians(self.offset), math.radians(self.alpha)
        ct, st, ca, sa = math.cos(theta), math.sin(theta), math.cos(twist), math.sin(twist)
        return np.array(
            [
                [ct, -st * ca, st * sa, self.a * ct],
                [st, ct * ca, -ct * sa, self.a * st],
                [0.0, sa, ca, self.d],
                [0.0, 0.0, 0.0, 1.0],
            ]
        )


@dataclass(frozen=True, eq=False)
class Chain:
    """Joints between a fixed base and a tool. Angles are radians."""

    name: str
    base: Pose
    joints: tuple[Joint, ...]
    tool: Pose

    @cached_property
    def low(self) -> Vector:
        """Lowest angle of each joint."""
        return np.radians([joint.low for joint in self.joints])

    @cached_property
    def high(self) -> Vector:
        """Highest angle of each joint."""
        return np.radians([joint.high for joint in self.joints])

    @cached_property
    def fastest(self) -> Vector:
        """Highest speed of each joint, rad/s."""
        return np.radians([joint.fastest for joint in self.joints])

    def checked(self, angles: ArrayLike) -> Vector:
        """The angles as an array. Raises UsageError where they are too few, too many or not finite."""
        array = np.asarray(angles, np.float64)
        if array.shape != (len(self.joints),) or not np.isfinite(array).all():
            raise UsageError(
                f"{self.name} has {len(self.joints)} joints; {array.tolist()} are not their angles"
            )
        return array

    def frames(self, angles: ArrayLike) -> list[Pose]:
        """The poses of base, every joint's axis (z) in turn, and the tool; one more than two than joints."""
        poses = [self.base]
        for joint, angle in zip(self.joints, self.checked(angles), strict=True):
            poses.append(poses[-1] @ joint.frame(float(angle)))
        return [*poses, poses[-1] @ self.tool]

    def forward(self, angles: ArrayLike) -> Pose:
        """The tool's pose."""
        return self.frames(angles)[-1]

    def jacobian(self, angles: ArrayLike) -> NDArray[np.float64]:
        """(6, joints): the tool's twist for each joint's rad/s."""
        frames = self.frames(angles)
        tip = frames[-1][:3, 3]
        columns = []
        for frame in frames[: len(self.joints)]:
            axis = frame[:3, 2]
            columns.append(np.concatenate((np.cross(axis, tip - frame[:3, 3]), axis)))
        return np.column_stack(columns)

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
        free = np.ones(len(self.joints), bool)
        velocities = np.zeros(len(self.joints))
        for _ in self.joints:
            part = jacobian[:, free]
            system = part @ part.T + damping**2 * np.eye(6)
            velocities[:] = 0.0
            velocities[free] = part.T @ np.linalg.solve(system, twist)
            outwards = ((angles <= self.low + 1e-6) & (velocities < 0)) | (
                (angles >= self.high - 1e-6) & (velocities > 0)
            )
            if not (outwards & free).any():
                break
            free &= ~outwards
            if not free.any():
                return np.zeros(len(self.joints))
        return self.limited(velocities)

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
