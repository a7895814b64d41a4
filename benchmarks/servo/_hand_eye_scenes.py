"""Simulated hand–eye calibrations with joint offsets, noisy corners, and the ground truth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grabbergui.calibration import geometry
from grabbergui.calibration.geometry import Pose
from grabbergui.core.calibration import Calibration
from grabbergui.servo.hand_eye.measurement import (
    Arrangement,
    Guess,
    HandEyeMeasurement,
    Problem,
    camera_from_target,
    information,
)
from grabbergui.servo.hand_eye.proposals import propose
from grabbergui.servo.kinematics import Chain
from grabbergui.servo.robots import teo

CAMERA = Calibration.from_field_of_view(1280, 960, 62)
GRID = np.array([(0.025 * x, 0.025 * y, 0.0) for y in range(-2, 3) for x in range(-3, 4)])
"Corners of a board of 15 × 10 cm, metres; z points towards the viewer."
KINDS = ("eye in head", "eye in hand", "eye to hand", "head and hand")


@dataclass
class Scene:
    arrangement: Arrangement
    truth: Guess
    "The true parameters, including joint offsets that have no effect on images."
    nominal: Guess
    "The parameters of the robot's drawings."


def scene(kind: str, degrees: float = 0.2, seed: int = 0) -> Scene:
    """Return a TEO with joint offsets of ±`degrees` and a camera off by some millimetres and degrees."""
    random = np.random.default_rng(seed)
    head, arm = teo.HEAD, teo.RIGHT_ARM
    camera_chain = {"eye in head": head, "head and hand": head, "eye in hand": arm}.get(kind)
    target_chain = {"eye to hand": arm, "head and hand": arm}.get(kind)
    home_eye = np.eye(4) if camera_chain is None else _posture(camera_chain)
    home_held = np.eye(4) if target_chain is None else _posture(target_chain)
    if kind == "eye in hand":
        camera = geometry.pose(geometry.rotation_from_vector((0.1, -0.2, 0.3)), (0.03, -0.05, 0.04))
        eye = home_eye @ camera
        held = eye @ facing(0.45)
    elif kind == "eye in head":
        camera = teo.CAMERA_ON_HEAD
        held = home_eye @ camera @ facing(0.6)
    else:
        target = geometry.pose(geometry.rotation_from_vector((0.2, 0.1, -0.4)), (0.02, 0.01, 0.06))
        held = home_held @ target
        if kind == "eye to hand":
            camera = held @ geometry.inverse(facing(0.6))
        else:
            camera = teo.CAMERA_ON_HEAD
            # The board is held so that the head sees it when both are at their middle posture.
            held = home_eye @ camera @ facing(0.6)
    target = geometry.inverse(home_held) @ held
    offsets = [
        np.radians(degrees) * random.choice((-1.0, 1.0), 0 if chain is None else len(chain.low))
        for chain in (camera_chain, target_chain)
    ]
    off = np.concatenate((random.normal(0, 0.004, 3), random.normal(0, np.radians(1.5), 3)))
    none = [np.zeros_like(offset) for offset in offsets]
    truth = Guess(geometry.add_delta(camera, off), target, *offsets)
    return Scene(Arrangement(camera_chain, target_chain), truth, Guess(camera, target, *none))


def facing(metres: float) -> Pose:
    """Return the pose of a board in front of a camera, at a distance and facing it."""
    return geometry.pose(np.diag([1.0, -1.0, -1.0]), (0.0, 0.0, metres))


def views(
    of: Scene, count: int = 30, pixel: float = 0.5, seed: int = 1, reading: float = 0.0
) -> list[HandEyeMeasurement]:
    """Return the views from the poses proposed for the nominal robot; encoder noise is `reading` degrees."""
    random, noise = np.random.default_rng(seed), np.radians(reading)
    seen = []
    for camera, target in propose(of.arrangement, of.nominal, GRID, CAMERA, count):
        true_camera = camera + random.normal(0, noise, camera.shape)
        true_target = target + random.normal(0, noise, target.shape)
        pose = camera_from_target(of.arrangement, of.truth, true_camera, true_target)
        in_camera = GRID @ pose[:3, :3].T + pose[:3, 3]
        pixels = (in_camera / in_camera[:, 2:]) @ CAMERA.matrix.T
        noisy = pixels[:, :2] + random.normal(0, pixel, (len(GRID), 2))
        seen.append(HandEyeMeasurement(camera, target, GRID, noisy))
    return seen


def observable(of: Scene) -> Pose:
    """Return the camera's true pose, including the offsets that images cannot tell from it."""
    truth, (camera, target) = of.truth, of.arrangement.free_offsets()
    eye = truth.camera
    if of.arrangement.camera is not None:
        chain, last = of.arrangement.camera, np.zeros(len(camera))
        last[-1] = truth.camera_offsets[-1]
        eye = geometry.inverse(chain.forward(0 * last)) @ chain.forward(last) @ eye
    elif of.arrangement.target is not None:
        chain, first = of.arrangement.target, np.zeros(len(target))
        first[0] = truth.target_offsets[0]
        eye = chain.forward(0 * first) @ geometry.inverse(chain.forward(first)) @ eye
    return eye


def spread(of: Scene, seen: list[HandEyeMeasurement]) -> float:
    """Return the standard deviation of the camera's position, metres, for corner noise of 0.5 px."""
    known = information(Problem(of.arrangement, CAMERA), seen, of.nominal, 0.5)
    known += 1e-6 * np.eye(len(known))
    return float(np.sqrt(np.diag(np.linalg.inv(known))[:3].sum()))


def _posture(chain: Chain) -> Pose:
    return chain.forward((chain.low + chain.high) / 2)
