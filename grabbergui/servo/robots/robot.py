"""A robot as the loop sees it: joint angles and the hand's pose out, velocities and a twist in."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grabbergui.calibration import geometry
from grabbergui.calibration.geometry import Pose, Vector
from grabbergui.servo.clearance import Body
from grabbergui.servo.kinematics import Chain

HEAD, ARM = "head", "arm"
"Parts of a robot."


@dataclass(frozen=True, eq=False)
class KinematicModel:
    """The parts of a robot. Both chains begin at its base: x forward, y left, z up."""

    name: str
    head: Chain
    "Pan (positive to the left) and tilt (positive down)."
    arm: Chain
    "To the hand, whose z points forward, into the marker at its goal."
    camera: Pose
    "The camera's optical frame (z forward, x right, y down) as seen from the head chain's tool."
    home: Vector
    "The arm's first angles, radians."
    stands: Pose
    "Pose of its base in the room of `sim:scene`."
    body: Body | None = None
    "Its shapes, from which the gate keeps the arm away; None if they are not known."

    def camera_pose(self, head: Vector) -> Pose:
        """Return the camera's optical frame in the base for given pan and tilt."""
        return self.head.forward(head) @ self.camera

    def skeleton(self, head: Vector, arm: Vector | None) -> list[NDArray[np.float64]]:
        """Return lines from joint to joint, each (n, 3), metres in the base: to the camera, and to the hand.

        Without the arm's angles there is no line to the hand.
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
    "Time of the measurement, seconds on the loop's clock."
    head: Vector
    "(2,) pan (positive to the left) and tilt (positive down), radians."
    hand: Pose
    "The hand in the robot's base."
    arm: Vector | None = None
    "Joint angles, radians; None if they are not known."
    apart: float = 0.0
    "Seconds between the readings of the hand and of its joints."

    @property
    def sound(self) -> bool:
        """Whether all numbers are finite, and the hand's pose is one."""
        angles = self.head if self.arm is None else np.concatenate((self.head, self.arm))
        finite = math.isfinite(self.time) and bool(np.isfinite(angles).all())
        return finite and geometry.is_pose(self.hand)


class JointHistory:
    """Recent joint angles, from which the head's pose at an image's exposure is known."""

    SLACK = 0.06
    "Seconds beyond the newest or oldest reading for which it still holds."

    def __init__(self, length: int = 200) -> None:
        self._readings: deque[tuple[float, Vector]] = deque(maxlen=length)

    def add(self, time: float, angles: Vector) -> None:
        """Add a reading; ignore one that is not newer than the last, or not finite."""
        if np.isfinite(angles).all() and (not self._readings or time > self._readings[-1][0]):
            self._readings.append((time, np.array(angles, np.float64)))

    def at(self, time: float) -> Vector | None:
        """Return the angles at a time, interpolated linearly; None if they are not known."""
        readings = self._readings
        if not readings or not readings[0][0] - self.SLACK <= time <= readings[-1][0] + self.SLACK:
            return None
        later = None
        for reading in reversed(readings):
            if reading[0] <= time:
                if later is None:
                    return reading[1]
                part = (time - reading[0]) / (later[0] - reading[0])
                return reading[1] + part * (later[1] - reading[1])
            later = reading
        return readings[0][1]


@dataclass(frozen=True, eq=False)
class CameraPlace:
    """The camera's place on the head, from a calibration."""

    camera: Pose
    "The optical frame as seen from the head chain's tool."
    offsets: Vector
    "Radians to be added to pan and tilt."


class Robot(ABC):
    """A head with a camera and an arm with a hand.

    Commands may come from one thread, `stop` and `state` from any. A velocity holds until the next command,
    but no longer than `COMMAND_TIMEOUT`: if the drives do not ensure that, the gate's watchdog does. Errors
    are those of `core.errors`.
    """

    COMMAND_TIMEOUT = 0.2
    "Seconds after which a robot without another command is at rest."

    def __init__(self, model: KinematicModel, name: str = "") -> None:
        self.model = model
        self.name = name or model.name
        self.placed: CameraPlace | None = None
        "The calibrated camera; None if the model's camera is used."

    @abstractmethod
    def open(self) -> None:
        """Connect and get ready. Raises TransportError, SourceNotFoundError, SourceUnavailableError."""

    @abstractmethod
    def close(self) -> None:
        """Stop and disconnect. May be called twice; never raises."""

    @abstractmethod
    def state(self) -> RobotState | None:
        """Return the newest reading; None before the first. Never waits."""

    @property
    def parts(self) -> frozenset[str]:
        """The parts that can be moved, of HEAD and ARM; commands to others have no effect."""
        return frozenset((HEAD, ARM))

    @abstractmethod
    def move_head(self, velocity: Vector) -> None:
        """Move pan and tilt at a velocity, rad/s. Raises TransportError."""

    @abstractmethod
    def step_head(self, move: Vector) -> None:
        """Move pan and tilt by angles, radians. Raises TransportError."""

    @abstractmethod
    def move_hand(self, twist: Vector) -> None:
        """Move the hand by a (6,) twist, m/s and rad/s along the base's axes. Raises TransportError."""

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
        """Stop everything. Return whether the stop was delivered; never raises."""

    def silence(self) -> str:
        """Return why its readings are old and what to do, as display text; empty if that is not known."""
        return ""

    def stop_channels(self) -> list[dict[str, str]]:
        """Return the channels by which the guardian can stop it from another process; see `servo.guardian`.

        Empty for a robot that comes to rest by itself when this program ends.
        """
        return []

    def camera_pose(self, head: Vector) -> Pose:
        """Return the camera's optical frame in the base for given pan and tilt."""
        if self.placed is not None:
            return self.model.head.forward(head + self.placed.offsets) @ self.placed.camera
        return self.model.camera_pose(head)

    def skeleton(self, state: RobotState) -> list[NDArray[np.float64]]:
        """Return the model's lines at a reading, for display; see KinematicModel. Any thread."""
        return self.model.skeleton(state.head, state.arm)


class Bystander(Robot):
    """A robot that is observed and never moved, for dry runs."""

    def __init__(self, robot: Robot) -> None:
        super().__init__(robot.model, robot.name)
        self._watched = robot

    def open(self) -> None:
        """Do nothing: the robot is opened by its owner."""

    def close(self) -> None:
        """Do nothing, as in `open`."""

    def state(self) -> RobotState | None:
        """Return the robot's newest reading."""
        return self._watched.state()

    def move_head(self, velocity: Vector) -> None:
        """Do nothing."""

    def step_head(self, move: Vector) -> None:
        """Do nothing."""

    def move_hand(self, twist: Vector) -> None:
        """Do nothing."""

    def lead_head(self, velocity: Vector, seconds: float) -> None:
        """Do nothing."""

    def lead_hand(self, twist: Vector, seconds: float) -> None:
        """Do nothing."""

    def stop(self) -> bool:
        """Do nothing: nothing was moved."""
        return True
