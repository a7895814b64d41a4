"""The geometry of hand–eye calibration: arrangements, unknowns, residuals and their derivatives.

One model covers every arrangement. Camera and target are each mounted on a chain of joints or fixed: the
camera is on a chain for eye in head and eye in hand, the target for eye to hand, and both for a head that
looks at a board in the hand. The unknowns are the pose of the camera on its chain's tool, that of the target,
and the constant offsets of the joints.

Two offsets cannot be separated from these poses and remain zero: that of a chain's last joint, which rotates
the tool like the camera's own rotation, and, if the other side is fixed, that of the first joint, which
rotates the whole scene.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from grabbergui.calibration import geometry
from grabbergui.calibration.geometry import Pose, Vector
from grabbergui.core.calibration import Calibration
from grabbergui.core.errors import UsageError

OFFSET_SPREAD = math.radians(0.5)
"Expected standard deviation of joint offsets, before any measurement."


class Joints(Protocol):
    """A chain of rotary joints, as `servo.kinematics` has them."""

    @property
    def low(self) -> Vector:
        """Lower limit of every joint, radians."""
        ...

    @property
    def high(self) -> Vector:
        """Upper limit of every joint, radians."""
        ...

    def forward(self, angles: Vector) -> Pose:
        """Return the tool's pose in the base."""
        ...

    def jacobian(self, angles: Vector) -> NDArray[np.float64]:
        """Return (6, joints): the tool's twist in the base for each joint's rad/s."""
        ...


@dataclass(frozen=True)
class Arrangement:
    """The chains of the camera and of the target; None for one that is fixed in the base."""

    camera: Joints | None
    target: Joints | None

    def __post_init__(self) -> None:
        if self.camera is None and self.target is None:
            raise UsageError("nothing moves: camera or target must be on a chain of joints")

    def free_offsets(self) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Return which joint offsets of the camera's and of the target's chain can be found."""
        camera, target = (
            np.ones(0 if chain is None else len(chain.low), bool) for chain in (self.camera, self.target)
        )
        for own, other in ((camera, target), (target, camera)):
            own[-1:] = False
            if not other.size:
                own[:1] = False
        return camera, target


@dataclass(frozen=True, eq=False)
class HandEyeMeasurement:
    """The target in an image, and the joint readings."""

    camera_angles: Vector
    "Radians; empty for a fixed camera."
    target_angles: Vector
    "Radians; empty for a fixed target."
    points: NDArray[np.float64]
    "(n, 3) corners in the target's frame, metres."
    pixels: NDArray[np.float64]
    "(n, 2) the same corners in the image, pixels."


@dataclass(frozen=True, eq=False)
class Guess:
    """An estimate of the unknowns of a hand–eye calibration."""

    camera: Pose
    "The optical frame on its chain's tool, or in the base."
    target: Pose
    "The target on its chain's tool, or in the base."
    camera_offsets: Vector
    "Radians to add to the readings of the camera's chain."
    target_offsets: Vector
    "Radians to add to the readings of the target's chain."


def camera_from_target(arrangement: Arrangement, guess: Guess, camera: Vector, target: Vector) -> Pose:
    """Return the target's pose in the camera's optical frame for joint readings."""
    eye, held = guess.camera, guess.target
    if arrangement.camera is not None:
        eye = arrangement.camera.forward(camera + guess.camera_offsets) @ eye
    if arrangement.target is not None:
        held = arrangement.target.forward(target + guess.target_offsets) @ held
    return geometry.inverse(eye) @ held


class Problem:
    """The residuals of an arrangement and their derivatives.

    Parameters are small changes to a guess: camera (6) and target (6), each in metres along and radians about
    the axes of its mount, then the joint offsets that can be found.
    """

    def __init__(self, arrangement: Arrangement, calibration: Calibration) -> None:
        self.arrangement, self.calibration = arrangement, calibration
        self._free = arrangement.free_offsets()
        self.size = 12 + int(self._free[0].sum() + self._free[1].sum())

    def prior(self, guess: Guess) -> Vector:
        """Return the offsets divided by their expected spread, as residuals that keep them small."""
        offsets = (guess.camera_offsets[self._free[0]], guess.target_offsets[self._free[1]])
        return np.concatenate(offsets) / OFFSET_SPREAD

    def changed(self, guess: Guess, change: Vector) -> Guess:
        """Return the guess after a small change of the parameters."""
        offsets, start = [], 12
        for free, before in zip(self._free, (guess.camera_offsets, guess.target_offsets), strict=True):
            after, end = before.copy(), start + int(free.sum())
            after[free] += change[start:end]
            offsets.append(after)
            start = end
        return Guess(
            geometry.add_delta(guess.camera, change[:6]),
            geometry.add_delta(guess.target, change[6:12]),
            *offsets,
        )

    def residuals(self, view: HandEyeMeasurement, guess: Guess) -> Vector:
        """Return (2 n,) pixels from the detected corners to those expected by the guess."""
        return self.residuals_at(
            view, camera_from_target(self.arrangement, guess, view.camera_angles, view.target_angles)
        )

    def residuals_at(self, view: HandEyeMeasurement, pose: Pose) -> Vector:
        """Return the same for the target's pose in the camera's optical frame."""
        seen, _ = cv2.projectPoints(
            view.points,
            geometry.vector_from_rotation(pose[:3, :3]),
            pose[:3, 3],
            self.calibration.matrix,
            self.calibration.pinhole_distortion,
        )
        return np.ravel(np.asarray(seen, np.float64).reshape(-1, 2) - view.pixels)

    def jacobian(self, view: HandEyeMeasurement, guess: Guess) -> NDArray[np.float64]:
        """Return (2 n, size): the residuals' derivatives by the parameters."""
        findable = np.concatenate((np.ones(12, bool), *self._free))
        return self._derivatives(view, guess)[:, findable]

    def by_readings(self, view: HandEyeMeasurement, guess: Guess) -> NDArray[np.float64]:
        """Return (2 n, joints): the residuals' derivatives by the readings of all joints."""
        return self._derivatives(view, guess)[:, 12:]

    def _derivatives(self, view: HandEyeMeasurement, guess: Guess) -> NDArray[np.float64]:
        """Return (2 n, 12 + joints): derivatives by both poses, then by all joints of both chains.

        A parameter moves the camera or the target by a twist. That displaces each corner in the camera's
        frame, and OpenCV gives the pixels' derivatives by a displacement.
        """
        eye, eye_twists, eye_joints = _motion(
            self.arrangement.camera, view.camera_angles + guess.camera_offsets, guess.camera
        )
        held, held_twists, held_joints = _motion(
            self.arrangement.target, view.target_angles + guess.target_offsets, guess.target
        )
        corners = view.points @ held[:3, :3].T + held[:3, 3]
        by_eye = -_displacements(np.vstack((eye_twists, eye_joints)), corners - eye[:3, 3])
        by_held = _displacements(np.vstack((held_twists, held_joints)), corners - held[:3, 3])
        moved = np.concatenate((by_eye[:6], by_held[:6], by_eye[6:], by_held[6:])) @ eye[:3, :3]
        nothing = np.zeros(3)
        _, by_all = cv2.projectPoints(
            (corners - eye[:3, 3]) @ eye[:3, :3],
            nothing,
            nothing,
            self.calibration.matrix,
            self.calibration.pinhole_distortion,
        )
        by_place = np.asarray(by_all, np.float64)[:, 3:6].reshape(-1, 2, 3)  # 3 of rotation come first
        pixels: NDArray[np.float64] = np.einsum("nij,knj->nik", by_place, moved)
        return pixels.reshape(2 * len(corners), -1)

    def error(self, view: HandEyeMeasurement, guess: Guess) -> float:
        """Return the root mean square distance of a view's corners, pixels."""
        return root_mean_square(self.residuals(view, guess))


def root_mean_square(residuals: Vector) -> float:
    """Return the root mean square distance of corners whose residuals are these, pixels."""
    return math.sqrt(float(residuals @ residuals) / (len(residuals) // 2))


def _motion(
    chain: Joints | None, angles: Vector, mounted: Pose
) -> tuple[Pose, NDArray[np.float64], NDArray[np.float64]]:
    """Return the pose in the base of a part mounted on a chain's tool, and the twists that move it.

    (6, 6) twists are along and about the axes of the tool; (joints, 6) are those of the joints.
    """
    tool = np.eye(4) if chain is None else chain.forward(angles)
    place = tool @ mounted
    twists = np.zeros((6, 6))
    twists[:3, :3] = twists[3:, 3:] = tool[:3, :3].T
    if chain is None:
        return place, twists, np.zeros((0, 6))
    joints = chain.jacobian(angles).T
    joints[:, :3] += geometry.cross(joints[:, 3:], place[:3, 3] - tool[:3, 3])
    return place, twists, joints


def _displacements(twists: NDArray[np.float64], arms: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (k, n, 3) velocities of n points at `arms` from the origin of k twists."""
    velocities: NDArray[np.float64] = twists[:, None, :3] + geometry.cross(twists[:, None, 3:], arms)
    return velocities


def information(
    problem: Problem, views: Sequence[HandEyeMeasurement], guess: Guess, pixel: float
) -> NDArray[np.float64]:
    """Return (size, size): the information of views and prior about the parameters.

    `pixel` is the standard deviation of corners in pixels.
    """
    known = np.zeros((problem.size, problem.size))
    known[12:, 12:] = np.eye(problem.size - 12) / OFFSET_SPREAD**2
    for view in views:
        jacobian = problem.jacobian(view, guess)
        known += jacobian.T @ jacobian / pixel**2
    return known
