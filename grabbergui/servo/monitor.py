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
MISSING = 3.0
"How many times missing motion counts: the part may have ceased to move."
WINDOWS = (2.0, 3.0, 6.0)
"Times over which the paths are compared, in units of `lag`."
PAUSE_S = 0.075
"Seconds without observations beyond which commands may have been lost, and the robot may have been stopped."
GOES_ON = 2.0
"Share of the motion during the `lag` before a pause that a robot may go on to make without commands."
CURVES = 0.15
"Share of that motion by which it may turn aside: a controller that holds a twist turns its joints' path."
JITTER = 0.4
"Share of `lag` by which the time between two readings may be wrong."
TOO_FAST = 1.05
"Factor on the highest speed that counts as too fast."
PARTS = {"arm": slice(None, -2), "head": slice(-2, None)}
"Each part's joints in a path. A part's joints are compared together, as they are late together."
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
    stopped: bool = False
    "Whether a motion was stopped since the observation before."

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
        self._pauses: deque[tuple[float, Path, Path]] = deque()
        "When each pause ended, the motion that was commanded meanwhile, and that of a robot that goes on."
        self._stops: deque[tuple[float, Path]] = deque()
        "When a motion was stopped, and what was commanded just before: the stop may have overtaken it."
        self._outside = math.inf

    def look(self, seen: Observation) -> str:
        """Return why the robot must stop, as display text; empty if it does what it was commanded."""
        self._note_pause(seen)
        if seen.stopped and self._commanded:
            self._stops.append((seen.now, _difference(seen.commanded, self._at(seen.now - self._lag))))
        self._commanded.append((seen.now, seen.commanded))
        problem = self._apart(seen) or self._place(seen)
        for window in WINDOWS:
            problem = problem or self._off(seen, window * self._lag)
        problem = problem or self._speed(seen)
        self._measured.append((seen.time, seen.measured, seen.hand))
        oldest = seen.time - (WINDOWS[-1] + 2) * self._lag
        while len(self._commanded) > 2 and self._commanded[1][0] < oldest:
            self._commanded.popleft()
        for noted in (self._pauses, self._stops):
            while noted and noted[0][0] < oldest:
                noted.popleft()
        while len(self._measured) > 2 and self._measured[1][0] < oldest:
            self._measured.popleft()
        return problem

    def _note_pause(self, seen: Observation) -> None:
        """Note a while without observations: the computer or the network was busy, and commands may be lost.

        Then the robot goes on for a moment as before, and rests.
        """
        if not self._measured:
            return
        pause = max(seen.now - self._commanded[-1][0], seen.time - self._measured[-1][0])
        if pause > PAUSE_S:
            begun, before = (self._at(seen.now - pause - seconds) for seconds in (0.0, self._lag))
            further = tuple(GOES_ON * step for step in _difference(begun, before))
            self._pauses.append((seen.now, _difference(seen.commanded, begun), further))

    def _apart(self, seen: Observation) -> str:
        """Compare the hand with its joints; both may have moved between the two readings."""
        limits, (metres, radians) = seen.limits, APART
        if seen.metres > metres + limits.speed * seen.apart or seen.radians > radians + (
            limits.turn * seen.apart
        ):
            off = f"{1e3 * seen.metres:.3g} mm and {round(math.degrees(seen.radians), 2):g}°"
            return f"the hand is reported {off} from where its joints put it"
        return ""

    def _place(self, seen: Observation) -> str:
        self._outside = min(self._outside, seen.outside)
        if seen.outside > self._outside + OUTSIDE:
            return f"the hand is {1e3 * seen.outside:.3g} mm outside the workspace"
        return ""

    def _off(self, seen: Observation, window: float) -> str:
        """Compare the motion during a window with the motions that the commands allow."""
        start = self._reading_before(seen.time - window)
        if start is None:
            return ""
        before, after, seconds = self._points(start[0]), self._points(seen.time), seen.time - start[0]
        moved = _difference(seen.measured, start[1])
        pauses = [pause for pause in self._pauses if pause[0] > start[0]]
        overtaken = [motion for moment, motion in self._stops if moment > start[0]]
        slack = (TOLERANCE + INACCURACY * seconds) * (1 + 2 * len(pauses))
        for part, joints in PARTS.items():
            starts, ends = [path[joints] for path in before], [path[joints] for path in after]
            off = _direction(moved[joints], starts, ends)
            along = _dot(off, moved[joints])
            furthest = max(_dot(off, path) for path in ends) - min(_dot(off, path) for path in starts)
            for lost in overtaken:
                furthest += max(-_dot(off, lost[joints]), 0.0)
            for _, lost, further in pauses:
                goes_on = max(_dot(off, further[joints]), CURVES * math.hypot(*further[joints]))
                furthest += max(-_dot(off, lost[joints]), 0.0) + goes_on
            extra = max(along, 0.0) - max(furthest, 0.0)
            missing = min(along, 0.0) - PROGRESS * min(furthest, 0.0)
            if extra + MISSING * missing <= slack:
                continue
            most = math.degrees(extra if extra > missing else max(map(abs, moved[joints])))
            if extra > missing:
                return f"the {part} moves though that was not commanded: {most:.3g}° in {seconds:.2g} s"
            return f"the {part} does not move as commanded: only {most:.3g}° in {seconds:.2g} s"
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

    def _points(self, time: float) -> list[Path]:
        """Return the commanded path during the `lag` before a time, oldest first."""
        between = [path for moment, path in self._commanded if time - self._lag < moment < time]
        return [self._at(time - self._lag), *between, self._at(time)]

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


def _direction(moved: Path, before: list[Path], after: list[Path]) -> Path:
    """Return the unit vector from the nearest motion that was commanded to the one that was made.

    `before` and `after` are the commanded paths from which and to which the joints may have moved. Zero where
    the motion was commanded.
    """
    least = tuple(PROGRESS * step for step in _difference(after[0], before[-1]))
    range_ = _difference(_difference(after[-1], before[0]), least)
    from_least = _difference(moved, least)
    share = _dot(from_least, range_) / max(_dot(range_, range_), 1e-12)
    off = _difference(from_least, tuple(min(max(share, 0.0), 1.0) * step for step in range_))
    size = math.hypot(*off)
    return tuple(value / size for value in off) if size > 0 else off


def _difference(a: Path, b: Path) -> Path:
    return tuple(x - y for x, y in zip(a, b, strict=True))


def _dot(a: Path, b: Path) -> float:
    return sum(x * y for x, y in zip(a, b, strict=True))
