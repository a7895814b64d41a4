"""The trigger of one open source, camera or rig: sends it, counts it, and describes what is wrong."""

from __future__ import annotations

import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field

from typing_extensions import override

from grabbergui.core.errors import GrabberError
from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import FrameSink
from grabbergui.core.grabber import Access, FrameGrabber
from grabbergui.core.settings import SettingKey
from grabbergui.rig.grabber import RigGrabber
from grabbergui.rig.repeating import Repeater
from grabbergui.rig.rig_file import TriggerEntry
from grabbergui.rig.settings_undo import UndoableSettings
from grabbergui.rig.trigger_diagnosis import TriggerCause
from grabbergui.rig.trigger_setup import TriggerSetup
from grabbergui.rig.trigger_watch import TriggerCounts, TriggerWatch

PATIENCE = 3.0
"Seconds that a watch lasts before it says that no signal comes."
RECENT = 10.0
"Seconds of the past that are judged at least, so that a fault that was mended is not named for long."
GAPS = 3.0
"Longest gaps between triggers that are judged at least, so that a slow signal is not missed."


@dataclass(frozen=True)
class TriggerReport:
    """The state of a trigger."""

    counts: TriggerCounts
    findings: dict[str, str] = field(default_factory=dict)
    "Problems: a sentence for each camera by its name in the rig, which is empty without a rig."


class LiveTrigger(ABC):
    """The trigger of one source while it is on."""

    sendable: bool
    "Whether software can send it."

    @abstractmethod
    def send(self) -> None:
        """Send one trigger. Any thread. Raises GrabberError."""

    @abstractmethod
    def repeat(self, period: float) -> None:
        """Send one every `period` seconds from now on; with 0, no more. Any thread."""

    @property
    @abstractmethod
    def repeating(self) -> bool:
        """Whether triggers are sent again and again."""

    @abstractmethod
    def report(self) -> TriggerReport:
        """Return what is known by now. Reads settings, on the thread of the camera's calls."""

    @abstractmethod
    def close(self) -> None:
        """Send no more and put the camera's settings back, on the thread of its calls. Once."""


class CameraTrigger(LiveTrigger):
    """The trigger of a camera that is in no rig. While it is watched, the camera's events are on."""

    def __init__(self, grabber: FrameGrabber, triggers: Sequence[TriggerSetup]) -> None:
        """Watch the first of the triggers that are on, on the thread of the camera's calls."""
        setup = triggers[0]
        self._grabber = grabber
        self._setup = setup
        self._key = SettingKey("TriggerSoftware", setup.selected)
        self._settings = UndoableSettings()
        self._since = time.monotonic()
        self.sendable = setup.software and grabber.access is not Access.MONITOR
        entry = TriggerEntry(
            "software" if setup.source in ("", "Software") else "line",
            input=setup.source,
            activation=setup.activation,
        )
        self._watch = TriggerWatch(
            grabber,
            entry,
            self._settings,
            lambda _: None,
            selected=setup.selected,
            burst_frames=_burst_frames(grabber, setup),
            frame_start_waits=len(triggers) > 1,
        )
        self._repeater = Repeater(self.send, "send triggers")
        self._sink = FrameSink(grabber, self._note_frame, name="triggered frames", depth=16)
        self._sink.start()

    @override
    def send(self) -> None:
        moment = time.monotonic_ns()
        self._grabber.execute_setting(self._key)
        self._watch.note_sent(moment, acknowledged=True)

    @override
    def repeat(self, period: float) -> None:
        self._repeater.stop()
        if period > 0:
            self._repeater.start(period)

    @property
    @override
    def repeating(self) -> bool:
        return self._repeater.running

    @override
    def report(self) -> TriggerReport:
        counts = self._watch.counts()
        try:
            finding = self._watch.finding(max(RECENT, GAPS * self._watch.longest_gap()))
        except GrabberError:
            return TriggerReport(counts)
        early = finding.cause is TriggerCause.NO_SIGNAL and time.monotonic() - self._since < PATIENCE
        return TriggerReport(counts, {"": finding.sentence} if finding.sentence and not early else {})

    @override
    def close(self) -> None:
        self._repeater.stop()
        self._sink.stop()
        self._watch.close()
        self._settings.undo()

    def _note_frame(self, frame: Frame) -> None:
        self._watch.note_frame(frame)


class RigsTrigger(LiveTrigger):
    """The trigger of a rig, which the rig itself watches."""

    def __init__(self, rig: RigGrabber) -> None:
        self._rig = rig
        self.sendable = rig.entry.trigger.by in ("software", "action")
        self._lock = threading.Lock()

    @override
    def send(self) -> None:
        self._rig.send_trigger()

    @override
    def repeat(self, period: float) -> None:
        with self._lock:
            self._rig.repeat_trigger(period)

    @property
    @override
    def repeating(self) -> bool:
        return self._rig.repeats_trigger

    @override
    def report(self) -> TriggerReport:
        cameras = self._rig.trigger_counts().values()
        missed = [each.missed for each in cameras if each.missed is not None]
        counts = TriggerCounts(
            self._rig.triggers_sent if self.sendable else _least([each.sent for each in cameras]),
            min((each.accepted for each in cameras), default=0),
            max(missed, default=None),
        )
        try:
            findings = self._rig.trigger_findings()
        except GrabberError:
            return TriggerReport(counts)
        return TriggerReport(
            counts, {name: each.sentence for name, each in findings.items() if each.sentence}
        )

    @override
    def close(self) -> None:
        pass


def live_trigger(grabber: FrameGrabber, triggers: Sequence[TriggerSetup]) -> LiveTrigger:
    """Return the trigger of a source of which these are on. On the thread of its calls."""
    return RigsTrigger(grabber) if isinstance(grabber, RigGrabber) else CameraTrigger(grabber, triggers)


def _burst_frames(grabber: FrameGrabber, setup: TriggerSetup) -> int:
    """Return how many frames a trigger makes."""
    if setup.selector != "FrameBurstStart" or not grabber.has_feature("AcquisitionBurstFrameCount"):
        return 1
    try:
        value = grabber.feature("AcquisitionBurstFrameCount").value
    except GrabberError:
        return 1
    return value if isinstance(value, int) and value > 0 else 1


def _least(counts: Sequence[int | None]) -> int | None:
    known = [count for count in counts if count is not None]
    return min(known, default=None)
