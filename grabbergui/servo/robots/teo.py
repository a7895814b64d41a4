"""TEO's kinematic model: head and right arm with the trunk fixed, from classic Denavit–Hartenberg tables.

The base lies in the trunk: x forward, y left, z up. The tables are those of teo-configuration-files
(fixedTrunk-head, fixedTrunk-rightArm), with the head's limits from the older table.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import override

from grabbergui.calibration.geometry import Pose, cross, pose, rotation_from_vector
from grabbergui.servo.clearance import Capsule, CapsuleBody
from grabbergui.servo.kinematics import Chain
from grabbergui.servo.robots.robot import KinematicModel


@dataclass(frozen=True)
class Joint:
    """A row of the table: a link and the joint that moves it, in degrees and metres."""

    name: str
    offset: float
    d: float
    a: float
    alpha: float
    low: float
    high: float
    fastest: float
    "Degrees per second."

    def link(self) -> tuple[Pose, Pose, Pose]:
        """Return (4, 4) shares of the pose of the link's end in its start's frame.

        The first counts as often as the cosine of theta (the joint's angle and the offset), the second as
        its sine, the third once.
        """
        ca, sa = math.cos(math.radians(self.alpha)), math.sin(math.radians(self.alpha))
        cosine, sine, fixed = np.zeros((4, 4)), np.zeros((4, 4)), np.zeros((4, 4))
        cosine[:2] = (1.0, 0.0, 0.0, self.a), (0.0, ca, -sa, 0.0)
        sine[:2] = (0.0, -ca, sa, 0.0), (1.0, 0.0, 0.0, self.a)
        fixed[2:] = (0.0, sa, ca, self.d), (0.0, 0.0, 0.0, 1.0)
        return cosine, sine, fixed


class DhChain(Chain):
    """A chain of joints from a Denavit–Hartenberg table between two fixed transforms."""

    def __init__(self, name: str, base: Pose, joints: Sequence[Joint], tool: Pose) -> None:
        super().__init__(
            name,
            [joint.name for joint in joints],
            np.radians([joint.low for joint in joints]),
            np.radians([joint.high for joint in joints]),
            np.radians([joint.fastest for joint in joints]),
        )
        self.base, self.joints, self.tool = base, tuple(joints), tool
        self._offsets = np.radians([joint.offset for joint in joints])
        self._links = [np.array(share) for share in zip(*(joint.link() for joint in joints), strict=True)]

    @override
    def frames(self, angles: ArrayLike) -> list[Pose]:
        """Return the base, each link's end and the tool; z of a frame is the axis of the next joint."""
        theta = (self.checked(angles) + self._offsets)[:, None, None]
        cosine, sine, fixed = self._links
        poses = [self.base]
        for link in (*(np.cos(theta) * cosine + np.sin(theta) * sine + fixed), self.tool):
            poses.append(poses[-1].dot(link))  # for matrices this small, half of the time of @
        return poses

    @override
    def jacobian(self, angles: ArrayLike) -> NDArray[np.float64]:
        frames = np.array(self.frames(angles))
        joints, tip = frames[: len(self.joints)], frames[-1, :3, 3]
        axes = joints[:, :3, 2]
        return np.hstack((cross(axes, tip - joints[:, :3, 3]), axes)).T


FASTEST = 50.0
"Largest speed of every joint in degrees per second."

HEAD = DhChain(
    "TEO's head",
    pose(translation=(0.0, 0.0, 0.1932)),
    (
        Joint("AxialNeck", 0.0, 0.4675, 0.0, -90.0, -73.0, 73.0, FASTEST),
        Joint("FrontalNeck", 0.0, 0.0, 0.0, 90.0, -29.0, 8.4, FASTEST),
    ),
    pose(),
)

RIGHT_ARM = DhChain(
    "TEO's right arm",
    np.array([[0, 1, 0, 0], [0, 0, 1, -0.3469], [1, 0, 0, 0.4982], [0, 0, 0, 1]], np.float64),
    (
        Joint("FrontalRightShoulder", 0.0, 0.0, 0.0, -90.0, -98.1, 106.0, FASTEST),
        Joint("SagittalRightShoulder", -90.0, 0.0, 0.0, -90.0, -75.5, 22.4, FASTEST),
        Joint("AxialRightShoulder", -90.0, -0.32901, 0.0, -90.0, -80.1, 57.0, FASTEST),
        Joint("FrontalRightElbow", 0.0, 0.0, 0.0, 90.0, -99.6, 98.4, FASTEST),
        Joint("AxialRightWrist", 0.0, -0.215, 0.0, -90.0, -80.4, 99.6, FASTEST),
        Joint("FrontalRightWrist", -90.0, 0.0, -0.09, 0.0, -115.1, 44.7, FASTEST),
    ),
    np.array([[0, 0, -1, -0.0975], [-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]], np.float64),
)

CAMERA_PITCH = 20.0
"Degrees by which the camera is tilted down against the head."

CAMERA_ON_HEAD: Pose = pose(
    rotation_from_vector((0.0, math.radians(CAMERA_PITCH), 0.0)) @ [[0, 0, 1], [-1, 0, 0], [0, -1, 0]],
    (0.07, 0.0, 0.06),
)
"The camera's optical frame (z forward, x right, y down) in the head's frame (x forward, z up)."

HOME = np.radians([-20.0, -5.0, 0.0, -80.0, 0.0, 20.0])
"Home pose: the hand in front of the trunk, the elbow bent."

BODY = CapsuleBody(
    RIGHT_ARM,
    # From the shoulder, whose three joints share an origin, along upper arm, forearm and hand.
    radii=(0.06, 0.06, 0.06, 0.06, 0.05, 0.05, 0.05),
    fixed=(
        Capsule("the trunk", np.array([0.0, 0.0, -0.35]), np.array([0.0, 0.0, 0.42]), 0.16),
        Capsule("the head", np.array([0.0, 0.0, 0.62]), np.array([0.0, 0.0, 0.76]), 0.13),
    ),
    guarded_from=2,
)
"Approximate shapes around the links, as the tables have none; the left arm is assumed to hang down."

MODEL = KinematicModel("TEO", HEAD, RIGHT_ARM, CAMERA_ON_HEAD, HOME, stands=pose(), body=BODY)
