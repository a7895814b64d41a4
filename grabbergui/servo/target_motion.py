"""The motion of a target, fitted to its last positions.

An image shows where the target was when it was exposed, tens of milliseconds ago. `TargetMotion` gives place
and velocity at a later time. Unlike a smoothed position, it does not lag behind a target that speeds up or
turns, but it is noisier, so a resting target is not predicted.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from grabbergui.calibration.geometry import Vector

_Matrix = NDArray[np.float64]

_WINDOW_S = 0.6
"Seconds of positions to which the motions are fitted."
_RECENT_S = 0.35
"Seconds of the newest positions, which decide whether the target moves."
_FEWEST_SEEN = 6
"Fewest positions in that time for a prediction."
_RATES = (0.0, 1.0, 2.0, 3.0, 4.0)
"Rad/s at which the motions turn; rates in between are mixtures."
_TURNS = np.array(_RATES[1:])[:, None]
"The rates of the motions that turn, in a column; the first is the parabola's."
_NOISE_M = 0.002
"Expected error of a position: standard deviation of each coordinate, metres."
AHEAD_S = 0.25
"Longest prediction beyond the newest position, seconds."
_MOVING_SPEED = 0.03
"Metres per second, over the recent positions, from which a target counts as moving."
RESTS_S = 0.6
"Seconds below that speed after which it counts as resting: a target that turns back rests for a moment."


class TargetMotion:
    """Positions of one target in the robot's base, and the motions fitted to them.

    Hands move to and fro and in circles. A parabola fits that only for a third of a second, which has too few
    images to average the noise. So motions that turn at several rates are fitted over a longer time, each by
    least squares, and weighted by how well they explain the positions. At rate 0 the motion is a parabola.
    """

    def __init__(self) -> None:
        self.moving = False
        "Whether the target moves."
        self.speed = 0.0
        "Metres per second at the newest position, 0 for a target that rests."
        self._seen: deque[tuple[float, Vector]] = deque()
        self._moved = -np.inf
        self._starts: _Matrix = np.zeros((len(_RATES), 3, 3))
        "Each motion's metres, m/s and m/s², in rows, at the newest position's time."
        self._weights = np.zeros(len(_RATES))
        "Each motion's weight; their sum is 1."

    def restart(self) -> None:
        """Forget the target, which was lost or is another one."""
        self._seen.clear()
        self.moving, self.speed = False, 0.0

    def add(self, time: float, position: Vector) -> None:
        """Add its position, metres in the base, at a time; ignore a time that is not later than the last."""
        if self._seen and time <= self._seen[-1][0]:
            return
        self._seen.append((time, np.array(position, np.float64)))
        while self._seen[0][0] < time - _WINDOW_S:
            self._seen.popleft()
        times = np.array([seen[0] for seen in self._seen]) - time
        places = np.array([seen[1] for seen in self._seen])
        recent = times >= -_RECENT_S
        if recent.sum() < _FEWEST_SEEN or times[recent][0] > -_RECENT_S / 2:
            self.moving, self.speed = False, 0.0
            return
        if _speed(times[recent], places[recent]) >= _MOVING_SPEED:
            self._moved = time
        self.moving = time - self._moved < RESTS_S
        if self.moving:  # a resting target is not predicted
            self._fit(times, places)
        self.speed = float(np.linalg.norm(self.velocity(time)))

    def position(self, time: float) -> Vector | None:
        """Return where a moving target is at a time; None if it rests or is not known."""
        return self._mixed(_places, time) if self.moving else None

    def velocity(self, time: float) -> Vector:
        """Return its velocity at a time, m/s; zero for a target at rest."""
        return self._mixed(_velocities, time) if self.moving else np.zeros(3)

    def _fit(self, times: Vector, places: _Matrix) -> None:
        factors = _places(times)
        across = factors.transpose(0, 2, 1)
        self._starts = np.asarray(np.linalg.solve(across @ factors, across @ places), np.float64)
        misfits = ((places - factors @ self._starts) ** 2).sum(axis=(1, 2))
        likely = np.exp((misfits.min() - misfits) / (2 * _NOISE_M**2))
        self._weights = likely / likely.sum()

    def _mixed(self, factors: Callable[[Vector], _Matrix], time: float) -> Vector:
        ahead = np.array([min(max(time - self._seen[-1][0], 0.0), AHEAD_S)])
        mixed: Vector = self._weights @ (factors(ahead) @ self._starts)[:, 0]
        return mixed


def _speed(times: Vector, places: _Matrix) -> float:
    """Return the speed along the straight line through the places, m/s."""
    mean = times.mean()
    return float(np.linalg.norm((times - mean) @ places / ((times - mean) ** 2).sum()))


def _places(times: Vector) -> _Matrix:
    """Return (motions, n, 3) factors of a motion's first place, velocity and acceleration in its places."""
    turned = _TURNS * times
    factors = np.ones((len(_RATES), len(times), 3))
    factors[0, :, 1], factors[0, :, 2] = times, times**2 / 2
    factors[1:, :, 1], factors[1:, :, 2] = np.sin(turned) / _TURNS, (1 - np.cos(turned)) / _TURNS**2
    return factors


def _velocities(times: Vector) -> _Matrix:
    """Return (motions, n, 3): the same for its velocities."""
    turned = _TURNS * times
    factors = np.zeros((len(_RATES), len(times), 3))
    factors[0, :, 1], factors[0, :, 2] = 1.0, times
    factors[1:, :, 1], factors[1:, :, 2] = np.cos(turned), np.sin(turned) / _TURNS
    return factors
