"""Chains of rotary joints, and distances from an arm to the robot's body and to obstacles. No I/O.

A chain computes poses, Jacobians and joint velocities, and names what hinders a motion. Arms and bodies are
capsules (a segment and a radius), obstacles are boxes along the base's axes; metres, in the robot's base.
Shapes must enclose what they represent, so that distances are never larger than the true ones.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grabbergui.calibration.geometry import Pose, Vector, diff
from grabbergui.core.errors import UsageError

# -- chains --------------------------------------------------------------------------------------
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


# -- distances -----------------------------------------------------------------------------------
_SAMPLES = 65
"Number of points of a segment at which distances to boxes are computed."
_SHARES = np.linspace(0.0, 1.0, _SAMPLES)[:, None]
"Their places along the segment, 0 to 1."

_POINT = 1e-24
"A segment whose squared length is below this, in square metres, is a point."


@dataclass(frozen=True)
class Clearance:
    """The smallest distance, and the two shapes."""

    distance: float
    "Metres; negative where the shapes overlap."
    part: str
    other: str


FREE = Clearance(math.inf, "", "")
"Nothing is near."


@dataclass(frozen=True, eq=False)
class Capsule:
    """All points within `radius` of the segment from `start` to `end`."""

    name: str
    start: Vector
    end: Vector
    radius: float


@dataclass(frozen=True, eq=False)
class Box:
    """An obstacle between two corners in the base."""

    name: str
    low: Vector
    high: Vector


class Body(ABC):
    """The shapes of one robot. Any thread."""

    @abstractmethod
    def nearest(self, arm: Vector) -> Clearance:
        """Return the smallest distance from the arm to the body at joint angles (radians)."""

    @abstractmethod
    def capsules(self, arm: Vector) -> list[Capsule]:
        """Return the capsules of the arm's moving links at joint angles, for distances to boxes."""


class CapsuleBody(Body):
    """An arm whose links are capsules from frame to frame, and fixed capsules for everything else."""

    def __init__(
        self, chain: Chain, radii: Sequence[float], fixed: Sequence[Capsule], guarded_from: int = 0
    ) -> None:
        """`radii` are those of the segments between the chain's successive frames; the tool's is the last.

        The segments before `guarded_from` are attached to the body and cannot touch it.
        """
        self._chain, self._radii, self._fixed = chain, tuple(radii), tuple(fixed)
        self._guarded_from = guarded_from

    def nearest(self, arm: Vector) -> Clearance:
        """Compare every guarded link with every fixed capsule."""
        contacts = [
            Clearance(
                _segment_distance(link.start, link.end, part.start, part.end) - link.radius - part.radius,
                link.name,
                part.name,
            )
            for link in self.capsules(arm)
            for part in self._fixed
        ]
        return min(contacts, key=lambda contact: contact.distance, default=FREE)

    def capsules(self, arm: Vector) -> list[Capsule]:
        """Return one for each segment that can touch anything, named by the joint at its start."""
        points = [frame[:3, 3] for frame in self._chain.frames(arm)]
        names = (*self._chain.joint_names, "the hand")
        segments = zip(names, points, points[1:], self._radii, strict=False)
        links = [Capsule(name, start, end, radius) for name, start, end, radius in segments]
        return links[self._guarded_from :]


def nearest_box(capsules: Sequence[Capsule], boxes: Sequence[Box]) -> Clearance:
    """Return the smallest distance from capsules to boxes."""
    contacts = [
        Clearance(_box_distance(capsule.start, capsule.end, box) - capsule.radius, capsule.name, box.name)
        for capsule in capsules
        for box in boxes
    ]
    return min(contacts, key=lambda contact: contact.distance, default=FREE)


def parse_boxes(text: str) -> tuple[Box, ...]:
    """Read a configuration's boxes: `table 0.3 0.9 -0.5 0.5 -0.9 -0.2; …`: name, then x, y and z.

    Each axis has its low and its high end, metres. Raises UsageError with the entry that is wrong.
    """
    boxes = []
    for entry in filter(None, map(str.strip, text.split(";"))):
        name, *words = entry.split()
        try:
            numbers = np.array([float(word) for word in words])
        except ValueError:
            raise UsageError(f"[safety] obstacles: '{entry}' has something that is no number") from None
        low, high = numbers[::2], numbers[1::2]
        if len(numbers) != 6 or not np.isfinite(numbers).all() or not (low < high).all():
            raise UsageError(
                f"[safety] obstacles: '{entry}' must be a name and, in metres, "
                "x_low x_high y_low y_high z_low z_high"
            )
        boxes.append(Box(name, low, high))
    return tuple(boxes)


def _segment_distance(a: Vector, b: Vector, c: Vector, d: Vector) -> float:
    """Return the distance between two segments, a to b and c to d; both may be points.

    It is right to a micrometre for a robot's links. Of nearly parallel segments, it compares the ends.
    """
    u, v, w = b - a, d - c, a - c
    uu, uv, vv, uw, vw = float(u @ u), float(u @ v), float(v @ v), float(u @ w), float(v @ w)
    determinant = uu * vv - uv * uv
    s = min(max((uv * vw - vv * uw) / determinant, 0.0), 1.0) if determinant > 1e-14 * uu * vv else 0.0
    t = (uv * s + vw) / vv if vv > _POINT else 0.0
    t = min(max(t, 0.0), 1.0)
    s = min(max((uv * t - uw) / uu, 0.0), 1.0) if uu > _POINT else 0.0
    apart = w + s * u - t * v
    return math.sqrt(float(apart @ apart))  # numpy's norm takes three times as long


def _box_distance(start: Vector, end: Vector, box: Box) -> float:
    """Return the distance from a segment to a box, at most half a sample too small; negative inside.

    A signed distance changes no faster than the place, so between samples it cannot be smaller than that.
    """
    points = start + _SHARES * (end - start)
    off = np.maximum(box.low - points, points - box.high)
    outside = np.linalg.norm(np.maximum(off, 0.0), axis=1)
    signed = np.where(outside > 0, outside, off.max(axis=1))
    spacing = float(np.linalg.norm(end - start)) / (_SAMPLES - 1)
    return float(signed.min()) - spacing / 2
