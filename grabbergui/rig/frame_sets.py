"""Matched sets: the frames of several cameras that belong to one moment. No I/O, no clock.

A set is complete, late or incomplete, but never mismatched: a frame that cannot be assigned with certainty is
counted and left out. Three rules find the set of a frame:

- `MatchByTime`: frames whose times on the host's clock lie within a tolerance of each other;
- `MatchByCounter`: frames with the same number of the trigger, checked by their times if these are certain;
- `MatchByAction`: frames within the tolerance of a moment that was scheduled.

All times are nanoseconds of one clock; `now` may be of another one. One thread.
"""

from __future__ import annotations

import difflib
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum
from typing import Generic, NoReturn, TypeVar

from typing_extensions import override

from grabbergui.core.errors import MissingFrameError
from grabbergui.rig.set_statistics import SetStatistics

T = TypeVar("T")

MOST_OPEN = 64
"Sets that wait for frames at the same time; beyond that, the oldest is given up."


class SetState(Enum):
    """Whether all frames of a set arrived."""

    COMPLETE = "complete"
    LATE = "late"
    "All arrived, the last of them later than `SetTimes.deadline_ns` after the first."
    INCOMPLETE = "incomplete"


@dataclass(frozen=True)
class FrameStamp:
    """The moment of a frame."""

    time_ns: int
    "On the clock that all cameras share, after mapping."
    uncertainty_ns: int = 0
    "The true time is within this of `time_ns`."
    counter: int | None = None
    "The number of the trigger, if the camera reports it."


@dataclass(frozen=True)
class SetTimes:
    """The times that decide about a set."""

    tolerance_ns: int
    "Largest difference between the times of two frames of one set."
    least_tolerance_ns: int = 0
    """If not 0, the tolerance shrinks to half of the least time between two frames of a camera, but not below
    this: for triggers whose rate is unknown."""
    period_ns: int = 0
    "Least time between two moments; 0 if unknown, as for cameras that run free."
    skew_ns: int = 0
    "Largest true difference between frames of one moment, as by trigger delays."
    deadline_ns: int = 100_000_000
    "Time from the arrival of a set's first frame after which the set is late."
    wait_ns: int = 1_000_000_000
    "Time from the arrival of a set's first frame after which the set is given up."

    def certain(self, stamp: FrameStamp) -> bool:
        """Whether the time alone distinguishes a frame's moment from the next one.

        Frames of one moment are measured at most `skew + 2 u` apart, those of different moments at least
        `period - skew - 2 u`; the tolerance must separate the two.
        """
        spread = self.skew_ns + 2 * stamp.uncertainty_ns
        if not self.period_ns:
            return spread <= self.tolerance_ns
        return spread <= self.tolerance_ns < self.period_ns - spread


class FrameSet(dict[str, T], Generic[T]):
    """The frames of one moment, by the names of their cameras."""

    def __init__(self, index: int, stamp: FrameStamp, arrived_ns: int, cameras: Sequence[str]) -> None:
        super().__init__()
        self.index = index
        "Counts the sets in the order of their moments, those that are not delivered included."
        self.state = SetState.INCOMPLETE
        self.stamps: dict[str, FrameStamp] = {}
        self.arrived_ns = arrived_ns
        "When the first frame arrived; before that, when it is due."
        self._place_ns = stamp.time_ns
        self._cameras = tuple(cameras)

    def __missing__(self, camera: str) -> NoReturn:
        if camera in self._cameras:
            raise MissingFrameError(f"set {self.index} has no frame of {camera}; see `missing` first")
        near = difflib.get_close_matches(str(camera), self._cameras, n=1)
        hint = f"did you mean {near[0]}?" if near else f"there are {', '.join(self._cameras)}"
        raise MissingFrameError(f"there is no camera {camera}; {hint}")

    @property
    def cameras(self) -> tuple[str, ...]:
        """The names of all cameras of the rig, in its order."""
        return self._cameras

    @property
    def time_ns(self) -> int:
        """The earliest time of its frames; without frames, the time that was scheduled."""
        return min((stamp.time_ns for stamp in self.stamps.values()), default=self._place_ns)

    @property
    def skew_ns(self) -> int:
        """The time between the earliest and the latest of its frames; 0 with fewer than two."""
        times = [stamp.time_ns for stamp in self.stamps.values()]
        return max(times) - min(times) if times else 0

    @property
    def missing(self) -> tuple[str, ...]:
        """The names of the cameras without a frame in this set, in the rig's order."""
        return tuple(name for name in self._cameras if name not in self.stamps)

    def distance_ns(self, stamp: FrameStamp) -> int:
        """Return the largest time between a frame and those that are here."""
        times = [each.time_ns for each in self.stamps.values()] or [self._place_ns]
        return max(abs(stamp.time_ns - time) for time in times)

    def put_in_order(self) -> None:
        """Order the frames as the cameras are in the rig."""
        present = [name for name in self._cameras if name in self.stamps]
        frames = {name: self[name] for name in present}
        self.stamps = {name: self.stamps[name] for name in present}
        self.clear()
        self.update(frames)

    def put(self, camera: str, frame: T, stamp: FrameStamp, arrived_ns: int) -> None:
        """Add the frame of a camera that is missing."""
        if not self.stamps:
            self.arrived_ns = arrived_ns
        self[camera] = frame
        self.stamps[camera] = stamp


class SetMatcher(ABC, Generic[T]):
    """Gathers frames into sets; subclasses say which set a frame belongs to.

    `add`, `advance` and `flush` return the sets that are finished, in the order of their moments.
    """

    def __init__(self, cameras: Sequence[str], times: SetTimes, *, deliver_incomplete: bool = True) -> None:
        """`cameras` in the order of the rig. Incomplete sets are counted even if they are not delivered."""
        self.cameras = tuple(cameras)
        self.times = times
        self.statistics = SetStatistics(self.cameras)
        self._deliver_incomplete = deliver_incomplete
        self._open: list[FrameSet[T]] = []
        "In the order of their moments."
        self._delivered_ns: int | None = None
        "Time of the last finished set."
        self._newest: dict[str, int] = {}
        self._absent: set[str] = set()

    @property
    def waiting(self) -> int:
        """Number of sets that wait for frames."""
        return len(self._open)

    def add(self, camera: str, frame: T, stamp: FrameStamp, now_ns: int) -> list[FrameSet[T]]:
        """Assign a frame; return the finished sets."""
        if camera not in self.cameras:
            raise ValueError(f"{camera} is not one of {', '.join(self.cameras)}")
        self._absent.discard(camera)
        self._learn(camera, stamp)
        if (found := self._set_of(camera, stamp, now_ns)) is not None:
            found.put(camera, frame, stamp, now_ns)
            if not found.missing:
                late = now_ns - found.arrived_ns > self.times.deadline_ns
                found.state = SetState.LATE if late else SetState.COMPLETE
        self._newest[camera] = max(self._newest.get(camera, stamp.time_ns), stamp.time_ns)
        return self.advance(now_ns)

    def _learn(self, camera: str, stamp: FrameStamp) -> None:
        least, last = self.times.least_tolerance_ns, self._newest.get(camera)
        if least and last is not None and last < stamp.time_ns:
            tolerance = max(least, (stamp.time_ns - last) // 2)
            if tolerance < self.times.tolerance_ns:
                self.times = replace(self.times, tolerance_ns=tolerance)

    def set_present(self, camera: str, present: bool) -> None:
        """No longer wait for a camera that is lost; wait again for one that is back."""
        (self._absent.discard if present else self._absent.add)(camera)

    def advance(self, now_ns: int) -> list[FrameSet[T]]:
        """Let time pass: return the sets that are finished or given up by now."""
        finished = []
        while self._open and (self._is_finished(self._open[0], now_ns) or len(self._open) > MOST_OPEN):
            finished.append(self._open.pop(0))
        return self._delivered(finished)

    def flush(self) -> list[FrameSet[T]]:
        """Give up all sets that wait, as at the end of the stream."""
        finished, self._open = self._open, []
        return self._delivered(finished)

    @abstractmethod
    def _set_of(self, camera: str, stamp: FrameStamp, now_ns: int) -> FrameSet[T] | None:
        """Return the open or a new set for a frame; None, counted, for one that belongs to none."""

    def _is_finished(self, candidate: FrameSet[T], now_ns: int) -> bool:
        if not candidate.missing or now_ns - candidate.arrived_ns >= self.times.wait_ns:
            return True
        # A camera sends its frames in order, so one that was followed by a later frame is lost.
        return all(name in self._absent or self._has_passed(name, candidate) for name in candidate.missing)

    def _has_passed(self, camera: str, candidate: FrameSet[T]) -> bool:
        """Whether a camera has sent a frame of a later moment."""
        beyond = candidate.time_ns + self.times.tolerance_ns
        return self._newest.get(camera, beyond) > beyond

    def _delivered(self, finished: list[FrameSet[T]]) -> list[FrameSet[T]]:
        for each in finished:
            each.put_in_order()
            self._delivered_ns = max(each.time_ns, self._delivered_ns or each.time_ns)
            self.statistics.count(each.state.value, each.skew_ns, each.missing)
        return [each for each in finished if not each.missing or self._deliver_incomplete]

    def _is_overdue(self, stamp: FrameStamp) -> bool:
        """Whether a later set, or the set of this frame, was finished before the frame arrived."""
        return self._delivered_ns is not None and stamp.time_ns <= self._delivered_ns + self.times.skew_ns

    def _begin(self, stamp: FrameStamp, now_ns: int, index: int = 0) -> FrameSet[T]:
        begun: FrameSet[T] = FrameSet(index, stamp, now_ns, self.cameras)
        place = len(self._open)
        while place and self._open[place - 1].time_ns > stamp.time_ns:
            place -= 1
        self._open.insert(place, begun)
        return begun

    def _nearest(self, camera: str, stamp: FrameStamp) -> FrameSet[T] | None:
        """Return the open set, without a frame of this camera, that is nearest in time and near enough."""
        fitting = [
            (distance, each)
            for each in self._open
            if camera not in each.stamps and (distance := each.distance_ns(stamp)) <= self.times.tolerance_ns
        ]
        return min(fitting, key=lambda pair: pair[0])[1] if fitting else None


class MatchByTime(SetMatcher[T]):
    """Sets by the times of their frames on a common clock."""

    _finished = 0
    "Number of sets that are finished, and so the index of the next one."

    @override
    def _delivered(self, finished: list[FrameSet[T]]) -> list[FrameSet[T]]:
        for index, each in enumerate(finished, self._finished):
            each.index = index
        self._finished += len(finished)
        return super()._delivered(finished)

    @override
    def _set_of(self, camera: str, stamp: FrameStamp, now_ns: int) -> FrameSet[T] | None:
        if not self.times.certain(stamp):
            self.statistics.uncertain += 1
            return None
        if (near := self._nearest(camera, stamp)) is not None:
            return near
        if self._is_overdue(stamp):
            self.statistics.overdue += 1
            return None
        return self._begin(stamp, now_ns)


class MatchByAction(MatchByTime[T]):
    """Sets by the moments for which frames were scheduled; other frames are left out."""

    def expect(self, time_ns: int, due_ns: int) -> None:
        """Announce the moment of the next set, which on the clock of arrivals is `due_ns`."""
        self._begin(FrameStamp(time_ns), due_ns)

    @override
    def _set_of(self, camera: str, stamp: FrameStamp, now_ns: int) -> FrameSet[T] | None:
        near = self._nearest(camera, stamp) if self.times.certain(stamp) else None
        if near is None:
            self.statistics.strays += 1
        return near


class MatchByCounter(SetMatcher[T]):
    """Sets by the number of the trigger that each camera reports.

    All cameras count from the same trigger on. Where times are certain they are checked: a camera whose
    numbers no longer agree with its times has missed a trigger (or counts from one again), and gets a new
    origin by its times.
    """

    def __init__(
        self,
        cameras: Sequence[str],
        times: SetTimes,
        *,
        first: int = 1,
        modulus: int = 0,
        deliver_incomplete: bool = True,
    ) -> None:
        """`first` is the number of the first trigger; `modulus`, if not 0, how many numbers there are."""
        super().__init__(cameras, times, deliver_incomplete=deliver_incomplete)
        self._first = first
        self._modulus = modulus
        self._last: dict[str, int] = {}
        "By camera, the last number, counted on beyond the modulus."
        self._origin: dict[str, int] = {}
        self._finished_index = -1

    @override
    def _set_of(self, camera: str, stamp: FrameStamp, now_ns: int) -> FrameSet[T] | None:
        if stamp.counter is None:
            self.statistics.strays += 1
            return None
        number = self._counted_on(camera, stamp.counter)
        index = number - self._origin.setdefault(camera, self._first)
        found = next((each for each in self._open if each.index == index), None)
        certain = self.times.certain(stamp)
        if certain and (found is None or found.distance_ns(stamp) > self.times.tolerance_ns):
            near = self._nearest(camera, stamp)
            if near is None and found is not None and stamp.time_ns > found.time_ns:
                index = found.index + 1
                near = next((each for each in self._open if each.index == index), None)
                if near is not None:  # of another moment: only the next frames can tell
                    self.statistics.strays += 1
                    return None
                self.statistics.slips += 1
                self._origin[camera], found = number - index, None
            elif near is not None:
                self.statistics.slips += 1
                self._origin[camera] = number - near.index
                return near
            elif found is not None:
                self.statistics.strays += 1
                return None
        if self._conflicts(found, stamp):
            self.statistics.strays += 1
            return None
        if found is not None:
            if camera not in found.stamps:
                return found
            self.statistics.strays += 1  # the same number twice
            return None
        if index <= self._finished_index or (certain and self._is_overdue(stamp)):
            self.statistics.overdue += 1
            return None
        return self._begin_between(stamp, now_ns, index, certain=certain)

    def _conflicts(self, found: FrameSet[T] | None, stamp: FrameStamp) -> bool:
        """Whether two frames of one number cannot be of one moment, however wrong their times are."""
        if found is None or not self.times.period_ns:
            return False
        return any(
            abs(stamp.time_ns - other.time_ns)
            > self.times.tolerance_ns + stamp.uncertainty_ns + other.uncertainty_ns
            for other in found.stamps.values()
        )

    def _begin_between(
        self, stamp: FrameStamp, now_ns: int, index: int, *, certain: bool
    ) -> FrameSet[T] | None:
        begun = self._begin(stamp, now_ns, index)
        self._open.sort(key=lambda each: each.index)
        ordered = [each.time_ns for each in self._open]
        if certain and ordered != sorted(ordered):
            # Its number and its time contradict each other, and no set shows which one is right.
            self._open.remove(begun)
            self.statistics.strays += 1
            return None
        return begun

    @override
    def _has_passed(self, camera: str, candidate: FrameSet[T]) -> bool:
        number = self._last.get(camera)
        return number is not None and number - self._origin[camera] > candidate.index

    @override
    def _delivered(self, finished: list[FrameSet[T]]) -> list[FrameSet[T]]:
        self._finished_index = max([self._finished_index, *(each.index for each in finished)])
        return super()._delivered(finished)

    def _counted_on(self, camera: str, counter: int) -> int:
        """Return the number without the jump back after the largest one."""
        last = self._last.get(camera)
        if self._modulus and last is not None:
            ahead = (counter - last) % self._modulus
            counter = last + ahead - (self._modulus if ahead > self._modulus // 2 else 0)
        self._last[camera] = counter
        return counter
