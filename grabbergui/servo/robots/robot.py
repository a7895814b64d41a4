"""The robot as the loop sees it: joint angles and the end effector's pose out, velocities and a twist in."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from grabbergui.calibration import geometry
from grabbergui.calibration.geometry import Pose, Vector
from grabbergui.servo.kinematics import Body, Chain

HEAD, ARM = "head", "arm"
"Parts of a robot."


@dataclass(frozen=True, eq=False)
class KinematicModel:
    """The parts of a robot. Both chains begin at its base: x forward, y left, z up."""

    name: str
    head: Chain
    "Pan (positive to the left) and tilt (positive down)."
    arm: Chain
    "To the hand, whose z points into what it reaches for."
    camera: Pose
    "The camera's optical frame (z forward, x right, y down) as seen from the head chain's tool."
    home: Vector
    "The arm's angles on waking up, radians."
    stands: Pose
    "Its base in the room of `sim:scene`."
    body: Body | None = None
    "Its shapes, if they are known: the gate keeps the arm away from them."

    def camera_pose(self, head: Vector) -> Pose:
        """The camera's optical frame in the base for given pan and tilt."""
        return self.head.forward(head) @ self.camera

    def skeleton(self, head: Vector, arm: Vector | None) -> list[NDArray[np.float64]]:
        """Lines from joint to joint, each (n, 3), metres in the base: to the camera, and to the hand.

        The latter only where the arm's angles are known.
        """
        neck = [frame[:3, 3] for frame in self.head.frames(head)]
        lines = [np.vstack((np.zeros(3), *neck, self.camera_pose(head)[:3, 3]))]
        if arm is not None:
            joints = [frame[:3, 3] for frame in self.arm.frames(arm)]
            lines.append(np.vstack(((0.0, 0.0, joints[0][2]), *joints)))
        return lines


@dataclass(frozen=True, eq=False)
class RobotState:
    """One reading of a robot's sensors."""

    time: float
    "Seconds on the loop's clock at which it was measured."
    head: Vector
    "(2,) pan (positive to the left) and tilt (positive down), radians."
    hand: Pose
    "The hand in the robot's base."
    arm: Vector | None = None
    "Joint angles, radians, where they are known."

    @property
    def sound(self) -> bool:
        """Whether all numbers are finite, and the hand's pose is one."""
        angles = self.head if self.arm is None else np.concatenate((self.head, self.arm))
        finite = math.isfinite(self.time) and bool(np.isfinite(angles).all())
        return finite and geometry.is_pose(self.hand)


@dataclass(frozen=True, eq=False)
class CameraPlace:
    """Where a calibration found the camera on the head."""

    camera: Pose
    "The optical frame as seen from the head chain's tool."
    offsets: Vector
    "Radians to be added to pan and tilt."


class Robot(ABC):
    """A head with a camera and an arm with a hand.

    Commands may come from one thread, `stop` and `state` from any. A velocity holds until the next command,
    but no longer than `COMMAND_TIMEOUT`, whoever has to see to that. Errors are those of `core.errors`.
    """

    COMMAND_TIMEOUT = 0.2
    "Seconds after which a robot stands still that gets no more commands."

    def __init__(self, model: KinematicModel, name: str = "") -> None:
        self.model = model
        self.name = name or model.name
        self.placed: CameraPlace | None = None
        "The calibrated camera; None: it is where the model has it."

    @abstractmethod
    def open(self) -> None:
        """Connect and get ready. Raises TransportError, SourceNotFoundError, SourceUnavailableError."""

    @abstractmethod
    def close(self) -> None:
        """Stop and disconnect. May be called twice; never raises."""

    @abstractmethod
    def state(self) -> RobotState | None:
        """The newest reading; None while there is none. Never waits."""

    @property
    def parts(self) -> frozenset[str]:
        """The parts that can be moved, of HEAD and ARM; commands to others have no effect."""
        return frozenset((HEAD, ARM))

    @abstractmethod
    def move_head(self, velocity: Vector) -> None:
        """Pan and tilt, rad/s. Raises TransportError."""

    @abstractmethod
    def step_head(self, move: Vector) -> None:
        """A relative move of pan and tilt, radians. Raises TransportError."""

    @abstractmethod
    def move_hand(self, twist: Vector) -> None:
        """(6,) m/s and rad/s in the base's axes. Raises TransportError."""

    def lead_head(self, velocity: Vector, seconds: float) -> None:
        """Move as `move_head` does, by positions at most `seconds` ahead: the head rests at the last.

        A robot whose velocities end by themselves needs nothing of its own. Raises TransportError.
        """
        self.move_head(velocity)

    def lead_hand(self, twist: Vector, seconds: float) -> None:
        """Move as `move_hand` does, by poses at most `seconds` ahead: the hand rests at the last.

        A robot whose velocities end by themselves needs nothing of its own. Raises TransportError.
        """
        self.move_hand(twist)

    @abstractmethod
    def stop(self) -> bool:
        """Stop everything at once. Return whether that could be delivered; never raises."""

    def stop_channels(self) -> list[dict[str, str]]:
        """How the guardian can stop it from another process: channels as `servo.guardian` has them.

        None for a robot that comes to rest by itself when this program ends.
        """
        return []

    def camera_pose(self, head: Vector) -> Pose:
        """The camera's optical frame in the base for given pan and tilt."""
        if self.placed is not None:
            return self.model.head.forward(head + self.placed.offsets) @ self.placed.camera
        return self.model.camera_pose(head)

    def skeleton(self, state: RobotState) -> list[NDArray[np.float64]]:
        """Its model at a reading, for eyes; see KinematicModel. Any thread; nothing is asked of the robot."""
        return self.model.skeleton(state.head, state.arm)


# -- targets that lead ---------------------------------------------------------------------------
Place = TypeVar("Place", bound=np.ndarray)

HEAD_SLACK = math.radians(0.5)
HAND_SLACK = (0.002, math.radians(0.5))
"""Metres and radians by which a target may always be ahead. A joint that is held must not follow its own
deviation, or it would sink."""
_FIRST_S = 0.02
"Seconds of motion in the first target after a pause."


class LeadingTarget(Generic[Place]):
    """The target of one part, for robots whose drives go to a position and stay there.

    A target that is always just ahead keeps them in even motion; when the commands cease, whatever the cause,
    the robot rests at the last one.
    """

    def __init__(
        self,
        ahead: Callable[[Place, Vector], Place],
        leashed: Callable[[Place, Place, Vector], Place],
    ) -> None:
        """`ahead` adds a motion to a place; `leashed` keeps a target within a motion of where the part is."""
        self._ahead, self._leashed = ahead, leashed
        self._target: Place | None = None
        self._time = -math.inf

    def advance(self, here: Place, velocity: Vector, seconds: float, now: float) -> Place:
        """The next target for a part that is `here`: at most `seconds` ahead of it."""
        elapsed = now - self._time
        if self._target is None or elapsed > seconds:
            self._target, elapsed = here, _FIRST_S
        self._time = now
        target = self._ahead(self._target, velocity * min(elapsed, seconds))
        self._target = self._leashed(here, target, velocity * seconds)
        return self._target

    def forget(self) -> None:
        """Begin where the part is the next time."""
        self._target = None


def leading_head() -> LeadingTarget[Vector]:
    """For joint angles, radians."""

    def leashed(here: Vector, target: Vector, motion: Vector) -> Vector:
        leash = np.abs(motion) + HEAD_SLACK
        return here + np.clip(target - here, -leash, leash)

    return LeadingTarget(lambda place, motion: place + motion, leashed)


def leading_hand() -> LeadingTarget[Pose]:
    """For a hand's pose, and twists in the base."""

    def leashed(here: Pose, target: Pose, motion: Vector) -> Pose:
        off = geometry.diff(here, target)
        for part, slack in zip((slice(3), slice(3, 6)), HAND_SLACK, strict=True):
            leash = float(np.linalg.norm(motion[part])) + slack
            off[part] *= min(1.0, leash / max(float(np.linalg.norm(off[part])), 1e-9))
        return geometry.add_delta(here, off)

    return LeadingTarget(geometry.add_delta, leashed)
