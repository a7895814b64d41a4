"""Exposes several GigE Vision cameras at the same time, by action commands (GigE Vision 2.0, 14.3)."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import ClassVar

from grabbergui.core.errors import DeviceStatusError, FeatureError, FrameTimeoutError, UsageError
from grabbergui.core.feature_source import FeatureSource
from grabbergui.core.features import FeatureValue
from grabbergui.core.frame import Frame
from grabbergui.core.frame_period import frame_wait
from grabbergui.core.frame_queue import FrameQueue
from grabbergui.core.grabber import FrameGrabber
from grabbergui.driver.gige.address_commands import send_action
from grabbergui.driver.gige.gvcp import Status
from grabbergui.driver.gige.gvcp_messages import Action

PTP_WAIT = 15.0
"""Seconds that clocks may take to find their master."""
PTP_SETTLED = ("Slave", "Master")
LARGEST_KEY = 0xFFFFFFFF
AHEAD = 0.2
"Seconds from sending an action to its time."


class ActionGroup:
    """Open cameras that expose a frame at each action with their keys. One thread at a time."""

    WITHOUT_PTP: ClassVar[str] = "ptp=False"
    MORE_AHEAD: ClassVar[str] = "ahead="
    "How a user writes these in what calls this."

    def __init__(
        self,
        cameras: Sequence[FrameGrabber],
        group_key: int,
        *,
        device_key: int = 1,
        group_mask: int = 1,
        ptp: bool = True,
    ) -> None:
        """Check the cameras and keys. With `ptp`, actions are scheduled by the cameras' common clock.

        Raises UsageError.
        """
        for camera in cameras:
            if not camera.info.bus.startswith("GigE"):
                raise UsageError(f"{camera.info.uri} is not a GigE Vision camera, so it has no actions")
        for name, key in {"group_key": group_key, "device_key": device_key, "group_mask": group_mask}.items():
            if not 0 <= key <= LARGEST_KEY:
                raise UsageError(f"{name}={key}: write a number from 0 to 0x{LARGEST_KEY:X}")
        self._cameras = cameras
        self._ptp = ptp
        self._group_key = group_key
        self._device_key = device_key
        self._group_mask = group_mask
        self._queues: list[FrameQueue] = []

    def start(self) -> None:
        """Set the cameras to expose one frame for each action, wait for their clocks, and stream.

        Raises FeatureError, TransportError.
        """
        for camera in self._cameras:
            self._prepare(camera)
        if self._ptp:
            self._await_clocks()
        self._queues = [camera.open_queue(4) for camera in self._cameras]
        for camera in self._cameras:
            camera.start(keep_trigger=True)

    def close(self) -> None:
        """Receive no more frames. The cameras stay as they are set."""
        for queue in self._queues:
            queue.close()

    def fire(self, ahead: float = AHEAD, timeout: float | None = None) -> list[Frame]:
        """Send one action, `ahead` seconds before its time; return a frame of each camera, in their order.

        `timeout` is in seconds, by default that of a frame. Raises DeviceStatusError if the action came too
        late, AckTimeoutError, FrameTimeoutError.
        """
        at = self._now() + int(ahead * 1e9) if self._ptp else None
        action = Action(self._device_key, self._group_key, self._group_mask, at)
        try:
            send_action(action, {camera.info.address for camera in self._cameras})
        except DeviceStatusError as error:
            if error.status == Status.ACTION_LATE:
                raise DeviceStatusError(
                    f"the action reached a camera too late; use more than {self.MORE_AHEAD}{ahead:g}",
                    error.status,
                ) from error
            raise
        return [_frame_of(*pair, timeout) for pair in zip(self._cameras, self._queues, strict=True)]

    def spread_ns(self, frames: Sequence[Frame]) -> int:
        """Return the nanoseconds between the earliest and the latest frame, by PTP or the host's clock."""
        times = [frame.timestamp_ns if self._ptp else frame.received_ns for frame in frames]
        return max(times) - min(times)

    def _prepare(self, camera: FrameGrabber) -> None:
        if self._ptp:
            if not camera.has_feature("PtpEnable"):
                raise FeatureError(
                    f"{camera.info.title} has no PtpEnable, so nothing can be scheduled;"
                    f" use {self.WITHOUT_PTP}",
                    "PtpEnable",
                )
            camera.write_feature("PtpEnable", True)
        settings: dict[str, FeatureValue] = {
            "ActionDeviceKey": self._device_key,
            "ActionGroupKey": self._group_key,
            "ActionGroupMask": self._group_mask,
            "TriggerSelector": "FrameStart",
            "TriggerMode": "On",
            "TriggerSource": "Action1",
        }
        for name, value in settings.items():
            camera.write_feature(name, value)

    def _await_clocks(self) -> None:
        deadline = time.monotonic() + PTP_WAIT
        for camera in self._cameras:
            while camera.has_feature("PtpStatus"):
                if camera.has_feature("PtpDataSetLatch"):
                    camera.execute("PtpDataSetLatch")
                status = camera.feature("PtpStatus").value
                if status in PTP_SETTLED:
                    break
                if time.monotonic() > deadline:
                    raise FeatureError(
                        f"{camera.info.title}: PtpStatus is {status} after {PTP_WAIT:g} s; is there a PTP"
                        f" master in the network? {self.WITHOUT_PTP} triggers without one",
                        "PtpStatus",
                    )
                time.sleep(0.1)

    def _now(self) -> int:
        """Return the cameras' time in nanoseconds."""
        camera = self._cameras[0]
        camera.execute("TimestampLatch")
        now = camera.feature("TimestampLatchValue").value
        if not isinstance(now, int):
            raise FeatureError(f"{camera.info.title} does not report its time", "TimestampLatchValue")
        return now


def _frame_of(camera: FeatureSource, queue: FrameQueue, timeout: float | None) -> Frame:
    try:
        return queue.get(frame_wait(camera) if timeout is None else timeout)
    except FrameTimeoutError as error:
        raise FrameTimeoutError(f"{camera.info.title} ({camera.info.uri}): {error} of the action") from error
