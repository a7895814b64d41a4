"""Gathers the frames of open cameras into sets, with a thread for each camera."""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Callable, Iterable, Mapping

from grabbergui.core.errors import GrabberError
from grabbergui.core.frame import Frame
from grabbergui.core.frame_period import frame_period
from grabbergui.core.frame_queue import FrameSink
from grabbergui.core.grabber import FrameGrabber
from grabbergui.rig.camera_clock import CameraClock, network_clock
from grabbergui.rig.frame_sets import FrameSet, FrameStamp, MatchByAction, SetMatcher, SetTimes
from grabbergui.rig.rig_file import RigEntry
from grabbergui.rig.set_statistics import SetCounts

DEPTH = 16
"Frames of a camera that may wait to be assigned."
USUAL_PERIOD = 1 / 30
"Seconds between frames of a camera that does not report it."
SOFTWARE_SKEW = 0.05
"Seconds between the software triggers of two cameras that a busy computer may need."
CHECK = 0.02
"Seconds between checks whether a set is to be given up."


def set_times(entry: RigEntry, grabbers: Iterable[FrameGrabber]) -> SetTimes:
    """Return the times that decide about sets, from a rig's file and the cameras' frame rates."""
    grabbers = tuple(grabbers)
    periods = [period for grabber in grabbers if (period := frame_period(grabber)) > 0]
    rate = entry.trigger.rate if entry.trigger.by != "free" else 0.0
    if entry.trigger.by == "free":
        period = max(periods, default=USUAL_PERIOD)
    else:
        period = 1 / rate if rate else min(periods, default=USUAL_PERIOD)
    tolerance, least = entry.tolerance or period / 2, 0.0
    if not entry.tolerance and not rate and any(map(_is_triggered_by_software, grabbers)):
        tolerance, least = max(tolerance, SOFTWARE_SKEW), tolerance
    return SetTimes(
        tolerance_ns=round(tolerance * 1e9),
        least_tolerance_ns=round(least * 1e9),
        period_ns=round(1e9 / rate) if rate else 0,
        deadline_ns=round(entry.deadline * 1e9),
        wait_ns=round(max(entry.wait, 2 * period) * 1e9),
    )


def _is_triggered_by_software(grabber: FrameGrabber) -> bool:
    wanted = {"TriggerMode": "On", "TriggerSource": "Software"}
    with contextlib.suppress(GrabberError):
        return all(
            grabber.has_feature(name) and grabber.feature(name).value == value
            for name, value in wanted.items()
        )
    return False


class SetStream:
    """Takes the frames of all cameras, on a thread each, and delivers sets in order. Any thread."""

    def __init__(
        self,
        grabbers: Mapping[str, FrameGrabber],
        clocks: Mapping[str, CameraClock],
        matcher: SetMatcher[Frame],
        deliver: Callable[[FrameSet[Frame]], object],
        taken: Callable[[str, Frame, FrameStamp], object] = lambda camera, frame, stamp: None,
    ) -> None:
        """`deliver` is called with each finished set, by one thread at a time; it must not wait.

        `taken` is called with each frame before, on the thread of its camera.
        """
        self.matcher = matcher
        self._clocks = dict(clocks)
        self._deliver = deliver
        self._taken = taken
        self._lock = threading.Lock()
        self._sinks = [
            FrameSink(
                grabber,
                lambda frame, name=name: self._take(name, frame),  # type: ignore[misc]
                name=f"rig {name}",
                depth=DEPTH,
                wait=CHECK,
                between=self._advance,
            )
            for name, grabber in grabbers.items()
        ]

    def counts(self) -> SetCounts:
        """Return how the sets came out so far, all of one moment."""
        with self._lock:
            return self.matcher.statistics.counts()

    @property
    def dropped(self) -> int:
        """Frames that were dropped because the sets could not be gathered fast enough."""
        return sum(sink.dropped for sink in self._sinks)

    def start(self) -> None:
        """Begin. Once only."""
        for sink in self._sinks:
            sink.start()

    def stop(self) -> None:
        """End all threads and deliver what waits."""
        for sink in self._sinks:
            sink.stop()
        with self._lock:
            self._hand_over(self.matcher.flush())

    def expect(self, moment_ns: int) -> None:
        """Announce a set, for matching by action."""
        if isinstance(self.matcher, MatchByAction):
            with self._lock:
                self.matcher.expect(moment_ns, moment_ns)

    def set_present(self, camera: str, *, present: bool) -> None:
        """No longer wait for a camera that is lost, or wait for it again."""
        with self._lock:
            self.matcher.set_present(camera, present)

    def _take(self, camera: str, frame: Frame) -> None:
        stamp = self._clocks[camera].stamp(frame, network_clock(self._clocks.values()))
        self._taken(camera, frame, stamp)
        with self._lock:
            self._hand_over(self.matcher.add(camera, frame, stamp, time.monotonic_ns()))

    def _advance(self) -> None:
        with self._lock:
            self._hand_over(self.matcher.advance(time.monotonic_ns()))

    def _hand_over(self, finished: list[FrameSet[Frame]]) -> None:
        for each in finished:
            self._deliver(each)
