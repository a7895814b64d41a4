"""Joint poses that show the whole target and determine the camera's pose best."""

from __future__ import annotations

import math
from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.calibration.geometry import Pose, Vector
from grabbergui.core.calibration import Calibration
from grabbergui.core.errors import CalibrationError
from grabbergui.servo.hand_eye.measurement import (
    Arrangement,
    Guess,
    HandEyeMeasurement,
    Joints,
    Problem,
    camera_from_target,
    information,
)

STEEPEST = math.radians(60)
"Largest angle between the target's normal and the line of sight; corners are poorly visible beyond it."
MARGIN = 0.04
"Free margin around the target, relative to the image's size."
LIMIT_MARGIN = math.radians(3)
"Least distance of poses from a joint's limits, radians."
LEVER = 0.5
"Metres of displacement that count as much as a radian of rotation."


def propose(
    arrangement: Arrangement,
    guess: Guess,
    points: NDArray[np.float64],
    calibration: Calibration,
    count: int,
    known: Sequence[HandEyeMeasurement] = (),
    tries: int = 4000,
    seed: int = 0,
) -> list[tuple[Vector, Vector]]:
    """Return joint angles (camera's chain, target's chain) of `count` poses that show the whole target.

    Poses are drawn at random within the joint limits. Of those that show the target, each next one minimises
    the uncertainty of the camera (metres² plus radians² × `LEVER`²) after the views before it. Only geometry
    is considered; the robot's gate decides whether it may go there. Raises CalibrationError if fewer poses
    show the target.
    """
    random, candidates = np.random.default_rng(seed), []
    problem = Problem(arrangement, calibration)
    for _ in range(tries):
        camera, target = _drawn(random, arrangement.camera), _drawn(random, arrangement.target)
        seen = camera_from_target(arrangement, guess, camera, target)
        pixels = _seen_whole(seen, points, calibration)
        if pixels is not None:
            candidates.append(HandEyeMeasurement(camera, target, points, pixels))
        if len(candidates) >= 8 * count:
            break
    if len(candidates) < count:
        raise CalibrationError(
            f"only {len(candidates)} of {tries} poses show the target, {count} are wanted: "
            "move it, or take a smaller one"
        )
    jacobians = [problem.jacobian(view, guess) for view in candidates]
    gains = np.array([jacobian.T @ jacobian for jacobian in jacobians])
    weights = np.array([1.0, 1.0, 1.0, LEVER**2, LEVER**2, LEVER**2])
    sum_known = information(problem, known, guess, 1.0) + 1e-6 * np.eye(problem.size)
    chosen: list[tuple[Vector, Vector]] = []
    for _ in range(count):
        left = np.linalg.inv(sum_known + gains).diagonal(axis1=1, axis2=2)[:, :6] @ weights
        best = int(np.argmin(left))
        sum_known = sum_known + gains[best]
        gains = np.delete(gains, best, axis=0)
        view = candidates.pop(best)
        chosen.append((view.camera_angles, view.target_angles))
    return chosen


def _drawn(random: np.random.Generator, chain: Joints | None) -> Vector:
    if chain is None:
        return np.zeros(0)
    return random.uniform(chain.low + LIMIT_MARGIN, chain.high - LIMIT_MARGIN)


def _seen_whole(
    target: Pose, points: NDArray[np.float64], calibration: Calibration
) -> NDArray[np.float64] | None:
    """Return the target's (n, 2) pixels; None if it is not entirely visible, or seen too obliquely."""
    in_camera = points @ target[:3, :3].T + target[:3, 3]
    if in_camera[:, 2].min() < 0.1:
        return None
    middle = in_camera.mean(axis=0)
    facing = -float(target[:3, 2] @ middle) / float(np.linalg.norm(middle))
    if facing < math.cos(STEEPEST):
        return None
    nothing = np.zeros(3)
    seen, _ = cv2.projectPoints(
        in_camera, nothing, nothing, calibration.matrix, calibration.pinhole_distortion
    )
    pixels = np.asarray(seen, np.float64).reshape(-1, 2)
    size = np.array([calibration.width, calibration.height])
    inside = (pixels >= MARGIN * size).all() and (pixels <= (1 - MARGIN) * size).all()
    return pixels if inside else None
