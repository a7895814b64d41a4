"""Exposes open GigE Vision cameras at the same time, by actions on request (GigE Vision 2.0, 14.3).

A rig's trigger, clocks and sets without its file: the cameras stay open, streaming, and as they are set.
"""

from __future__ import annotations

import queue
import time
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import replace
from typing import ClassVar

from grabbergui.core.errors import DeviceStatusError, FeatureError, FrameTimeoutError, UsageError
from grabbergui.core.frame import Frame
from grabbergui.core.frame_period import frame_wait
from grabbergui.core.grabber import FrameGrabber
from grabbergui.driver.gige.gvcp import Status
from grabbergui.rig import rig_file
from grabbergui.rig.camera_clock import CameraClock, ClockWatch, ptp_switch
from grabbergui.rig.frame_sets import FrameSet, MatchByAction
from grabbergui.rig.rig_file import TriggerEntry
from grabbergui.rig.set_stream import SetStream, set_times
from grabbergui.rig.triggering import RigTrigger

PTP_WAIT = 15.0
"""Seconds that clocks may take to find their master."""
LARGEST_KEY = 0xFFFFFFFF
GIVEN_UP = 5.0
"Seconds by which a busy computer may be late to give up a set."


class ActionGroup:
    """Open cameras that expose a set at each action with their keys. One thread at a time."""

    WITHOUT_PTP: ClassVar[str] = "ptp=False"
    MORE_AHEAD: ClassVar[str] = "ahead="
    "How a user writes these in what calls this."

    def __init__(
        self,
        cameras: Sequence[FrameGrabber],
        keys: TriggerEntry,
        *,
        ptp: bool = True,
        timeout: float | None = None,
    ) -> None:
        """Check the cameras and keys. With `ptp`, actions are scheduled by the cameras' common clock.

        `timeout` is how long frames are awaited in seconds, by default as usual. Raises UsageError.
        """
        for camera in cameras:
            if not camera.info.bus.startswith("GigE"):
                raise UsageError(f"{camera.info.uri} is not a GigE Vision camera, so it has no actions")
        for name in ("group_key", "device_key", "group_mask"):
            if not 0 <= (key := getattr(keys, name)) <= LARGEST_KEY:
                raise UsageError(f"{name}={key}: write a number from 0 to 0x{LARGEST_KEY:X}")
        self._keys = replace(keys, by="action", rate=0.0)
        self._cameras = {f"camera{number}": camera for number, camera in enumerate(cameras, 1)}
        self._ptp = ptp
        self._timeout = max(map(frame_wait, cameras), default=0.0) if timeout is None else timeout
        self._clocks = {
            name: CameraClock(camera, wanted="ptp" if ptp else "fitted")
            for name, camera in self._cameras.items()
        }
        self._sets: queue.SimpleQueue[FrameSet[Frame]] = queue.SimpleQueue()
        self._stack = ExitStack()
        self._trigger: RigTrigger | None = None

    def start(self) -> None:
        """Set the cameras to expose one frame for each action, wait for their clocks, and stream.

        Raises FeatureError, TransportError.
        """
        if self._ptp:
            for camera in self._cameras.values():
                self._switch_ptp_on(camera)
        names = tuple(self._cameras)
        entry = rig_file.of_sources({name: each.info.uri for name, each in self._cameras.items()})
        times = set_times(replace(entry, wait=self._timeout, trigger=self._keys), self._cameras.values())
        sets = SetStream(self._cameras, self._clocks, MatchByAction(names, times), self._sets.put)
        self._trigger = trigger = RigTrigger(self._keys, self._cameras, self._clocks, sets.expect)
        trigger.prepare()
        watch = ClockWatch(self._clocks, lambda: None)
        self._stack.callback(watch.stop)
        watch.start()
        self._await_clocks()
        self._stack.callback(sets.stop)
        sets.start()
        for camera in self._cameras.values():
            camera.start(keep_trigger=True)

    def close(self) -> None:
        """Receive no more frames. The cameras stay as they are set."""
        self._stack.close()

    def fire(self) -> FrameSet[Frame]:
        """Send one action; return the frames that it made.

        Raises DeviceStatusError if the action came too late, AckTimeoutError, FrameTimeoutError.
        """
        assert self._trigger is not None, "start it first"
        while not self._sets.empty():  # of an action that failed
            self._sets.get()
        try:
            self._trigger.send()
        except DeviceStatusError as error:
            if error.status == Status.ACTION_LATE:
                raise DeviceStatusError(
                    "the action reached a camera too late; use more than"
                    f" {self.MORE_AHEAD}{self._keys.ahead:g}",
                    error.status,
                ) from error
            raise
        try:  # a set that is given up comes, too
            images = self._sets.get(timeout=self._keys.ahead + 2 * self._timeout + GIVEN_UP)
        except queue.Empty:
            raise FrameTimeoutError("the cameras were closed while frames were awaited") from None
        for name in images.missing:
            info = self._cameras[name].info
            raise FrameTimeoutError(
                f"{info.title} ({info.uri}): no frame arrived within {self._timeout:.3g} s of the action"
            )
        return images

    def _switch_ptp_on(self, camera: FrameGrabber) -> None:
        if (switch := ptp_switch(camera)) is None:
            raise FeatureError(
                f"{camera.info.title} has no PtpEnable, so nothing can be scheduled; use {self.WITHOUT_PTP}",
                "PtpEnable",
            )
        camera.write_feature(switch, True)

    def _await_clocks(self) -> None:
        deadline = time.monotonic() + PTP_WAIT
        for name, clock in self._clocks.items():
            while self._ptp and not clock.follows_ptp:
                if time.monotonic() > deadline:
                    raise FeatureError(
                        f"{self._cameras[name].info.title}: PtpStatus is {clock.state.ptp_status} after"
                        f" {PTP_WAIT:g} s; is there a PTP master in the network? {self.WITHOUT_PTP} triggers"
                        " without one",
                        "PtpStatus",
                    )
                time.sleep(0.1)
                clock.read()
