"""Distances from an arm to the robot's body and to obstacles. No I/O.

Arms and bodies are capsules (a segment and a radius), obstacles are boxes along the base's axes; metres, in
the robot's base. Shapes must enclose what they represent, so that distances are never larger than the true
ones.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from grabbergui.calibration.geometry import Vector
from grabbergui.core.errors import UsageError
from grabbergui.servo.kinematics import Chain

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
