"""Collects what a camera reports of its trigger while it streams, for the diagnosis.

It switches the camera's events on: missed triggers, and the edges of the line that triggers.
"""

from __future__ import annotations

import logging
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

from grabbergui.core.errors import GrabberError
from grabbergui.core.features import FeatureValue
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import DeviceEvent, FrameGrabber
from grabbergui.core.settings import Selected, SettingKey
from grabbergui.rig.clock_fit import HostTime
from grabbergui.rig.rig_file import TriggerEntry
from grabbergui.rig.settings_undo import UndoableSettings
from grabbergui.rig.trigger_diagnosis import ActionKeys, TriggerEvidence, TriggerFinding, diagnose

log = logging.getLogger(__name__)

KEPT = 512
"Events, frames and triggers that are kept of each kind."
MISSED = "FrameTriggerMissed"
FRAMES, SENT = "frames", "sent"
ToHost = Callable[[int], HostTime | None]
SETTLED = 1.0
"Seconds after which a trigger that was sent has made its frame, or never will."


@dataclass(frozen=True)
class TriggerCounts:
    """Triggers of one camera since the watch began; None for what the camera does not report."""

    sent: int | None
    "Sent by us, or seen on the line."
    accepted: int
    "Those that made frames, whether or not these arrived."
    missed: int | None


class _Times:
    """The latest times of one kind of event, on its clock and on ours, and how many there were."""

    def __init__(self) -> None:
        self.count = 0
        self._times: deque[tuple[float, int]] = deque(maxlen=KEPT)

    def add(self, time_ns: int) -> None:
        self.count += 1
        self._times.append((time.monotonic(), time_ns))

    @property
    def complete_from(self) -> float:
        """The time of `time.monotonic` from which on all are here."""
        return self._times[0][0] if len(self._times) == KEPT else 0.0

    def since(self, begin: float) -> tuple[int, ...]:
        """Return those that came after a time of `time.monotonic`."""
        return tuple(time_ns for at, time_ns in self._times if at >= begin)

    def longest_gap(self) -> float:
        """Return the longest time between two of them in seconds; 0 if there were not two."""
        arrivals = [at for at, _ in self._times]
        return max((b - a for a, b in pairwise(arrivals)), default=0.0)


class TriggerWatch:
    """Watches one camera under a trigger. Any thread."""

    def __init__(
        self,
        grabber: FrameGrabber,
        entry: TriggerEntry,
        settings: UndoableSettings,
        to_host: ToHost,
        leader_to_host: ToHost | None = None,
        *,
        selected: Selected = (),
        burst_frames: int = 1,
        frame_start_waits: bool = False,
    ) -> None:
        """Switch the events on; `settings` takes note of what is to be put back.

        `to_host` returns the host's time at a time of the camera; None while its clock is not known.
        `leader_to_host` does so for the leading camera that triggers this one, if there is one.
        `selected` is the entry of TriggerSelector, if it is not the selected one; each trigger makes
        `burst_frames`, and with `frame_start_waits` each of these waits for a trigger of its own.
        """
        self._selected = selected
        self._burst_frames = burst_frames
        self._frame_start_waits = frame_start_waits
        self._to_host = to_host
        self._leader_to_host = leader_to_host
        self._grabber = grabber
        self._entry = entry
        self._lock = threading.Lock()
        self._source = {"action": "Action1", "software": "Software"}.get(entry.by, entry.input)
        self._rising, self._falling = f"{self._source}RisingEdge", f"{self._source}FallingEdge"
        self._events = {name: _Times() for name in (MISSED, self._rising, self._falling)}
        self._on = {name for name in self._events if self._switch_on(name, settings)}
        self._frames, self._sent, self._acknowledged = _Times(), _Times(), _Times()
        self._sent_lost = 0
        self._lost_before = self._lost()
        self._losses: deque[tuple[float, int]] = deque([(time.monotonic(), 0)], maxlen=KEPT)
        "Frames lost by then, and when that was asked."
        grabber.event_received.connect(self._on_event)

    def close(self) -> None:
        """Listen no more."""
        self._grabber.event_received.disconnect(self._on_event, missing_ok=True)

    def note_sent(self, moment_ns: int, *, acknowledged: bool, lost_before: int = 0) -> None:
        """Take note of a trigger that was sent to this camera, by us or the leader, on the sender's clock.

        The leader's times are converted when they are judged: by then its clock is known best, and how
        exactly. `lost_before` exposures of the leader came before that, whose frames were lost.
        """
        with self._lock:
            if acknowledged:  # first, so that a window never has fewer acknowledges
                self._acknowledged.add(moment_ns)
            self._sent.add(moment_ns)
            self._sent_lost += lost_before

    def note_frame(self, frame: Frame) -> None:
        """Take note of a frame that arrived."""
        with self._lock:
            self._frames.add(frame.timestamp_ns or round(frame.captured * 1e9))

    def counts(self) -> TriggerCounts:
        """Return how many triggers there were. Makes no request to the camera."""
        with self._lock:
            sent: int | None = self._sent.count
            if {self._rising, self._falling} <= self._on:
                activation = self._entry.activation
                edges = {"RisingEdge": [self._rising], "FallingEdge": [self._falling]}
                names = edges.get(activation, [self._rising, self._falling])
                sent = sum(self._events[name].count for name in names)
            elif self._source.startswith("Line"):
                sent = None
            accepted = (self._frames.count + self._lost_since()) // self._burst_frames
            if sent is not None:
                # A frame may be here before its trigger is acknowledged or reported, and the first may be of
                # a trigger from before the watch.
                accepted = min(accepted, sent)
            missed: int | None = None
            if MISSED in self._on:
                missed = self._events[MISSED].count
            elif sent is not None:
                settled = sent - len(self._sent.since(time.monotonic() - SETTLED))
                missed = max(0, settled - accepted)
            return TriggerCounts(sent, accepted, missed)

    def longest_gap(self) -> float:
        """Return the longest time between two signs of a trigger, in seconds; 0 if there were not two."""
        with self._lock:
            times = [self._frames, self._sent, *self._events.values()]
            return max(each.longest_gap() for each in times)

    def finding(self, last: float | None = None) -> TriggerFinding:
        """Return what is wrong with the trigger. Reads settings; raises GrabberError.

        With `last`, only what happened in so many seconds counts.
        """
        return diagnose(self.evidence(last))

    def evidence(self, last: float | None = None) -> TriggerEvidence:
        """Return what is known by now, or of the `last` seconds. Reads settings; raises GrabberError."""
        exposure = round(self._number("ExposureTime") * 1000)
        now = time.monotonic()
        begin = 0.0 if last is None else now - last
        with self._lock:
            # Counts of different kinds compare only over the time of which all of them are kept.
            kinds = (*self._events.values(), self._frames, self._sent, self._acknowledged)
            begin = max(begin, *(each.complete_from for each in kinds))
            events = {name: times.since(begin) for name, times in self._events.items()}
            frames, sent = self._frames.since(begin), self._sent.since(begin)
            acknowledged, sent_lost = len(self._acknowledged.since(begin)), self._sent_lost
            lost = self._lost_since()
            before = [count for at, count in self._losses if at <= begin]
            self._losses.append((now, lost))
        by_line = self._entry.by == "line"
        clock_ns = 0
        if by_line:
            events, clock_ns = _on_host_clock(self._to_host, {**events, FRAMES: frames})
            frames = events.pop(FRAMES)
            if self._leader_to_host is not None:
                leaders, uncertainty_ns = _on_host_clock(self._leader_to_host, {SENT: sent})
                sent = leaders[SENT] if clock_ns and uncertainty_ns else ()
                clock_ns += uncertainty_ns
        edges = by_line and {self._rising, self._falling} <= self._on
        return TriggerEvidence(
            self._source,
            frames=frames,
            lost=max(0, lost - (before[-1] if before else 0)),
            activation=self._text("TriggerActivation", self._entry.activation, self._selected),
            rising=events[self._rising] if edges else None,
            falling=events[self._falling] if edges else None,
            level=self._level() if by_line and self._source.startswith("Line") else None,
            sent=sent,
            sent_lost=sent_lost,
            clock_ns=clock_ns,
            missed=events[MISSED],
            exposure_ns=exposure,
            readout_ns=self._readout_ns(exposure),
            overlapping=self._text("TriggerOverlap", "ReadOut", self._selected) != "Off",
            burst_frames=self._burst_frames,
            frame_start_waits=self._frame_start_waits,
            action=self._keys_sent(),
            accepted=self._keys_accepted(),
            acknowledged=acknowledged if self._entry.by == "action" else None,
            rate=0.0 if by_line else self._entry.rate,
        )

    def _switch_on(self, name: str, settings: UndoableSettings) -> bool:
        key = SettingKey("EventNotification", (("EventSelector", name),))
        try:
            return settings.write_if_offered(self._grabber, key, "On")
        except GrabberError as error:
            log.info("%s: %s", name, error)
            return False

    def _on_event(self, event: DeviceEvent) -> None:
        if (times := self._events.get(event.name)) is None:
            return
        stamp = event.values.get(f"Event{event.name}Timestamp")
        with self._lock:
            times.add(stamp if isinstance(stamp, int) else time.monotonic_ns())

    def _lost_since(self) -> int:
        # A stream that is started again counts from zero.
        return max(0, self._lost() - self._lost_before)

    def _lost(self) -> int:
        statistics = self._grabber.statistics()
        return statistics.lost + statistics.incomplete

    def _value(self, name: str) -> FeatureValue | None:
        return self._grabber.feature(name).value if self._grabber.has_feature(name) else None

    def _number(self, name: str) -> float:
        value = self._value(name)
        return float(value) if isinstance(value, int | float) else 0.0

    def _text(self, name: str, default: str, selected: Selected = ()) -> str:
        if not self._grabber.has_feature(name):
            return default
        value = self._grabber.read_setting(SettingKey(name, selected)).value
        return default if value is None else str(value)

    def _level(self) -> bool | None:
        key = SettingKey("LineStatus", (("LineSelector", self._source),))
        if not self._grabber.has_feature("LineStatus"):
            return None
        value = self._grabber.read_setting(key).value
        return value if isinstance(value, bool) else None

    def _readout_ns(self, exposure: int) -> int:
        """Return the time of the readout: the camera's, or what its fastest frame rate leaves besides."""
        if readout := self._number("SensorReadoutTime"):
            return round(readout * 1000)
        if not self._grabber.has_feature("AcquisitionFrameRate"):
            return 0
        fastest = self._grabber.feature("AcquisitionFrameRate").maximum
        return round(1e9 / fastest) if fastest else exposure

    def _keys_sent(self) -> ActionKeys | None:
        entry = self._entry
        if entry.by != "action":
            return None
        return ActionKeys(entry.device_key, entry.group_key, entry.group_mask)

    def _keys_accepted(self) -> ActionKeys | None:
        """Return the camera's keys; None if it does not show them all."""
        if self._entry.by != "action":
            return None
        names = ("ActionDeviceKey", "ActionGroupKey", "ActionGroupMask")
        values = [value for name in names if isinstance(value := self._value(name), int)]
        return ActionKeys(*values) if len(values) == len(names) else None


def _on_host_clock(
    to_host: ToHost, times: dict[str, tuple[int, ...]]
) -> tuple[dict[str, tuple[int, ...]], int]:
    """Return times on the host's clock, and how exact they are; unchanged and 0 if the clock is not known."""
    found = {name: [to_host(each) for each in some] for name, some in times.items()}
    known = {name: [each for each in some if each is not None] for name, some in found.items()}
    uncertainties = [each.uncertainty_ns for some in known.values() for each in some]
    if not uncertainties or any(len(known[name]) < len(some) for name, some in times.items()):
        return times, 0
    return {name: tuple(each.time_ns for each in some) for name, some in known.items()}, max(uncertainties)
