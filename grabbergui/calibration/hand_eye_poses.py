"""Which joint poses tell most about where the camera sits: proposals for a hand–eye calibration."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from grabbergui.calibration.geometry import Pose, Vector
from grabbergui.calibration.hand_eye_model import (
    Arrangement,
    Guess,
    HandEyeView,
    Joints,
    Problem,
    camera_from_target,
    information,
)
from grabbergui.core.calibration import Calibration
from grabbergui.core.errors import UsageError

STEEPEST = math.radians(60)
"Between the target's normal and the line of sight, beyond which corners are poorly seen."
MARGIN = 0.04
"Of the image's size that stays free around the target."
LIMIT_MARGIN = math.radians(3)
"Radians from a joint's limits that poses keep."
LEVER = 0.5
"Metres at which a turned camera is as bad as a displaced one."


def propose(
    arrangement: Arrangement,
    guess: Guess,
    points: NDArray[np.float64],
    calibration: Calibration,
    count: int,
    known: Sequence[HandEyeView] = (),
    tries: int = 4000,
    seed: int = 0,
) -> list[tuple[Vector, Vector]]:
    """Return joint angles (camera's chain, target's chain) of `count` poses that show the whole target.

    Poses are drawn within the joint limits; of those that show the target, each next one is chosen that
    leaves the least uncertainty of the camera (metres² plus radians² × `LEVER`²) after the views before it.
    They are geometry only: whether a robot may go there is its gate's decision. Raises UsageError if fewer
    poses show the target.
    """
    random, candidates = np.random.default_rng(seed), []
    problem = Problem(arrangement, calibration)
    for _ in range(tries):
        camera, target = _drawn(random, arrangement.camera), _drawn(random, arrangement.target)
        seen = camera_from_target(arrangement, guess, camera, target)
        pixels = _seen_whole(seen, points, calibration)
        if pixels is not None:
            candidates.append(HandEyeView(camera, target, points, pixels))
        if len(candidates) >= 8 * count:
            break
    if len(candidates) < count:
        raise UsageError(
            f"only {len(candidates)} of {tries} poses show the target; {count} are wanted. "
            "Move the target into the middle of what the camera sees, or take a smaller one"
        )
    gains = []
    for view in candidates:
        jacobian = problem.jacobian(view, guess)
        gains.append(jacobian.T @ jacobian)
    weights = np.array([1.0, 1.0, 1.0, LEVER**2, LEVER**2, LEVER**2])
    sum_known = information(problem, known, guess, 1.0) + 1e-6 * np.eye(problem.size)
    chosen: list[tuple[Vector, Vector]] = []
    for _ in range(count):
        left = [float(weights @ np.diag(np.linalg.inv(sum_known + gain))[:6]) for gain in gains]
        best = int(np.argmin(left))
        sum_known = sum_known + gains.pop(best)
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
    """Return the target's (n, 2) pixels; None where it is not seen, or too steeply."""
    import cv2

    in_camera = points @ target[:3, :3].T + target[:3, 3]
    if in_camera[:, 2].min() < 0.1:
        return None
    middle = in_camera.mean(axis=0)
    facing = -float(target[:3, 2] @ middle) / float(np.linalg.norm(middle))
    if facing < math.cos(STEEPEST):
        return None
    nothing = np.zeros(3)
    seen, _ = cv2.projectPoints(in_camera, nothing, nothing, calibration.matrix, calibration.distortion)
    pixels = np.asarray(seen, np.float64).reshape(-1, 2)
    size = np.array([calibration.width, calibration.height])
    inside = (pixels >= MARGIN * size).all() and (pixels <= (1 - MARGIN) * size).all()
    return pixels if inside else None
