"""The trigger of a rig: sets the cameras up for it, sends it, and says when frames are due.

`action` sends one message to all GigE Vision cameras: with PTP it names the moment of the exposure, otherwise
it counts on arrival. `software` writes TriggerSoftware to each camera. With `line`, one camera's output or a
signal from elsewhere triggers the others.
"""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor

from grabbergui.core.errors import AckTimeoutError, FeatureError, GrabberError, UsageError
from grabbergui.core.features import FeatureValue
from grabbergui.core.grabber import FrameGrabber
from grabbergui.core.settings import SettingKey
from grabbergui.rig.camera_clock import CameraClock, network_clock
from grabbergui.rig.repeating import Repeater
from grabbergui.rig.rig_file import TriggerEntry
from grabbergui.rig.settings_undo import UndoableSettings

log = logging.getLogger(__name__)

MOST_AHEAD = 0.8
"Part of the period of the triggers by which an action is scheduled ahead at most."
FRAME_START = (("TriggerSelector", "FrameStart"),)
"The selector's entry for the trigger of each frame."


class RigTrigger:
    """Sends the triggers of a rig. `send` may be called from any thread."""

    def __init__(
        self,
        entry: TriggerEntry,
        grabbers: Mapping[str, FrameGrabber],
        clocks: Mapping[str, CameraClock],
        expected: Callable[[int], object] = lambda moment_ns: None,
        sent: Callable[[str, bool], object] = lambda camera, acknowledged: None,
    ) -> None:
        """`expected` is called with the moment of each trigger on the host's monotonic clock, in ns.

        `sent` is called for each camera afterwards, with whether it acknowledged.
        """
        self.entry = entry
        self.sent = 0
        self.missed = 0
        "Triggers that a camera did not acknowledge or refused."
        self._grabbers = dict(grabbers)
        self._clocks = dict(clocks)
        self._expected = expected
        self._note_sent = sent
        self._settings = UndoableSettings()
        self._lock = threading.Lock()
        self._pool: ThreadPoolExecutor | None = None
        self._repeater = Repeater(self.send, "rig trigger")

    def prepare(self) -> None:
        """Set every camera up. Raises UsageError for cameras that cannot be triggered so, GrabberError."""
        setups = {"action": self._await_actions, "software": self._await_software, "line": self._await_line}
        if (set_up := setups.get(self.entry.by)) is None:
            return
        for name, grabber in self._grabbers.items():
            set_up(name, grabber)
        self._align()

    def start(self) -> None:
        """Send triggers at the rig's rate, if it has one, until `stop`."""
        if self.sendable and self.entry.rate > 0:
            self._repeater.start(1 / self.entry.rate)

    def stop(self) -> None:
        """Send no more triggers by itself."""
        self._repeater.stop()

    @property
    def sendable(self) -> bool:
        """Whether the rig sends its triggers itself."""
        return self.entry.by in ("action", "software")

    @property
    def repeating(self) -> bool:
        """Whether triggers are sent at a rate."""
        return self._repeater.running

    def repeat(self, period: float) -> None:
        """Send a trigger every `period` seconds instead of at the rig's rate; 0: only on request."""
        self._repeater.stop()
        if period > 0:
            self._repeater.start(period)

    def undo(self) -> None:
        """Give the cameras their settings from before `prepare`."""
        for problem in self._settings.undo():
            log.warning("%s", problem)
        if self._pool is not None:
            self._pool.shutdown(wait=False)

    def send(self) -> None:
        """Send one trigger to all cameras. Raises UsageError if the rig has none to send, GrabberError."""
        if not self.sendable:
            raise UsageError(
                f"the rig's trigger is {self.entry.by}, so none can be sent; write `by: action` or"
                " `by: software` below trigger"
            )
        with self._lock:
            self.sent += 1
            try:
                self._send_action() if self.entry.by == "action" else self._send_software()
            except GrabberError:
                self.missed += 1
                raise

    def _send_action(self) -> None:
        from grabbergui.driver.gige.address_commands import send_action
        from grabbergui.driver.gige.gvcp_messages import Action

        entry = self.entry
        estimate = network_clock(self._clocks.values())
        # Many cameras keep one scheduled action only.
        ahead = min(entry.ahead, MOST_AHEAD / entry.rate) if entry.rate else entry.ahead
        moment = time.monotonic_ns() + (round(ahead * 1e9) if estimate is not None else 0)
        at = estimate.device_time(moment) if estimate is not None else None
        self._expected(moment)
        present = {name: each.info.address for name, each in self._grabbers.items() if not each.lost}
        silent: frozenset[str] = frozenset()
        try:
            send_action(Action(entry.device_key, entry.group_key, entry.group_mask, at), present.values())
        except AckTimeoutError as error:
            silent = error.addresses
            raise
        finally:
            for name, address in present.items():
                self._note_sent(name, address not in silent)

    def _send_software(self) -> None:
        if self._pool is None:
            self._pool = ThreadPoolExecutor(len(self._grabbers), "rig trigger")
        self._expected(time.monotonic_ns())
        calls = {
            name: self._pool.submit(grabber.execute_setting, _key(grabber, "TriggerSoftware"))
            for name, grabber in self._grabbers.items()
            if not grabber.lost
        }
        errors = [error for call in calls.values() if (error := call.exception()) is not None]
        for name, call in calls.items():
            self._note_sent(name, call.exception() is None)
        if errors:
            raise errors[0]

    def _await_actions(self, name: str, grabber: FrameGrabber) -> None:
        if not grabber.info.bus.startswith("GigE"):
            raise UsageError(
                f"{name} ({grabber.info.uri}) is not a GigE Vision camera, so it has no actions;"
                " write `by: software` below trigger"
            )
        entry = self.entry
        for feature, value in (
            ("ActionDeviceKey", entry.device_key),
            ("ActionGroupKey", entry.group_key),
            ("ActionGroupMask", entry.group_mask),
        ):
            if grabber.feature(feature).access.readable:
                self._settings.write(grabber, SettingKey(feature), value)
            else:  # a key that can only be written
                grabber.write_feature(feature, value)
        self._switch_on(grabber, "Action1")

    def _await_software(self, name: str, grabber: FrameGrabber) -> None:
        self._switch_on(grabber, "Software")

    def _await_line(self, name: str, grabber: FrameGrabber) -> None:
        entry = self.entry
        if name == entry.leader:
            self._lead(grabber)
            return
        line = (("LineSelector", entry.input),)
        self._settings.write_if_offered(grabber, SettingKey("LineMode", line), "Input")
        self._settings.write_if_offered(grabber, SettingKey("LineInverter", line), entry.inverted)
        self._switch_on(grabber, entry.input)
        key = _key(grabber, "TriggerActivation")
        if not self._settings.write_if_offered(grabber, key, entry.activation):
            log.info("%s: TriggerActivation stays as it is", grabber.info.title)

    def _lead(self, grabber: FrameGrabber) -> None:
        """Let a camera run free and show its exposures on its output."""
        line = (("LineSelector", self.entry.output),)
        self._settings.write_if_offered(grabber, SettingKey("LineMode", line), "Output")
        if not self._settings.write_if_offered(grabber, SettingKey("LineSource", line), "ExposureActive"):
            raise FeatureError(
                f"{grabber.info.title}: {self.entry.output} cannot carry ExposureActive; choose another"
                " trigger.output or trigger.leader",
                "LineSource",
            )
        self._settings.write_if_offered(grabber, _key(grabber, "TriggerMode"), "Off")
        if self.entry.rate:
            self._settings.write_if_offered(grabber, SettingKey("AcquisitionFrameRate"), self.entry.rate)

    def _switch_on(self, grabber: FrameGrabber, source: FeatureValue) -> None:
        self._settings.write(grabber, _key(grabber, "TriggerSource"), source)
        self._settings.write(grabber, _key(grabber, "TriggerMode"), "On")

    def _align(self) -> None:
        """Delay the shorter exposures, so that their middles or ends coincide."""
        part = {"start": 0.0, "middle": 0.5, "end": 1.0}[self.entry.align]
        exposures = {name: _exposure_us(grabber) for name, grabber in self._grabbers.items()}
        longest = max(exposures.values(), default=0.0)
        for name, grabber in self._grabbers.items():
            delay = part * (longest - exposures[name])
            key = _key(grabber, "TriggerDelay")
            offered = self._settings.write_if_offered(grabber, key, delay)
            if part and not offered and delay:
                raise FeatureError(
                    f"{name} has no TriggerDelay, so its {self.entry.align} cannot be aligned",
                    "TriggerDelay",
                )


def _key(grabber: FrameGrabber, name: str) -> SettingKey:
    """Return the setting of the trigger for frames; cameras with one trigger have no selector."""
    return SettingKey(name, FRAME_START if grabber.has_feature("TriggerSelector") else ())


def _exposure_us(grabber: FrameGrabber) -> float:
    value = grabber.feature("ExposureTime").value if grabber.has_feature("ExposureTime") else 0.0
    return float(value) if isinstance(value, int | float) else 0.0
