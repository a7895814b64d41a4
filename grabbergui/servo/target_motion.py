"""Predicts where a moving target is by now, and how fast it moves. No clock: time is an argument.

An image shows where the target was when it was exposed, tens of milliseconds ago. A motion through the
positions of the last moments, measured in the robot's base, gives place and velocity at a later moment. It
does not lag behind a target that speeds up or turns, as a smoothed position does; the price is noise, so a
target that rests is not predicted at all.

Hands move to and fro and in circles. A parabola fits that for a third of a second only, which are too few
images to average their noise. So motions that turn at several rates are fitted over a longer time, each by
least squares; the better a motion explains the positions, the more it counts. At rate 0 it is a parabola.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from grabbergui.calibration.geometry import Vector

Matrix = NDArray[np.float64]

WINDOW_S = 0.6
"Seconds of positions to which the motions are fitted."
RECENT_S = 0.35
"Seconds of the newest positions, which decide whether the target moves at all."
LEAST = 6
"Fewest positions in that time from which anything is predicted."
RATES = (0.0, 1.0, 2.0, 3.0, 4.0)
"Rad/s at which motions turn; those between them are mixtures."
NOISE_M = 0.002
"Expected error of a position: standard deviation of each coordinate, metres."
AHEAD_S = 0.25
"Longest prediction beyond the newest position, seconds."
MOVES = 0.03
"Metres per second, over the recent positions, from which a target counts as moving."
RESTS_S = 0.6
"Seconds below that speed after which it counts as resting: one that turns back stands still for a moment."


class TargetMotion:
    """Positions of one target, and the motions through them."""

    def __init__(self) -> None:
        self.moving = False
        "Whether the target moves."
        self.speed = 0.0
        "Metres per second at the newest position, 0 for a target that rests."
        self._seen: deque[tuple[float, Vector]] = deque()
        self._moved = -np.inf
        self._starts = np.zeros((len(RATES), 3, 3))
        "Of each motion: metres, m/s and m/s², in rows, at the newest position's time."
        self._weights = np.zeros(len(RATES))
        "How much each counts, 1 in all."

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
        places = np.array([seen[1] for seen in self._seen])
        recent = times >= -RECENT_S
        if recent.sum() < LEAST or times[recent][0] > -RECENT_S / 2:
            self.moving, self.speed = False, 0.0
            return
        if _speed(times[recent], places[recent]) >= MOVES:
            self._moved = time
        self.moving = time - self._moved < RESTS_S
        self._fit(times, places)
        self.speed = float(np.linalg.norm(self.velocity(time)))

    def position(self, time: float) -> Vector | None:
        """Where a target that moves is at a time; None for one that rests or is not known."""
        return self._mixed(_places, time) if self.moving else None

    def velocity(self, time: float) -> Vector:
        """Its velocity at a time, m/s; zero for a target that rests."""
        return self._mixed(_velocities, time) if self.moving else np.zeros(3)

    def _fit(self, times: Vector, places: Matrix) -> None:
        factors = np.array([_places(times, rate) for rate in RATES])
        across = factors.transpose(0, 2, 1)
        self._starts = np.linalg.solve(across @ factors, across @ places)
        misfits = ((places - factors @ self._starts) ** 2).sum(axis=(1, 2))
        likely = np.exp((misfits.min() - misfits) / (2 * NOISE_M**2))
        self._weights = likely / likely.sum()

    def _mixed(self, factors: Callable[[Vector, float], Matrix], time: float) -> Vector:
        ahead = np.array([min(max(time - self._seen[-1][0], 0.0), AHEAD_S)])
        each = [factors(ahead, rate)[0] @ start for rate, start in zip(RATES, self._starts, strict=True)]
        mixed: Vector = self._weights @ np.array(each)
        return mixed


def _speed(times: Vector, places: Matrix) -> float:
    """Of the straight line through the places, m/s."""
    mean = times.mean()
    return float(np.linalg.norm((times - mean) @ places / ((times - mean) ** 2).sum()))


def _places(times: Vector, rate: float) -> Matrix:
    """(n, 3): how much a motion's first place, velocity and acceleration are in its places."""
    if rate == 0:
        return np.stack((np.ones_like(times), times, times**2 / 2), axis=1)
    turned = rate * times
    return np.stack((np.ones_like(times), np.sin(turned) / rate, (1 - np.cos(turned)) / rate**2), axis=1)


def _velocities(times: Vector, rate: float) -> Matrix:
    """(n, 3): the same in its velocities."""
    if rate == 0:
        return np.stack((np.zeros_like(times), np.ones_like(times), times), axis=1)
    turned = rate * times
    return np.stack((np.zeros_like(times), np.cos(turned), np.sin(turned) / rate), axis=1)
