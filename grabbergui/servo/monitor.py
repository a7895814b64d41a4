"""Compares what a robot does with what it was commanded. No I/O and no clock; needs no numpy.

The monitor runs in the guardian's process, or for a simulated robot beside the gate. It knows two paths of
joint angles: the arm's joints, then pan and tilt, radians. One is commanded, the other is measured. What is
measured may trail what is commanded by up to `lag` seconds, as drives, networks and busy computers are late,
but then it must agree.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import Any

Path = tuple[float, ...]

TOLERANCE = 0.02
"Radians by which a joint may differ: noise, steps of encoders, and another solver's rounding."
INACCURACY = 0.01
"Rad/s by which a joint's speed may differ in the long run, in addition."
PROGRESS = 0.7
"Share of the commanded motion that a robot makes at least."
WINDOWS = (2.0, 6.0)
"Times over which the paths are compared, in units of `lag`."
JITTER = 0.4
"Share of `lag` by which the time between two readings may be wrong."
TOO_FAST = 1.05
"Factor on the highest speed that counts as too fast."
APART = (0.010, 0.05)
"Metres and radians between the reported hand and the one that its joints give."
OUTSIDE = 0.005
"Metres by which a hand may be measured outside the workspace, or further outside than at the start."


@dataclass(frozen=True)
class SpeedLimits:
    """The highest speeds."""

    speed: float = math.inf
    "Speed of the hand in m/s."
    turn: float = math.inf
    "Angular speed of the hand in rad/s."
    head: float = math.inf
    "Speed of pan and tilt in rad/s."


@dataclass(frozen=True)
class Observation:
    """A reading, and what was commanded until then. All times are on one clock, in seconds."""

    now: float
    commanded: Path
    "The path that was commanded until `now`."
    time: float
    "When the reading was taken."
    measured: Path
    hand: Path = (0.0, 0.0, 0.0)
    "Where the hand is reported in the robot's base, metres."
    metres: float = 0.0
    "From the reported hand to the one that its joints give."
    radians: float = 0.0
    "The same."
    apart: float = 0.0
    "Seconds between the readings of the hand and of its joints."
    outside: float = 0.0
    "Metres by which the hand is outside the workspace."
    limits: SpeedLimits = SpeedLimits()

    @classmethod
    def read(cls, sent: dict[str, Any]) -> Observation:
        """Return the observation that `asdict` turned into `sent`."""
        return cls(**{**sent, "limits": SpeedLimits(**sent["limits"])})


class Monitor:
    """Decides whether a robot does what it was commanded. Use from one thread."""

    def __init__(self, lag: float) -> None:
        """`lag` is how long after a command the readings may show it, seconds."""
        self._lag = lag
        self.forget()

    def forget(self) -> None:
        """Start again, because a person lets the robot move."""
        self._commanded: deque[tuple[float, Path]] = deque()
        self._measured: deque[tuple[float, Path, Path]] = deque()
        self._outside = math.inf

    def look(self, seen: Observation) -> str:
        """Return why the robot must stop, as display text; empty if it does what it was commanded."""
        self._commanded.append((seen.now, seen.commanded))
        problem = self._apart(seen) or self._place(seen)
        for window in WINDOWS:
            problem = problem or self._off(seen, window * self._lag)
        problem = problem or self._speed(seen)
        self._measured.append((seen.time, seen.measured, seen.hand))
        oldest = seen.time - (WINDOWS[-1] + 2) * self._lag
        while len(self._commanded) > 2 and self._commanded[1][0] < oldest:
            self._commanded.popleft()
        while len(self._measured) > 2 and self._measured[1][0] < oldest:
            self._measured.popleft()
        return problem

    def _apart(self, seen: Observation) -> str:
        """Compare the hand with its joints; both may have moved between the two readings."""
        limits, (metres, radians) = seen.limits, APART
        if seen.metres > metres + limits.speed * seen.apart or seen.radians > radians + (
            limits.turn * seen.apart
        ):
            return (
                f"the hand is reported {1e3 * seen.metres:.3g} mm and {math.degrees(seen.radians):.3g}° from "
                "where its joints put it"
            )
        return ""

    def _place(self, seen: Observation) -> str:
        self._outside = min(self._outside, seen.outside)
        if seen.outside > self._outside + OUTSIDE:
            return f"the hand is {1e3 * seen.outside:.3g} mm outside the workspace"
        return ""

    def _off(self, seen: Observation, window: float) -> str:
        """Compare the motion during a window with the motion that the commands allow."""
        start = self._reading_before(seen.time - window)
        if start is None:
            return ""
        (least_before, most_before), (least, most) = map(self._range, (start[0], seen.time))
        slack = TOLERANCE + INACCURACY * (seen.time - start[0])
        for index, (angle, before) in enumerate(zip(seen.measured, start[1], strict=True)):
            moved = angle - before
            low, high = least[index] - most_before[index], most[index] - least_before[index]
            # A joint that makes too little of its motion gets half of the slack: it may stand still.
            at_least = low * PROGRESS - slack / 2 if low > 0 else low - slack
            at_most = high * PROGRESS + slack / 2 if high < 0 else high + slack
            if at_least <= moved <= at_most:
                continue
            part = "arm" if index < len(seen.measured) - 2 else "head"
            commanded = min(max(moved, low), high)
            how = f"{math.degrees(abs(moved)):.3g}° in {seen.time - start[0]:.2g} s"
            if abs(moved) < abs(commanded):
                return f"the {part} does not move as commanded: only {how}"
            return f"the {part} moves though that was not commanded: {how}"
        return ""

    def _speed(self, seen: Observation) -> str:
        start = self._reading_before(seen.time - self._lag)
        if start is None or seen.time - start[0] > 2 * self._lag:
            return ""
        seconds, limit = seen.time - start[0], seen.limits.speed
        way = math.dist(seen.hand, start[2])
        if way <= limit * (TOO_FAST * seconds + JITTER * self._lag):
            return ""
        return f"the hand is too fast: {1e3 * way / seconds:.0f} mm/s; its limit is {1e3 * limit:.0f} mm/s"

    def _reading_before(self, time: float) -> tuple[float, Path, Path] | None:
        """Return the newest reading that is not after a time, else the oldest one; None without any."""
        found = None
        for reading in self._measured:
            if found is not None and reading[0] > time:
                break
            found = reading
        return found

    def _range(self, time: float) -> tuple[Path, Path]:
        """Return the least and the most of the commanded path during the `lag` before a time."""
        points = [self._at(time - self._lag), self._at(time)]
        points += [path for moment, path in self._commanded if time - self._lag < moment < time]
        return tuple(map(min, *points)), tuple(map(max, *points))

    def _at(self, time: float) -> Path:
        """Return the commanded path at a time, interpolated; its ends outside."""
        later: tuple[float, Path] | None = None
        for moment, path in reversed(self._commanded):
            if moment <= time:
                if later is None:
                    return path
                share = (time - moment) / (later[0] - moment)
                return tuple(a + share * (b - a) for a, b in zip(path, later[1], strict=True))
            later = moment, path
        return self._commanded[0][1]
