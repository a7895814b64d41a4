"""Shows by the head's own motion that images are of now. No I/O, no clock.

A stamp may be that of an image's arrival, and then does not show how old the image is. While camera and
marker rest, neither do the pixels. But when the head turns, a marker moves in an image of now as the head's
joints say. So the head nods before the arm moves, unless it has just turned to the marker.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np
from numpy.typing import NDArray

from grabbergui.calibration.geometry import Pose, Vector
from grabbergui.servo.motion import DRIVES_S

WINDOW_S = 0.6
"Seconds of the newest images that are compared: so few that a marker in a hand moves steadily meanwhile."
LONGEST_LAG_S = 2.0
"Longest lag that is measured."
FEWEST = 5
"Images in a window, at least."
MOTION = math.radians(0.2)
"Root mean square of a marker's deviation from a straight line, at least: several times a detection's noise."
UNEXPLAINED = 0.4
"Share of it that the head's motion may leave unexplained."
NOD = math.radians(2.0)
"How far the head nods: less than a target may be off centre."
NOD_SPEED = math.radians(12.0)
SLOWEST = math.radians(6.0)
"Highest speed of a head that is too slow to nod visibly."
NOD_PERIOD_S = 2.5
"Seconds from one nod to the next: more than the longest lag, so that they are not taken for each other."


class OwnMotionWatch:
    """Compares a marker's motion in the images with the camera's. Use from one thread."""

    def __init__(self, permitted: float, pause: float) -> None:
        """`permitted` is the age that images may have, `pause` the gap after which it must be shown again.

        Both are seconds.
        """
        self.shown = False
        "Whether images have shown the head's motion in time since they last paused."
        self.lag = 0.0
        "Seconds by which they showed it too late; 0 if they did not."
        self._permitted, self._pause = permitted, pause
        self._last = math.inf
        self._images: deque[tuple[float, Pose, Vector]] = deque()
        "Time, the camera in the base, the marker's place in the camera: (x, y, z, 1), NaN if it is not seen."

    def add(self, captured: float, camera: Pose | None, marker: Pose | None) -> None:
        """Add an image: its time, the camera's pose in the base, and the marker's in the camera, if known."""
        if captured - self._last > self._pause:
            self.shown, self.lag = False, 0.0
            self._images.clear()
        self._last = captured
        if self.shown:
            self._images.clear()
        elif camera is not None:
            self._images.append((captured, camera, np.full(4, np.nan) if marker is None else marker[:, 3]))
            while self._images[0][0] < captured - LONGEST_LAG_S - WINDOW_S:
                self._images.popleft()
            self._compare()

    def _compare(self) -> None:
        times = np.array([image[0] for image in self._images])
        cameras = np.stack([image[1] for image in self._images])
        markers = np.stack([image[2] for image in self._images])
        newest = np.flatnonzero((times > times[-1] - WINDOW_S) & np.isfinite(markers[:, 0]))
        if len(newest) < FEWEST:
            return
        seen, when = markers[newest], times[newest]
        distance = float(np.linalg.norm(seen[:, :3].mean(axis=0)))
        least = UNEXPLAINED * _deviation(seen[:, :3], when)
        if least < UNEXPLAINED * MOTION * distance:
            return
        best = None
        for images_late in range(newest[-1] + 1):
            # Before the first image the head rested.
            then = np.maximum(newest - images_late, 0)
            left = _deviation(np.einsum("nij,nj->ni", cameras[then, :3], seen), when)
            if left < least:
                best, least = float(when[-1] - times[then[-1]]), left
        if best is not None:
            self.shown = best <= self._permitted
            self.lag = 0.0 if self.shown else best


def _deviation(places: NDArray[np.float64], when: Vector) -> float:
    """Return the root mean square of places' (n, 3) distances from steady motion."""
    basis = np.linalg.qr(np.stack((np.ones_like(when), when - when[0]), axis=1))[0]
    off = places - basis @ (basis.T @ places)
    return float(np.sqrt((off**2).sum(axis=1).mean()))


class Nod:
    """Turns the head up or down and back, once in `NOD_PERIOD_S`. Use from one thread."""

    def __init__(self, low: Vector, high: Vector) -> None:
        """`low` and `high` are the limits of pan and tilt, radians."""
        self._low, self._high = low, high
        self._begun = -math.inf
        self._from = 0.0
        self._toward = 1.0
        self._returns = False

    def velocity(self, now: float, angles: Vector, below: float) -> Vector:
        """Return the velocities of pan and tilt, rad/s.

        A target is seen `below` the middle of the image, radians.
        """
        if now - self._begun > NOD_PERIOD_S:
            self._begun, self._from, self._returns = now, float(angles[1]), False
            down, up = self._high[1] - angles[1], angles[1] - self._low[1]
            self._toward = 1.0 if (below >= 0 and down > NOD) or up <= NOD else -1.0
        done = (float(angles[1]) - self._from) * self._toward
        self._returns = self._returns or done >= NOD
        if self._returns and done <= NOD_SPEED * DRIVES_S:
            return np.zeros(2)
        return np.array([0.0, -NOD_SPEED if self._returns else NOD_SPEED]) * self._toward
