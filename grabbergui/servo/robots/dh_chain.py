"""A chain given by a table of classic Denavit–Hartenberg parameters."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import override

from grabbergui.calibration.geometry import Pose
from grabbergui.servo.kinematics import Chain


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


class DhChain(Chain):
    """The joints of a table between two fixed transforms."""

    def __init__(self, name: str, base: Pose, joints: Sequence[Joint], tool: Pose) -> None:
        super().__init__(
            name,
            [joint.name for joint in joints],
            np.radians([joint.low for joint in joints]),
            np.radians([joint.high for joint in joints]),
            np.radians([joint.fastest for joint in joints]),
        )
        self.base, self.joints, self.tool = base, tuple(joints), tool

    @override
    def frames(self, angles: ArrayLike) -> list[Pose]:
        """The z of each but the last two is the axis of the joint that follows it."""
        poses = [self.base]
        for joint, angle in zip(self.joints, self.checked(angles), strict=True):
            poses.append(poses[-1] @ joint.frame(float(angle)))
        return [*poses, poses[-1] @ self.tool]

    @override
    def jacobian(self, angles: ArrayLike) -> NDArray[np.float64]:
        frames = np.array(self.frames(angles))
        joints, tip = frames[: len(self.joints)], frames[-1, :3, 3]
        axes = joints[:, :3, 2]
        return np.hstack((np.cross(axes, tip - joints[:, :3, 3]), axes)).T
