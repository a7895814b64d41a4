"""Joint states as TIAGo publishes them: a message of all joints, and the newest reading of each. No I/O."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from grabbergui.calibration.geometry import Vector
from grabbergui.core.errors import RemoteProtocolError
from grabbergui.servo.robots.robot import RobotState
from grabbergui.servo.robots.tiago import ARM_JOINTS, HEAD_JOINTS, HEAD_SIGNS

CLOCK_SET_BACK_S = 0.5
"Seconds for which older stamps must advance without a newer one, until the clock counts as set back."


def joint_state(reading: RobotState, stamp: Any) -> Any:
    """Return the `sensor_msgs/JointState` of a reading."""
    from sensor_msgs.msg import JointState

    message = JointState(name=[*HEAD_JOINTS, *ARM_JOINTS])
    message.header.stamp = stamp
    arm = () if reading.arm is None else reading.arm
    message.position = [float(angle) for angle in (*(HEAD_SIGNS * reading.head), *arm)]
    return message


class JointReadings:
    """The newest angles of some joints, out of `sensor_msgs/JointState`. Use from one thread.

    A message may contain a few joints only, and several publishers may take turns. A message whose stamp does
    not advance is ignored.
    """

    def __init__(self, names: Sequence[str]) -> None:
        self._readings: dict[str, tuple[float, float]] = {}
        self._stamps: dict[str, int] = {}
        self._older: dict[str, tuple[float, int]] = {}
        "When older stamps began to arrive, and the newest of them; empty while stamps advance."
        self._wanted = frozenset(names)
        self._newest: tuple[float, float] | None = None

    def take(self, message: Any, now: float) -> None:
        """Note a message that arrived `now`. Raises RemoteProtocolError if it is malformed."""
        if len(message.position) != len(message.name):
            raise RemoteProtocolError(
                f"a joint state of {len(message.name)} joints with {len(message.position)} positions"
            )
        stamp = message.header.stamp.sec * 1_000_000_000 + message.header.stamp.nanosec
        if stamp and self._wanted & set(message.name):
            self._newest = now, 1e-9 * stamp
        for name, angle in zip(message.name, message.position, strict=True):
            if name not in self._wanted:
                continue
            if not np.isfinite(angle):
                raise RemoteProtocolError(f"a joint state in which {name} is at {angle}")
            if stamp == 0 or stamp > self._stamps.get(name, 0) or self._set_back(name, stamp, now):
                self._stamps[name] = stamp
                self._readings[name] = now, float(angle)
                self._older.pop(name, None)

    def _set_back(self, name: str, stamp: int, now: float) -> bool:
        """Return whether an older stamp shows that the clock was set back."""
        if stamp == self._stamps.get(name):
            return False  # sent again
        begun, newest = self._older.setdefault(name, (now, stamp))
        self._older[name] = begun, max(stamp, newest)
        return stamp > newest and now - begun >= CLOCK_SET_BACK_S

    def robot_time(self, now: float) -> float | None:
        """Return the robot's clock, estimated `now`, seconds; None before a message with a stamp.

        It is late by the age of a message at its arrival, never early: a controller must not wait for a start
        in the future.
        """
        if self._newest is None:
            return None
        arrival, stamp = self._newest
        return stamp + now - arrival

    def missing(self) -> list[str]:
        """Return the joints without a reading."""
        return sorted(self._wanted - self._readings.keys())

    def angles(self, names: Sequence[str]) -> tuple[float, Vector] | None:
        """Return the arrival of the oldest reading, and all angles, radians; None if one is missing."""
        found = [self._readings.get(name) for name in names]
        known = [reading for reading in found if reading is not None]
        if len(known) < len(found):
            return None
        return min(time for time, _ in known), np.array([angle for _, angle in known])
