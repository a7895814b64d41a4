"""The motion of a target, and where it is by now. No clock: time is an argument.

An image shows where the target was when it was exposed, tens of milliseconds ago. A parabola through the
positions of the last moments, measured in the robot's base, gives place and velocity at a later moment. It
lags neither behind a constant velocity, as a smoothed position does, nor behind a constant acceleration, as a
line would; the price is noise, so a target that rests is not predicted at all.
"""

from __future__ import annotations

from collections import deque

import numpy as np

from grabbergui.calibration.geometry import Vector

WINDOW_S = 0.35
"Seconds of positions that the parabola goes through."
LEAST = 6
"Positions without which nothing is predicted."
AHEAD_S = 0.25
"Seconds from the newest position beyond which a prediction goes no further."
MOVES = 0.03
"Metres per second, over the window, from which on a target moves."
RESTS_S = 0.6
"Seconds at less than that after which it rests: a target that turns back stands still for a moment."


class TargetMotion:
    """Positions of one target, and their parabola."""

    def __init__(self) -> None:
        self.moving = False
        "Whether the target moves."
        self.speed = 0.0
        "Metres per second at the newest position, 0 for a target that rests."
        self._seen: deque[tuple[float, Vector]] = deque()
        self._moved = -np.inf
        self._parabola = np.zeros((3, 3))
        "Rows: metres, m/s, half of m/s², at the newest position's time."

    def restart(self) -> None:
        """Forget the target: it was lost, or it is another one."""
        self._seen.clear()
        self.moving, self.speed = False, 0.0

    def add(self, time: float, position: Vector) -> None:
        """Take in where it was, metres in the base, at a time later than the one before."""
        if self._seen and time <= self._seen[-1][0]:
            return
        self._seen.append((time, np.array(position, np.float64)))
        while self._seen[0][0] < time - WINDOW_S:
            self._seen.popleft()
        times = np.array([seen[0] for seen in self._seen]) - time
        if len(times) < LEAST or times[0] > -WINDOW_S / 2:
            self.moving, self.speed = False, 0.0
            return
        places = np.array([seen[1] for seen in self._seen])
        mean = times.mean()
        slope = (times - mean) @ places / ((times - mean) ** 2).sum()
        if np.linalg.norm(slope) >= MOVES:
            self._moved = time
        self.moving = time - self._moved < RESTS_S
        self._parabola = np.linalg.lstsq(np.vander(times, 3, increasing=True), places, rcond=None)[0]
        self.speed = float(np.linalg.norm(self._parabola[1])) if self.moving else 0.0

    def position(self, time: float) -> Vector | None:
        """Where a target that moves is at a time; None for one that rests or is not known."""
        if not self.moving:
            return None
        ahead = self._ahead(time)
        where: Vector = self._parabola[0] + ahead * self._parabola[1] + ahead**2 * self._parabola[2]
        return where

    def velocity(self, time: float) -> Vector:
        """Its velocity at a time, m/s; zero for a target that rests."""
        if not self.moving:
            return np.zeros(3)
        velocity: Vector = self._parabola[1] + 2 * self._ahead(time) * self._parabola[2]
        return velocity

    def _ahead(self, time: float) -> float:
        return min(max(time - self._seen[-1][0], 0.0), AHEAD_S)
