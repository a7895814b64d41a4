"""Waiting for a set while cameras are lost or closed."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from grabbergui.core.errors import ClosedError, DeviceLostError, FrameTimeoutError
from grabbergui.core.frame_queue import FrameQueue, StreamStatistics
from grabbergui.library.sets import next_set


def camera(name: str, lost: str = "") -> Any:
    return SimpleNamespace(
        info=SimpleNamespace(title=name),
        grabber=SimpleNamespace(lost=lost),
        statistics=StreamStatistics(),
        why_no_frame=lambda: "",
    )


LOST, WELL = camera("left", "it did not answer"), camera("right")


def test_a_lost_camera_is_an_error_if_sets_need_it() -> None:
    with pytest.raises(DeviceLostError, match="left is lost: it did not answer"):
        next_set(FrameQueue(2), 5.0, {"left": LOST, "right": WELL})


def test_the_others_are_awaited_if_sets_may_lack_it() -> None:
    with pytest.raises(FrameTimeoutError, match=r"no set of frames was complete within 0\.05 s"):
        next_set(FrameQueue(2), 0.05, {"left": LOST, "right": WELL}, needs_all=False)
    with pytest.raises(DeviceLostError, match="left is lost"):
        next_set(FrameQueue(2), 5.0, {"left": LOST, "right": LOST}, needs_all=False)


def test_closed_cameras_make_no_set() -> None:
    queue = FrameQueue(2)
    queue.close()
    with pytest.raises(ClosedError):
        next_set(queue, 5.0, {"right": WELL})
