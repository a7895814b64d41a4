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
LAG_STEP_S = 0.03
FEWEST = 5
"Images in a window, at least."
MOTION = math.radians(0.25)
"Root mean square of a marker's deviation from a straight line, at least: several times a detection's noise."
UNEXPLAINED = 0.4
"Share of it that the head's motion may leave unexplained."
DISTINCT_S, DISTINCT = 0.15, 2.0
"Lags longer than permitted by so many seconds must leave so many times as much unexplained."
IMAGES_IN_TIME = 3
"Images in a row that must have shown it in time."
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
        self._lags = np.arange(0.0, LONGEST_LAG_S + LAG_STEP_S, LAG_STEP_S)
        self._permitted, self._pause = permitted, pause
        self._last = math.inf
        self._in_time = 0
        "Number of images in a row that showed it in time."
        self._cameras: deque[tuple[float, Pose]] = deque()
        "Where the camera was: time, and its pose in the base."
        self._markers: deque[tuple[float, Vector]] = deque()
        "An image's time, and the marker's place in the camera as (x, y, z, 1)."

    def look(self, time: float, camera: Pose) -> None:
        """Add a reading of the head's joints: the camera's pose in the base at a time."""
        if not self._cameras or time > self._cameras[-1][0]:
            self._cameras.append((time, camera))
        while self._cameras[0][0] < time - LONGEST_LAG_S - 2 * WINDOW_S:
            self._cameras.popleft()

    def add(self, captured: float, marker: Pose | None) -> None:
        """Add an image: its time, and the marker's pose in the camera; None if it is not seen."""
        if captured - self._last > self._pause:
            self.shown, self.lag, self._in_time = False, 0.0, 0
            self._markers.clear()
        self._last = captured
        if self.shown or marker is None or not self._cameras:
            return
        self._markers.append((captured, marker[:, 3]))
        while self._markers[0][0] < captured - WINDOW_S:
            self._markers.popleft()
        if len(self._markers) >= FEWEST:
            self._compare()

    def _compare(self) -> None:
        """Find the lag that explains best how the marker moved in the newest images."""
        when = np.array([moment for moment, _ in self._markers])
        seen = np.stack([place for _, place in self._markers])
        motion = float(_deviations(seen[:, :3], when))
        if motion < MOTION * float(np.linalg.norm(seen[:, :3].mean(axis=0))):
            return
        left = _deviations(self._places(when - self._lags[:, None], seen), when)
        best = float(self._lags[left.argmin()])
        if left.min() > UNEXPLAINED * motion:
            self._in_time = 0
        elif best > self._permitted:
            self._in_time, self.lag = 0, best
        elif left[self._lags > self._permitted + DISTINCT_S].min(initial=np.inf) > DISTINCT * left.min():
            self._in_time += 1
            if self._in_time >= IMAGES_IN_TIME:
                self.shown, self.lag = True, 0.0
                self._markers.clear()

    def _places(self, times: NDArray[np.float64], seen: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return places in the base, (lags, n, 3) metres, of what the camera saw at (lags, n) times."""
        known = np.array([time for time, _ in self._cameras])
        poses = np.array([camera[:3] for _, camera in self._cameras])
        later = np.clip(np.searchsorted(known, times), min(1, len(known) - 1), len(known) - 1)
        earlier = np.maximum(later - 1, 0)
        seconds = np.maximum(known[later] - known[earlier], 1e-9)
        share = np.clip((times - known[earlier]) / seconds, 0.0, 1.0)[..., None]
        # Where each pose would show it, (cameras, n, 3), once for all lags.
        shown = np.einsum("kij,nj->kni", poses, seen)
        image = np.arange(len(seen))
        before = shown[earlier, image]
        return np.asarray(before + share * (shown[later, image] - before), np.float64)


def _deviations(places: NDArray[np.float64], when: Vector) -> NDArray[np.float64]:
    """Return the root mean squares (...) of places' (..., n, 3) distances from steady motion."""
    basis = np.linalg.qr(np.stack((np.ones_like(when), when - when[0]), axis=1))[0]
    off = places - basis @ (basis.T @ places)
    return np.asarray(np.sqrt((off**2).sum(axis=-1).mean(axis=-1)), np.float64)


class Nod:
    """Turns the head up or down and back, once in `NOD_PERIOD_S`. Use from one thread."""

    def __init__(self, low: Vector, high: Vector) -> None:
        """`low` and `high` are the limits of pan and tilt, radians."""
        self._low, self._high = low, high
        self._begun = -math.inf
        self._from = 0.0
        self._toward = 1.0
        self._returns = self._rests = False

    def under_way(self, now: float) -> bool:
        """Return whether a nod has begun and not ended: the target is off centre meanwhile."""
        return now - self._begun <= NOD_PERIOD_S and not self._rests

    def velocity(self, now: float, angles: Vector, below: float) -> Vector:
        """Return the velocities of pan and tilt, rad/s.

        A target is seen `below` the middle of the image, radians.
        """
        if now - self._begun > NOD_PERIOD_S:
            self._begun, self._from = now, float(angles[1])
            self._returns = self._rests = False
            down, up = self._high[1] - angles[1], angles[1] - self._low[1]
            self._toward = 1.0 if (below >= 0 and down > NOD) or up <= NOD else -1.0
        done = (float(angles[1]) - self._from) * self._toward
        self._returns = self._returns or done >= NOD
        self._rests = self._rests or (self._returns and done <= NOD_SPEED * DRIVES_S)
        if self._rests:
            return np.zeros(2)
        return np.array([0.0, -NOD_SPEED if self._returns else NOD_SPEED]) * self._toward
