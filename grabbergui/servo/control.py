"""Commands for head and end effector from the target's place. No clock: time is an argument."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from grabbergui.calibration import geometry
from grabbergui.calibration.geometry import Pose, Vector
from grabbergui.servo.config import ArmConfig, HeadConfig

Axes = NDArray[np.bool_]

HAND_ON_MARKER = np.array([[0.0, -1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
"The hand's axes as seen from the marker's: its z into the marker, its x down along it."
FOLLOW_GAIN = 6.5
"1/s: twist per position error of a hand that follows, in addition to the target's velocity."
FOLLOW_ACCELERATION = 8.0
"""Factor on the hand's acceleration while it follows: the target accelerates, too, and after a short stop for
a late image the hand must catch up."""
RATE_S = 0.01
"Seconds over which the rate is computed at which a moving target leaves the middle."


class HeadController:
    """Keeps a point in the middle of the image by pan and tilt (radians, positive to the left and down)."""

    def __init__(self, config: HeadConfig, low: Vector, high: Vector) -> None:
        self.offset = np.zeros(2)
        "The target's last offset from the middle, to the right and down, radians."
        self._config = config
        self._low, self._high = low, high
        self._moving: Axes = np.zeros(2, bool)
        self._next_step = -math.inf
        self._side = 1.0
        self._row = 0

    def tune(self, config: HeadConfig) -> None:
        """Change gains and limits."""
        self._config = config

    def see(self, target: Vector, camera: Pose) -> None:
        """Measure the offset only."""
        self.offset = off_centre(target, camera)

    def look(
        self, target: Vector, camera: Pose, angles: Vector, target_velocity: Vector | None = None
    ) -> Vector:
        """Return pan and tilt velocities, rad/s, that bring `target` (base, metres) to the middle.

        `camera` is the camera's pose now, not at the exposure, so that a late frame does not make the head
        overshoot. `target_velocity` is a moving target's, m/s: the head turns along with it. The velocity is
        zero for a joint at its limit, and for a target at rest within the deadband.
        """
        self.see(target, camera)
        turn = self._config.gain * self._wanted(angles)
        if target_velocity is not None:
            turn = turn + (off_centre(target + target_velocity * RATE_S, camera) - self.offset) / RATE_S
            turn[self._blocked(turn, angles)] = 0.0
        fastest = math.radians(self._config.fastest)
        return np.clip(-turn * (1, -1), -fastest, fastest)

    def step(self, target: Vector, camera: Pose, angles: Vector, now: float) -> Vector | None:
        """Return a relative move of fixed size, radians, or None if none is due."""
        self.see(target, camera)
        wanted = self._wanted(angles)
        if now < self._next_step or not wanted.any():
            return None
        self._next_step = now + self._config.step_period
        moves = -np.sign(wanted) * (1, -1) * math.radians(self._config.step)
        return np.clip(angles + moves, self._low, self._high) - angles

    def centred(self, angles: Vector, slack: float = 1.0) -> bool:
        """Return whether the target is as near to the middle as `[head] start` demands or the joints allow.

        `slack` widens the tolerance for a followed target, behind which the head lags a little.
        """
        near = np.abs(self.offset) <= self._config.start * slack
        return bool((near | self._blocked(self.offset, angles)).all())

    def search(self, angles: Vector) -> Vector:
        """Return the velocity of slow sweeps from side to side: level, then looking down, then up."""
        speed = math.radians(self._config.search)
        edge = 0.7 * (self._high[0] if self._side > 0 else self._low[0])
        if (edge - angles[0]) * self._side <= 0.02:
            self._side, self._row = -self._side, (self._row + 1) % 3
        tilt = 0.6 * (0.0, self._high[1], self._low[1])[self._row]
        return np.array([self._side * speed, float(np.clip(2 * (tilt - angles[1]), -speed, speed))])

    def rest(self) -> None:
        """Forget which axes were moving."""
        self._moving[:] = False

    def _wanted(self, angles: Vector) -> Vector:
        """Return the offset along the axes that must move, zero along the others."""
        size = np.abs(self.offset)
        self._moving = np.where(self._moving, size > self._config.deadband, size > self._config.start)
        self._moving &= ~self._blocked(self.offset, angles)
        return np.where(self._moving, self.offset, 0.0)

    def _blocked(self, offset: Vector, angles: Vector) -> Axes:
        """Return the axes whose joint is at its limit in the direction of the offset."""
        direction = -np.sign(offset) * (1, -1)
        margin = 1e-3
        blocked: Axes = ((direction > 0) & (angles >= self._high - margin)) | (
            (direction < 0) & (angles <= self._low + margin)
        )
        return blocked


def off_centre(target: Vector, camera: Pose) -> Vector:
    """Return the angles to the right and down, radians, at which a camera sees a point of the base."""
    x, y, z = camera[:3, :3].T @ (target - camera[:3, 3])
    return np.array([math.atan2(x, z), math.atan2(y, z)])


class ArmController:
    """Moves the hand to a pose in front of the marker: fast at first, slower near the goal, at rest there."""

    def __init__(self, config: ArmConfig, standoff: float) -> None:
        self.error = (math.inf, math.inf)
        "Last distance from the hand to the goal, metres and radians."
        self._config = config
        self._standoff = standoff
        self._twist = np.zeros(6)
        self._resting = False

    def tune(self, config: ArmConfig) -> None:
        """Change gains and limits."""
        self._config = config

    def goal(self, marker: Pose) -> Pose:
        """Return the hand's goal for a marker."""
        return marker @ geometry.pose(HAND_ON_MARKER, (0.0, 0.0, self._standoff))

    def inside(self, position: Vector) -> bool:
        """Return whether a point lies in the workspace."""
        low, high = self._config.workspace
        return bool(((low <= position) & (position <= high)).all())

    def approach(self, hand: Pose, marker: Pose, seconds: float, velocity: Vector | None = None) -> Vector:
        """Return the twist (base, m/s and rad/s) for the next `seconds`; zero if the goal is outside.

        `velocity` is the marker's, m/s, if the hand follows it; None if the hand approaches a resting marker.
        """
        goal = self.goal(marker)
        error = geometry.diff(hand, goal)
        self.error = (float(np.linalg.norm(error[:3])), float(np.linalg.norm(error[3:])))
        if not np.isfinite(error).all() or not self.inside(goal[:3, 3]):
            return self.rest()
        config = self._config
        turn_acceleration = math.radians(config.turn_acceleration)
        # It rests as a whole, as turning moves it, too. A resting hand starts again only at twice the
        # deadband, so that noise does not make it tremble.
        factor = 2 if self._resting else 1
        deadbands = config.deadband, math.radians(config.deadband_turn)
        self._resting = all(off <= factor * most for off, most in zip(self.error, deadbands, strict=True))
        wanted = np.concatenate(
            (
                self._part(error[:3], config.fastest, config.acceleration),
                self._part(error[3:], math.radians(config.fastest_turn), turn_acceleration),
            )
        )
        acceleration = config.acceleration
        if velocity is not None:
            acceleration *= FOLLOW_ACCELERATION
            wanted[:3] = self._following(error[:3], velocity)
        limit = np.repeat((acceleration, turn_acceleration), 3) * seconds
        # Limit only the increase of speed, never the decrease.
        faster = np.abs(wanted) > np.abs(self._twist)
        change = wanted - self._twist
        self._twist = np.where(faster, self._twist + np.clip(change, -limit, limit), wanted)
        return self._twist

    @property
    def arrived(self) -> bool:
        """Whether the hand was near enough to its goal at the last measurement."""
        return self.error[0] <= self._config.reached and self.error[1] <= math.radians(
            self._config.reached_turn
        )

    @property
    def settled(self) -> bool:
        """Whether the hand rests at its goal."""
        return self._resting

    def rest(self) -> Vector:
        """Return a zero twist; the next approach starts slowly."""
        self._twist = np.zeros(6)
        return np.zeros(6)

    def measure(self, hand: Pose, marker: Pose) -> None:
        """Measure the distance only."""
        error = geometry.diff(hand, self.goal(marker))
        self.error = (float(np.linalg.norm(error[:3])), float(np.linalg.norm(error[3:])))

    def _part(self, error: Vector, fastest: float, acceleration: float) -> Vector:
        size = float(np.linalg.norm(error))
        if self._resting or size < 1e-9:
            return np.zeros(3)
        speed = min(self._config.gain * size, fastest, math.sqrt(acceleration * size))
        return error / size * speed

    def _following(self, error: Vector, velocity: Vector) -> Vector:
        """Return the target's velocity plus a correction of the error, m/s, limited to `[arm] follow`."""
        size = float(np.linalg.norm(error))
        nearer = min(FOLLOW_GAIN, math.sqrt(self._config.acceleration / max(size, 1e-9))) * error
        wanted: Vector = velocity + nearer
        speed = float(np.linalg.norm(wanted))
        return wanted * min(1.0, self._config.follow / max(speed, 1e-9))
