"""Measures what the link of several cameras carries, by their own streams at rising rates.

`RateSearch` decides, without I/O, which rate is tried next. Rates are bytes per second on the wire.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass

from grabbergui.core.errors import UsageError
from grabbergui.core.frame_queue import StreamStatistics
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.settings import SettingKey
from grabbergui.rig.link_budget import CameraLoad, Pacing, SharedLink, plan
from grabbergui.rig.settings_undo import UndoableSettings

SLOWEST_PART = 1 / 32
"Share of the nominal rate at which the search begins."
STEP = 1.5
EXACT = 1.04
"Ratio of a rate that loses packets to one that does not, at which the search ends."
LEAST_RATE = 10e3
MOST_LOSS = 0.001
"Part of the packets that any network may lose; more shows that a buffer was full."
REACHED = 0.85
"Part of a rate that must arrive, or the cameras cannot send so fast."
SETTLING, LASTING = 0.3, 1.0
"Seconds of a trial before and while packets are counted."
LEADER_AND_TRAILER = 2
"Packets of a frame that carry no payload."


@dataclass(frozen=True)
class LinkTrial:
    """The result of a rate at which all cameras sent together."""

    rate: float
    arrived: float
    "Bytes per second."
    packets: int
    lost: int
    "Packets that did not arrive the first time."

    @property
    def clean(self) -> bool:
        """Whether the link carries this rate."""
        return self.lost <= MOST_LOSS * (self.packets + self.lost)

    @property
    def reached(self) -> bool:
        """Whether the cameras sent at that rate."""
        return self.arrived >= REACHED * self.rate

    def __str__(self) -> str:
        part = self.lost / max(1, self.packets + self.lost)
        return f"{self.arrived / 1e6:.2f} MB/s arrived, {part:.1%} of the packets were lost"


class RateSearch:
    """Finds the highest rate without loss: rising steps, then halves between the last two."""

    def __init__(self, most: float) -> None:
        """`most` is the rate that the link has by name, beyond which nothing is tried."""
        self.rate: float | None = most * SLOWEST_PART
        "The next rate to try; None at the end."
        self.carried = 0.0
        "The highest that arrived without loss."
        self.limited = False
        "Whether a higher one lost packets; otherwise the cameras, or `most`, are the limit."
        self._most = most
        self._low = 0.0
        self._high: float | None = None
        self._doubted = False
        "Whether the last trial lost packets for the first time at its rate."

    def note(self, trial: LinkTrial) -> None:
        """Take note of the trial at `rate`, and choose the next.

        A rate that loses packets is tried again, as a computer that is busy for a moment loses some, too.
        """
        self._doubted = not trial.clean and not self._doubted
        if self._doubted:
            return
        if trial.clean:
            self._low = max(self._low, trial.rate)
            self.carried = max(self.carried, min(trial.arrived, trial.rate))
        else:
            self._high, self.limited = trial.rate, True
        self.rate = self._next(trial)

    def _next(self, trial: LinkTrial) -> float | None:
        if trial.clean and (not trial.reached or trial.rate >= self._most):
            return None
        if self._high is None:
            return min(self._most, trial.rate * STEP)
        if not self._low:
            return self._high / 2 if self._high / 2 >= LEAST_RATE else None
        return (self._low + self._high) / 2 if self._high > EXACT * self._low else None


def measure(
    cameras: Mapping[str, FrameGrabber],
    loads: Sequence[CameraLoad],
    most: float,
    tried: Callable[[LinkTrial], object] = lambda trial: None,
    stopped: Callable[[], bool] = lambda: False,
) -> RateSearch:
    """Measure the link with open cameras that do not stream; it takes some 30 s.

    They run free and as fast as they can; a pause after each packet makes the rate. Their settings come back.
    `tried` is called with each trial, `stopped` ends the search early. Raises UsageError for cameras without
    GevSCPD, GrabberError.
    """
    loads = [load for load in loads if load.name in cameras]
    for load in loads:
        if Pacing.PACKET_DELAY not in load.means:
            raise UsageError(f"{load.name} has no GevSCPD, so the link cannot be measured with it")
    search = RateSearch(most)
    settings = UndoableSettings()
    try:
        for load in loads:
            _run_fast(cameras[load.name], settings)
        while search.rate is not None and not stopped():
            trial = _trial(cameras, loads, search.rate, settings)
            tried(trial)
            search.note(trial)
    finally:
        settings.undo()
    return search


def _run_fast(camera: FrameGrabber, settings: UndoableSettings) -> None:
    key = SettingKey("AcquisitionFrameRate")
    if camera.has_feature(key.name) and (fastest := camera.feature(key.name).maximum):
        settings.write_if_offered(camera, key, fastest)


def _trial(
    cameras: Mapping[str, FrameGrabber],
    loads: Sequence[CameraLoad],
    rate: float,
    settings: UndoableSettings,
) -> LinkTrial:
    for each in plan(loads, SharedLink(rate, 1.0)).allotments:
        for name, value in each.settings.items():
            settings.write(cameras[each.load.name], SettingKey(name), value)
    with ExitStack() as stack, ThreadPoolExecutor(len(loads), "measure link") as pool:
        for load in loads:
            stack.callback(cameras[load.name].stop)
        list(pool.map(lambda load: cameras[load.name].start(), loads))
        time.sleep(SETTLING)
        before = {load.name: cameras[load.name].statistics() for load in loads}
        begun = time.monotonic()
        time.sleep(LASTING)
        after = {load.name: cameras[load.name].statistics() for load in loads}
        seconds = time.monotonic() - begun
    arrived, packets, lost = 0.0, 0, 0
    for load in loads:
        came, gone = _between(before[load.name], after[load.name], load)
        packets += came
        lost += gone
        arrived += came * load.frame_on_wire / (load.packets + LEADER_AND_TRAILER) / seconds
    return LinkTrial(rate, arrived, packets, lost)


def _between(before: StreamStatistics, after: StreamStatistics, load: CameraLoad) -> tuple[int, int]:
    """Return the packets that arrived and those that did not the first time."""
    lost = after.packets_missing + after.packets_resent - before.packets_missing - before.packets_resent
    frames = after.lost - before.lost
    return after.packets - before.packets, lost + frames * (load.packets + LEADER_AND_TRAILER)
