"""What a command makes of the robot: the one model by which motion is limited and later compared. No I/O.

From the arm's joint angles and the joint velocities of its Cartesian controller (`Chain.response`), the
model predicts the hand's speed, its place and the arm's clearance over the time that a stop may take.
`planned` slows the whole motion down until every limit holds.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from grabbergui.calibration.geometry import Vector, diff
from grabbergui.servo.clearance import FREE, Body, Box, Clearance, nearest_box, parse_boxes
from grabbergui.servo.config import Config
from grabbergui.servo.kinematics import AT_LIMIT, LEVER, Chain
from grabbergui.servo.monitor import Observation, SpeedLimits
from grabbergui.servo.robots.robot import KinematicModel, Robot, RobotState

STOPPING_S = Robot.COMMAND_TIMEOUT
"Seconds that a motion may last after its last command; all limits must hold for as long."
DRIVES_S = 0.03
"Seconds that drives take to follow a command to 63 %."
SLOWER = (1.0, 0.5, 0.25, 0.1)
"Fractions of the speed that are tried, so that the hand slows down near an edge."
SLOW_AT_LIMIT = 3.0
"""Factor by which the motion is slower when a joint gets to its limit: there it is stopped at once, but the
other joints need a moment to take over its part of the motion."""
MARGIN = 1.08
"Factor by which a motion near a joint's limit is slower: there drives lag behind joint speeds that change."
SAME = 0.02
"Share of a twist, with `LEVER`, by which what the arm makes of it may differ until it is sent instead."


@dataclass(frozen=True, eq=False)
class MotionPlan:
    """A motion of the hand within the limits."""

    twist: Vector
    "What to send, (6,) m/s and rad/s along the base's axes."
    joints: Vector
    "The joint velocities that the arm makes of it, rad/s."
    reason: str = ""
    "Why it is slower than wanted, as display text; empty if it is not, or only too fast."


class Space:
    """Where an arm may be: the workspace, and the clearance from the body and from obstacles."""

    def __init__(self, model: KinematicModel, config: Config) -> None:
        self.low, self.high = config.arm.workspace
        self._clearance = config.safety.clearance
        self._arm: Chain = model.arm
        self._body: Body | None = model.body
        self._obstacles: tuple[Box, ...] = parse_boxes(config.safety.obstacles)
        self._before: tuple[Vector, Clearance] | None = None
        "The last pose from which an arm that is too near set out, and its contact: slow to compute."

    def outside(self, place: Vector) -> Vector:
        """Return by how many metres a place is outside the workspace, along each axis."""
        return np.maximum(np.maximum(self.low - place, place - self.high), 0.0)

    def refused(self, there: Vector, here: Vector | None = None) -> str:
        """Return why the arm must not be at joint angles, as display text; empty if it may.

        From `here`, which is outside or too near already, it may move back or away.
        """
        place = self._arm.forward(there)[:3, 3]
        before = np.zeros(3) if here is None else self.outside(self._arm.forward(here)[:3, 3])
        leaving = self.outside(place) - before
        if leaving.max() > 0:
            axis = int(np.argmax(leaving))
            return f"it would leave the workspace ({'xyz'[axis]} = {place[axis]:.2f} m)"
        contact = self._nearest(there)
        if contact.distance >= self._clearance or (
            here is not None and contact.distance >= self._nearest_from(here).distance
        ):
            return ""
        return f"{contact.part} would come within {1e3 * max(contact.distance, 0):.0f} mm of {contact.other}"

    def _nearest_from(self, here: Vector) -> Clearance:
        if self._before is None or not np.array_equal(self._before[0], here):
            self._before = here, self._nearest(here)
        return self._before[1]

    def _nearest(self, arm: Vector) -> Clearance:
        if self._body is None:
            return FREE
        contacts = [self._body.nearest(arm)]
        if self._obstacles:
            contacts.append(nearest_box(self._body.capsules(arm), self._obstacles))
        return min(contacts, key=lambda contact: contact.distance)


def limits_of(config: Config) -> SpeedLimits:
    """Return the highest speeds of hand and head."""
    arm = config.arm
    return SpeedLimits(
        max(arm.fastest, arm.follow), math.radians(arm.fastest_turn), math.radians(config.head.fastest)
    )


def limits_text(model: KinematicModel, config: Config) -> str:
    """Return the limits that a run keeps, in one line: of the configuration and of the robot's joints."""
    limits, (low, high) = limits_of(config), config.arm.workspace
    edges = ", ".join(f"{name} {a:g} to {b:g} m" for name, a, b in zip("xyz", low, high, strict=True))
    slowest, fastest = np.degrees(model.arm.fastest.min()), np.degrees(model.arm.fastest.max())
    return (
        f"limits: hand {1e3 * limits.speed:.0f} mm/s and {math.degrees(limits.turn):.0f} °/s within {edges}, "
        f"{1e3 * config.safety.clearance:.0f} mm from the body and obstacles; head "
        f"{math.degrees(limits.head):.0f} °/s; joints of {model.arm.name} {slowest:.0f} to {fastest:.0f} °/s"
    )


def planned(
    arm: Chain,
    space: Space,
    limits: SpeedLimits,
    angles: Vector,
    wanted: Vector,
    age: float,
) -> MotionPlan:
    """Return the motion nearest to a twist that stays within all limits until it can have been stopped.

    `angles` are the arm's joints as they were read `age` seconds ago.
    """
    here = arm.clamped(angles)
    here = np.where(here < arm.low + AT_LIMIT, arm.low, np.where(here > arm.high - AT_LIMIT, arm.high, here))
    twist = arm.attainable(here, wanted, STOPPING_S)
    same = _size(twist - wanted) <= SAME * _size(wanted)
    twist = wanted if same else twist
    joints = arm.response(here, twist)
    jacobian = arm.jacobian(here)
    motion = jacobian @ joints
    room = np.where(joints > 0, arm.high - here, here - arm.low)
    braking = float(np.max(np.abs(joints) * (STOPPING_S + DRIVES_S) / np.maximum(room, AT_LIMIT)))
    free = same and braking < 1 and bool(((arm.low < here) & (here < arm.high)).all())
    speed, turn = (float(np.linalg.norm(part)) * (1 if free else MARGIN) for part in (motion[:3], motion[3:]))
    excess = max(
        1.0, speed / limits.speed, turn / limits.turn, arm.excess(joints), min(braking, SLOW_AT_LIMIT)
    )
    # Drives are late: these joint speeds will move the hand from another pose, where it may be faster.
    soon = arm.jacobian(arm.clamped(here + joints * (DRIVES_S / excess))) @ joints / excess
    speed, turn = float(np.linalg.norm(soon[:3])), float(np.linalg.norm(soon[3:]))
    excess *= max(1.0, speed / limits.speed, turn / limits.turn)
    reason = ""
    for slower in SLOWER:
        share = slower / excess
        why = space.refused(arm.clamped(here + joints * share * (STOPPING_S + age)), here)
        if not why:
            return MotionPlan(twist * share, joints * share, reason)
        reason = reason or why
    return MotionPlan(np.zeros(6), np.zeros_like(here), reason)


def _size(twist: Vector) -> float:
    return float(np.linalg.norm(twist[:3]) + LEVER * np.linalg.norm(twist[3:]))


class Observer:
    """Adds up what was commanded and what is measured, for a `Monitor`. Use from one thread at a time."""

    def __init__(self, arm: Chain) -> None:
        self._arm = arm
        self.forget()

    def forget(self) -> None:
        """Start again, because the robot may have been moved by others."""
        joints = len(self._arm.low) + 2
        self._now, self._commanded, self._velocity = -math.inf, np.zeros(joints), np.zeros(joints)
        self._first: Vector | None = None
        self._arm_seen = np.zeros(joints - 2)
        self._seen = -math.inf
        self._stopped = False

    def command_arm(self, now: float, joints: Vector) -> None:
        """Note the arm's joint velocities from `now` on, rad/s."""
        self._advance(now)
        self._velocity[:-2] = joints

    def command_head(self, now: float, head: Vector, step: Vector | None = None) -> None:
        """Note the head's velocities from `now` on, rad/s, or its step in radians."""
        self._advance(now)
        self._velocity[-2:] = head if step is None else 0.0
        if step is not None:
            self._commanded[-2:] += step

    def rest(self, now: float) -> None:
        """Note that nothing is commanded from `now` on."""
        self._advance(now)
        self._stopped |= bool(self._velocity.any())
        self._velocity[:] = 0.0

    def look(self, now: float, state: RobotState, space: Space, limits: SpeedLimits) -> Observation | None:
        """Return what there is to compare; None without a new reading."""
        self._advance(now)
        if not state.sound or state.time <= self._seen:
            return None
        self._seen, off = state.time, np.zeros(6)
        stopped, self._stopped = self._stopped, False
        if state.arm is not None:
            self._first = state.arm if self._first is None else self._first
            self._arm_seen = state.arm - self._first
            off = diff(self._arm.forward(state.arm), state.hand)
        place = state.hand[:3, 3]
        return Observation(
            now,
            tuple(self._commanded.tolist()),
            state.time,
            (*self._arm_seen.tolist(), *state.head.tolist()),
            tuple(place.tolist()),
            float(np.linalg.norm(off[:3])),
            float(np.linalg.norm(off[3:])),
            state.apart,
            float(space.outside(place).max()),
            limits,
            stopped,
        )

    def _advance(self, now: float) -> None:
        if now > self._now > -math.inf:
            self._commanded = self._commanded + self._velocity * (now - self._now)
        self._now = max(self._now, now)
