"""Poses and twists. A pose is a (4, 4) float64 matrix that takes coordinates of its frame to the base's.

A twist is (6,) float64, as in KDL's `diff` and `addDelta`: the velocity of the frame's origin in m/s, then
the angular velocity in rad/s, both along the axes of the base.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

Pose = NDArray[np.float64]
Vector = NDArray[np.float64]


def pose(rotation: ArrayLike | None = None, translation: ArrayLike = (0.0, 0.0, 0.0)) -> Pose:
    """Return the pose of a (3, 3) rotation and a position in metres."""
    matrix = np.eye(4)
    if rotation is not None:
        matrix[:3, :3] = rotation
    matrix[:3, 3] = translation
    return matrix


def inverse(matrix: Pose) -> Pose:
    """Return the pose of the base in the frame."""
    rotation = matrix[:3, :3].T
    return pose(rotation, -rotation @ matrix[:3, 3])


def cross(first: Vector, second: Vector) -> Vector:
    """Return (…, 3) cross products of (…, 3) vectors; for a few vectors four times as fast as numpy's."""
    after, last = [1, 2, 0], [2, 0, 1]
    product: Vector = first[..., after] * second[..., last] - first[..., last] * second[..., after]
    return product


def rotation_from_vector(vector: ArrayLike) -> NDArray[np.float64]:
    """Return the (3, 3) rotation of axis × angle in radians (Rodrigues)."""
    x, y, z = (float(value) for value in np.asarray(vector, np.float64))
    angle = math.sqrt(x * x + y * y + z * z)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    if angle < 1e-12:
        small: NDArray[np.float64] = np.eye(3) + cross
        return small
    first = math.sin(angle) / angle
    second = (1 - math.cos(angle)) / angle**2
    rotation: NDArray[np.float64] = np.eye(3) + first * cross + second * (cross @ cross)
    return rotation


def vector_from_rotation(rotation: NDArray[np.float64]) -> Vector:
    """Return axis × angle in radians, with an angle from 0 to π; the inverse of `rotation_from_vector`."""
    twice, sine, cosine = _turn(rotation)
    angle = math.atan2(sine, cosine)
    if sine > 1e-6:
        return np.array(twice) * (angle / (2 * sine))
    if cosine > 0:
        return np.array(twice) / 2
    # Half a turn: R + I = 2 · axis · axisᵀ, whose largest column gives the most accurate axis.
    outer = rotation + np.eye(3)
    column = outer[:, int(np.argmax(np.diag(outer)))]
    half_turn: Vector = column / np.linalg.norm(column) * angle
    return half_turn


def _turn(rotation: NDArray[np.float64]) -> tuple[tuple[float, float, float], float, float]:
    """Return 2 · sine · axis, sine and cosine of the angle, as floats: arrays of three are slower."""
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = rotation.tolist()
    x, y, z = zy - yz, xz - zx, yx - xy
    return (x, y, z), math.hypot(x, y, z) / 2, (xx + yy + zz - 1) / 2


def rotation_from_quaternion(x: float, y: float, z: float, w: float) -> NDArray[np.float64]:
    """Return the (3, 3) rotation of a quaternion of any length; NaN if its length is zero."""
    norm = math.sqrt(x * x + y * y + z * z + w * w)
    if not norm > 0:
        return np.full((3, 3), np.nan)
    x, y, z, w = x / norm, y / norm, z / norm, w / norm
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def quaternion_from_rotation(rotation: NDArray[np.float64]) -> tuple[float, float, float, float]:
    """Return the quaternion x y z w of a (3, 3) rotation, with w not negative."""
    vector = vector_from_rotation(rotation)
    angle = float(np.linalg.norm(vector))
    x, y, z = vector * (math.sin(angle / 2) / angle if angle > 0 else 0.5)
    return float(x), float(y), float(z), math.cos(angle / 2)


def pose_from_vector(values: ArrayLike) -> Pose:
    """Return the pose of x y z in metres and a rotation vector in radians, as in YARP's Cartesian control."""
    numbers = np.asarray(values, np.float64)
    return pose(rotation_from_vector(numbers[3:6]), numbers[:3])


def vector_from_pose(matrix: Pose) -> Vector:
    """Return position in metres and rotation vector in radians, the inverse of `pose_from_vector`."""
    return np.concatenate((matrix[:3, 3], vector_from_rotation(matrix[:3, :3])))


def diff(start: Pose, end: Pose) -> Vector:
    """Return the constant twist that moves `start` to `end` in one second; KDL's `diff`."""
    turn = start[:3, :3] @ vector_from_rotation(start[:3, :3].T @ end[:3, :3])
    return np.concatenate((end[:3, 3] - start[:3, 3], turn))


def add_delta(start: Pose, twist: Vector) -> Pose:
    """Return the pose after one second of a constant twist; KDL's `addDelta`."""
    return pose(rotation_from_vector(twist[3:]) @ start[:3, :3], start[:3, 3] + twist[:3])


def angle_between(first: Pose, second: Pose) -> float:
    """Return the angle between the rotations of two poses, radians."""
    _, sine, cosine = _turn(first[:3, :3].T @ second[:3, :3])
    return math.atan2(sine, cosine)


def distance(first: Pose, second: Pose) -> float:
    """Return the metres between the origins of two poses."""
    return math.dist(first[:3, 3].tolist(), second[:3, 3].tolist())


def is_pose(matrix: NDArray[np.float64]) -> bool:
    """Return whether a matrix is finite and a rotation with a position; results of failed solvers are not."""
    if matrix.shape != (4, 4) or not np.isfinite(matrix).all():
        return False
    rotation = matrix[:3, :3]
    (a, b, c), (d, e, f), (g, h, i) = rotation.tolist()
    determinant = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    return determinant > 0 and bool(np.abs(rotation @ rotation.T - np.eye(3)).max() < 1e-3)
