"""Waiting for the next set of frames of several cameras."""

from __future__ import annotations

import time
from collections.abc import Mapping

from grabbergui.core.errors import ClosedError, DeviceLostError, FrameTimeoutError
from grabbergui.core.frame_queue import FrameQueue
from grabbergui.library.camera import Camera
from grabbergui.rig.set_frame import SetFrame

LOOK = 0.1
"Seconds between looks whether a camera was lost or closed."


def next_set(
    queue: FrameQueue, timeout: float, cameras: Mapping[str, Camera], *, needs_all: bool = True
) -> SetFrame:
    """Return the next set. Raises FrameTimeoutError with the reason, ClosedError, DeviceLostError.

    A lost camera is an error at once if sets need all of them, otherwise only if all are lost.
    """
    deadline = time.monotonic() + timeout
    while True:
        left = max(0.0, deadline - time.monotonic())
        try:
            frame = queue.get(min(left, LOOK))
        except FrameTimeoutError as error:
            if queue.closed:
                raise ClosedError("the cameras were closed while frames were awaited") from error
            lost = [camera for camera in cameras.values() if camera.grabber.lost]
            if lost and (needs_all or len(lost) == len(cameras)):
                problem = f"{lost[0].info.title} is lost: {lost[0].grabber.lost}"
                raise DeviceLostError(problem) from error
            if left <= LOOK:
                raise FrameTimeoutError(_why(timeout, cameras)) from error
        else:
            assert isinstance(frame, SetFrame)
            return frame


def _why(timeout: float, cameras: Mapping[str, Camera]) -> str:
    for camera in cameras.values():
        if reason := camera.why_no_frame():
            return f"{camera.info.title}: no frame arrived within {timeout:.3g} s{reason}"
    rates = [f"{name}: {camera.statistics.frame_rate:.3g} frames/s" for name, camera in cameras.items()]
    return f"no set of frames was complete within {timeout:.3g} s ({', '.join(rates)})"
