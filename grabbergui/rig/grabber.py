"""A rig as a source: its frames are sets, its features those of its cameras."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import fields, replace
from functools import partial

from typing_extensions import override

from grabbergui.core.errors import UsageError
from grabbergui.core.features import AccessMode, Category, Feature, FeatureKind, FeatureValue
from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import StreamStatistics
from grabbergui.core.grabber import Access, ConnectionState, DeviceEvent, FrameGrabber
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.settings import SettingKey
from grabbergui.rig import camera_features
from grabbergui.rig.camera_clock import (
    CameraClock,
    ClockState,
    ClockWatch,
    network_clock,
    ptp_switch,
    with_conflicts,
)
from grabbergui.rig.camera_features import OWN, SEND
from grabbergui.rig.clock_fit import HostTime
from grabbergui.rig.followers import Followers
from grabbergui.rig.frame_sets import (
    FrameSet,
    FrameStamp,
    MatchByAction,
    MatchByCounter,
    MatchByTime,
    SetMatcher,
)
from grabbergui.rig.rig_file import RigEntry
from grabbergui.rig.set_frame import SetFrame
from grabbergui.rig.set_statistics import SetCounts
from grabbergui.rig.set_stream import SetStream, set_times
from grabbergui.rig.settings_undo import UndoableSettings
from grabbergui.rig.trigger_diagnosis import TriggerFinding
from grabbergui.rig.trigger_watch import TriggerCounts, TriggerWatch
from grabbergui.rig.triggering import RigTrigger

log = logging.getLogger(__name__)

GIGE_FRAME_IDS = 0xFFFF
"Frame ids of 16 bits go from 1 to this, and begin again."


class RigGrabber(FrameGrabber):
    """Several cameras as one source. Calls are as those of any grabber.

    Opening it opens every camera, and writes nothing; the first `start` writes the rig's settings and sets up
    PTP and the trigger; `close` puts back what was there.
    """

    def __init__(self, info: DeviceInfo, entry: RigEntry, cameras: Mapping[str, FrameGrabber]) -> None:
        """`cameras` by name, in the order of the rig; closed or already open."""
        super().__init__(info)
        self.entry = entry
        self.cameras = dict(cameras)
        self._access = Access.CONTROL
        self._clocks: dict[str, CameraClock] = {}
        self._watch: ClockWatch | None = None
        self._trigger: RigTrigger | None = None
        self._followers = Followers(entry.follow, self.cameras)
        self._sets: SetStream | None = None
        self._counts = SetCounts()
        self._settings = UndoableSettings()
        self._watches: dict[str, TriggerWatch] = {}
        self._leader_frame = 0
        "The id of the leading camera's last frame."
        self._tree: Category | None = None
        self._listening = False
        self._starting = threading.RLock()

    @override
    def open(self, access: Access = Access.CONTROL) -> None:
        self.connection_changed.emit(ConnectionState.OPENING, "")
        with ThreadPoolExecutor(len(self.cameras), "open camera") as pool:
            opening = [pool.submit(camera.open, access) for camera in self.cameras.values()]
        problems = [
            (name, error)
            for name, future in zip(self.cameras, opening, strict=True)
            if (error := future.exception()) is not None
        ]
        if problems:
            self._close_cameras()
            self.connection_changed.emit(ConnectionState.CLOSED, "")
            raise problems[0][1]
        self._access = access
        self._listen()
        self.connection_changed.emit(ConnectionState.OPEN, "")

    def _listen(self) -> None:
        """Pass on the cameras' signals. They are connected once."""
        if self._listening:
            return
        self._listening = True
        for name, camera in self.cameras.items():
            camera.features_changed.connect(partial(self._on_features_changed, name))
            camera.connection_changed.connect(partial(self._on_connection_changed, name))
            camera.noticed.connect(partial(self._on_noticed, name))
            camera.event_received.connect(partial(self._on_event, name))

    @override
    def close(self) -> None:
        self.stop()
        if self._trigger is not None:
            self._trigger.undo()
            self._trigger = None
        for watch in self._watches.values():
            watch.close()
        self._watches = {}
        for problem in self._settings.undo():
            log.info("%s", problem)
        self._close_cameras()
        self._fanout.close()
        self.connection_changed.emit(ConnectionState.CLOSED, "")

    def _close_cameras(self) -> None:
        with ThreadPoolExecutor(len(self.cameras), "close camera") as pool:
            list(pool.map(lambda camera: camera.close(), self.cameras.values()))

    @property
    @override
    def access(self) -> Access:
        return self._access

    @property
    @override
    def lost(self) -> str:
        lost = {name: camera.lost for name, camera in self.cameras.items() if camera.lost}
        return (
            "; ".join(f"{name}: {why}" for name, why in lost.items())
            if len(lost) == len(self.cameras)
            else ""
        )

    @override
    def feature_tree(self) -> Category:
        if self._tree is None:
            self._tree = camera_features.tree_of(self.cameras)
        return self._tree

    @override
    def has_feature(self, name: str) -> bool:
        if name in OWN:
            return name != SEND or self.entry.trigger.by in ("action", "software")
        found = camera_features.split(name, self.cameras)
        return found is not None and found[0].has_feature(found[1])

    @override
    def feature(self, name: str) -> Feature:
        if name in OWN:
            trigger = self._trigger
            values = camera_features.own_values(
                self.counts(),
                trigger.sent if trigger else 0,
                trigger.missed if trigger else 0,
                self.entry.trigger.title,
            )
            access = AccessMode.WRITE_ONLY if name == SEND else AccessMode.READ_ONLY
            unit = "us" if OWN[name].kind is FeatureKind.FLOAT else ""
            return Feature(**vars(OWN[name]), access=access, value=values.get(name), unit=unit)
        grabber, own = self._camera_of(name)
        return camera_features.named(name.partition(".")[0], grabber.feature(own))

    @override
    def write_feature(self, name: str, value: FeatureValue) -> Feature:
        if name in OWN:
            self.feature(name).validated(value)  # raises: none of them is writable
        grabber, own = self._camera_of(name)
        return camera_features.named(name.partition(".")[0], grabber.write_feature(own, value))

    @override
    def pauses_for(self, name: str) -> bool:
        found = camera_features.split(name, self.cameras)
        return found is not None and found[0].pauses_for(found[1])

    @override
    def execute(self, name: str) -> None:
        if name == SEND:
            self.send_trigger()
            return
        grabber, own = self._camera_of(name)
        grabber.execute(own)

    def _camera_of(self, name: str) -> tuple[FrameGrabber, str]:
        found = camera_features.split(name, self.cameras)
        if found is None:
            raise self._not_found(name)
        return found

    @override
    def start(self, *, keep_trigger: bool = False) -> None:
        """Start all cameras, then the trigger. Triggers of the cameras that are not the rig's are kept."""
        with self._starting:
            if self._sets is not None:
                return
            if self._access is Access.CONTROL:
                self._prepare()
            self._fanout.clear()
            self._leader_frame = 0
            self._sets = sets = SetStream(
                self.cameras, self._read_clocks(), self._matcher(), self._deliver, self._on_taken
            )
            sets.start()
            try:
                self._start_cameras(keep_trigger=keep_trigger or self.entry.trigger.by != "free")
                if self._trigger is not None:
                    self._trigger.start()
            except BaseException:
                self.stop()
                raise

    def _start_cameras(self, *, keep_trigger: bool) -> None:
        leader = self.entry.trigger.leader
        # The leader begins when the others already listen.
        order = sorted(self.cameras, key=lambda name: name == leader)
        with ThreadPoolExecutor(len(order), "start camera") as pool:
            others = [name for name in order if name != leader]
            calls = [pool.submit(self.cameras[name].start, keep_trigger=keep_trigger) for name in others]
            errors = [error for call in calls if (error := call.exception()) is not None]
        if errors:
            raise errors[0]
        if leader:
            self.cameras[leader].start(keep_trigger=False)

    def _prepare(self) -> None:
        """Write the rig's settings, switch PTP on, and set the trigger up, once."""
        if self._trigger is not None:
            return
        for name, camera in self.entry.cameras.items():
            for setting, value in camera.settings.items():
                self._settings.write(self.cameras[name], SettingKey.parse(setting), value)
        if self.entry.clock == "ptp" or (
            self.entry.clock == "auto" and all(map(ptp_switch, self.cameras.values()))
        ):
            for name, grabber in self.cameras.items():
                if (switch := ptp_switch(grabber)) is None:
                    raise UsageError(f"{name} ({grabber.info.title}) has no PTP; write `clock: fitted`")
                self._settings.write(grabber, SettingKey(switch), True)
        trigger = RigTrigger(
            self.entry.trigger, self.cameras, self._clocks_of_cameras(), self._expect, self._on_sent
        )
        try:
            trigger.prepare()
        except BaseException:
            trigger.undo()
            raise
        if self.entry.trigger.by != "free":
            leader = self.entry.trigger.leader
            self._watches = {
                name: TriggerWatch(
                    camera,
                    self.entry.trigger,
                    self._settings,
                    partial(self._host_time, name),
                    partial(self._host_time, leader) if leader else None,
                )
                for name, camera in self.cameras.items()
                if name != leader
            }
        self._trigger = trigger

    def _clocks_of_cameras(self) -> dict[str, CameraClock]:
        if not self._clocks:
            wanted = self.entry.clock
            self._clocks = {name: CameraClock(camera, wanted=wanted) for name, camera in self.cameras.items()}
        return self._clocks

    def _read_clocks(self) -> dict[str, CameraClock]:
        clocks = self._clocks_of_cameras()
        if self._watch is None:
            self._watch = ClockWatch(clocks, self._on_clocks_read)
            self._watch.start()
        return clocks

    def _on_clocks_read(self) -> None:
        if self._access is Access.CONTROL:
            self._followers.follow()
        self.features_changed.emit(frozenset(OWN))

    def _matcher(self) -> SetMatcher[Frame]:
        entry, names = self.entry, tuple(self.cameras)
        times = set_times(entry, self.cameras.values())
        delivered = entry.missing != "drop"
        match = entry.match
        if match == "auto":
            # Times of arrival are those of the exposures plus a delay that nobody knows.
            scheduled = entry.trigger.by == "action" and entry.clock != "host"
            match = "action" if scheduled else "time"
        if match == "action":
            return MatchByAction(names, times, deliver_incomplete=delivered)
        if match == "counter":
            return MatchByCounter(names, times, modulus=GIGE_FRAME_IDS, deliver_incomplete=delivered)
        return MatchByTime(names, times, deliver_incomplete=delivered)

    @override
    def stop(self) -> None:
        if self._trigger is not None:
            self._trigger.stop()
        with self._starting:
            sets, self._sets = self._sets, None
            if sets is None:
                return
            if self._watch is not None:
                self._watch.stop()
                self._watch = None
            with ThreadPoolExecutor(len(self.cameras), "stop camera") as pool:
                calls = [pool.submit(camera.stop) for camera in self.cameras.values()]
            sets.stop()
            self._counts = sets.counts()
            for call in calls:
                if (error := call.exception()) is not None:
                    log.info("stopping a camera of %s: %s", self.info.title, error)

    @property
    @override
    def streaming(self) -> bool:
        return self._sets is not None

    @override
    def statistics(self) -> StreamStatistics:
        """Return the sums over all cameras; the frame rate is that of the slowest."""
        all_of = [camera.statistics() for camera in self.cameras.values()]
        sums = {
            item.name: sum(getattr(each, item.name) for each in all_of) for item in fields(StreamStatistics)
        }
        sums["frame_rate"] = min((each.frame_rate for each in all_of), default=0.0)
        return StreamStatistics(**sums)

    def counts(self) -> SetCounts:
        """Return how the sets came out since the stream's start. Any thread."""
        sets = self._sets
        return sets.counts() if sets is not None else self._counts

    def recent_skews_ns(self) -> tuple[int, ...]:
        """Return the skews of the recent complete sets, oldest first."""
        sets = self._sets
        return sets.matcher.statistics.recent_skews_ns if sets is not None else ()

    def clock_states(self) -> dict[str, ClockState]:
        """Return what is known of each camera's clock; reads them if the stream is off."""
        clocks = self._clocks_of_cameras()
        if self._watch is None:
            ClockWatch(clocks, lambda: None).read()
        return with_conflicts({name: clock.state for name, clock in clocks.items()})

    def trigger_findings(self) -> dict[str, TriggerFinding]:
        """Return, by camera, what is wrong with its trigger. Reads settings; raises GrabberError."""
        return {name: watch.finding() for name, watch in self._watches.items()}

    def enable_event(self, name: str) -> list[str]:
        """Switch an event on until the rig is closed; return the cameras that have it."""
        key = SettingKey("EventNotification", (("EventSelector", name),))
        return [
            camera
            for camera, grabber in self.cameras.items()
            if self._settings.write_if_offered(grabber, key, "On")
        ]

    def send_trigger(self) -> None:
        """Trigger all cameras once. Raises UsageError without a trigger to send, GrabberError."""
        if self._trigger is None:
            raise UsageError("the rig is not started, so no trigger is set up")
        self._trigger.send()

    def trigger_counts(self) -> dict[str, TriggerCounts]:
        """Return the triggers of each camera that waits for them, since the rig's first start. Any thread."""
        return {name: watch.counts() for name, watch in self._watches.items()}

    @property
    def triggers_sent(self) -> int:
        """Triggers that the rig has sent."""
        return self._trigger.sent if self._trigger is not None else 0

    @property
    def repeats_trigger(self) -> bool:
        """Whether the rig sends triggers at a rate."""
        return self._trigger is not None and self._trigger.repeating

    def repeat_trigger(self, period: float) -> None:
        """Send a trigger every `period` seconds instead of at the file's rate; 0: only on request.

        Does nothing before the first start. Waits for a trigger that is being sent.
        """
        if self._trigger is not None and self._sets is not None:
            self._trigger.repeat(period)

    @property
    def leader(self) -> str:
        """The camera that the others follow now; empty if each has its own settings."""
        return self._followers.leader

    def lead(self, camera: str) -> None:
        """Let the others follow this camera from now on; empty: none. Raises UsageError for an unknown one.

        The rig's file, which may name another one, stays as it is.
        """
        if camera and camera not in self.cameras:
            raise UsageError(f"there is no camera {camera}; there are {', '.join(self.cameras)}")
        self._followers.leader = camera

    def _deliver(self, images: FrameSet[Frame]) -> None:
        if images:
            self._fanout.put(SetFrame.of(images))

    def _host_time(self, camera: str, device_ns: int) -> HostTime | None:
        estimate = network_clock(self._clocks.values()) or self._clocks[camera].estimate
        return None if estimate is None else estimate.host_time(device_ns)

    def _on_taken(self, camera: str, frame: Frame, stamp: FrameStamp) -> None:
        if camera == self.entry.trigger.leader:
            lost = max(0, frame.frame_id - self._leader_frame - 1) if self._leader_frame else 0
            self._leader_frame = frame.frame_id
            for other in self._watches.values() if frame.timestamp_ns else ():
                other.note_sent(frame.timestamp_ns, acknowledged=True, lost_before=lost)
        elif (watch := self._watches.get(camera)) is not None:
            watch.note_frame(frame)

    def _on_sent(self, camera: str, acknowledged: bool) -> None:
        if (watch := self._watches.get(camera)) is not None:
            watch.note_sent(time.monotonic_ns(), acknowledged=acknowledged)

    def _expect(self, moment_ns: int) -> None:
        if (sets := self._sets) is not None:
            sets.expect(moment_ns)

    def _on_features_changed(self, camera: str, names: frozenset[str]) -> None:
        self.features_changed.emit(frozenset(camera_features.prefixed(camera, name) for name in names))

    def _on_event(self, camera: str, event: DeviceEvent) -> None:
        """Pass on a camera's event under the rig's names: `left.ExposureEnd`."""
        self.event_received.emit(replace(event, name=camera_features.prefixed(camera, event.name)))

    def _on_noticed(self, camera: str, sentence: str) -> None:
        self.noticed.emit(f"{camera}: {sentence}")

    def _on_connection_changed(self, camera: str, state: ConnectionState, reason: str) -> None:
        if state not in (ConnectionState.LOST, ConnectionState.OPEN):
            return
        present = state is ConnectionState.OPEN
        if not present and (clock := self._clocks.get(camera)) is not None:
            clock.forget()
        if (sets := self._sets) is not None:
            sets.set_present(camera, present=present)
        if not present:
            self.noticed.emit(f"{camera} is lost: {reason}")
        if self.lost:
            self.connection_changed.emit(ConnectionState.LOST, self.lost)
        elif present:
            self.connection_changed.emit(ConnectionState.OPEN, reason)
