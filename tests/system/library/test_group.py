"""Several cameras as one: settings, frames, triggers."""

from __future__ import annotations

import itertools
import threading
import time
from collections.abc import Iterator

import pytest

import grabbergui
from grabbergui.driver.sim.gige.server import GigeCamera
from patience import PATIENCE

FAST = "sim:?width=64&height=48&fps=200&exposure=1000"
ADDRESSES = ("127.20.1.21", "127.20.1.22")


@pytest.fixture
def cameras() -> Iterator[grabbergui.CameraGroup]:
    with grabbergui.open_all([f"{FAST}&serial=LEFT", f"{FAST}&serial=RIGHT"]) as cameras:
        yield cameras


def test_a_method_that_a_group_lacks_is_refused(cameras: grabbergui.CameraGroup) -> None:
    with pytest.raises(AttributeError, match=r"no method bracket; call that of each camera: \[camera\.brack"):
        cameras.bracket(ExposureTime=[1000])


def test_the_frames_of_a_group_have_a_depth_and_count_what_was_dropped(
    cameras: grabbergui.CameraGroup,
) -> None:
    frames = cameras.frames(5, depth=1)
    assert frames.dropped == (0, 0)
    for left, right in frames:
        assert (left.width, right.width) == (64, 64)
        time.sleep(0.03)
    assert min(frames.dropped) > 0
    assert not any(camera.streaming for camera in cameras)


def test_an_action_exposes_gige_vision_cameras_together(cameras: grabbergui.CameraGroup) -> None:
    with pytest.raises(grabbergui.UsageError, match="not a GigE Vision camera"):
        cameras.trigger_group()
    simulated = [GigeCamera(address) for address in ADDRESSES]
    try:
        with grabbergui.open_all([f"gige:{address}" for address in ADDRESSES]) as both:
            both.exposure_time = 1000
            for _ in range(2):
                frames = both.trigger_group(7, ahead=0.1)
                stamps = [frame.timestamp_ns for frame in frames]
                assert len(frames) == 2 and max(stamps) - min(stamps) < 50_000_000
            with pytest.raises(grabbergui.UsageError, match="group_key=-1"):
                both.trigger_group(-1)
    finally:
        for each in simulated:
            each.close()


def test_a_frame_that_one_camera_loses_shifts_no_later_pair(cameras: grabbergui.CameraGroup) -> None:
    for camera in cameras:
        camera["TriggerMode"] = "On"
    done = threading.Event()

    def fire() -> None:
        for number in itertools.count():  # a busy computer may send two triggers too far apart for a pair
            for camera in cameras[:1] if number == 2 else cameras:
                camera.execute("TriggerSoftware")
            if done.wait(0.05):
                return

    loop = iter(cameras.frames(4, timeout=PATIENCE))
    firing = threading.Thread(target=fire)
    firing.start()
    try:
        pairs = [(left.frame_id, right.frame_id) for left, right in loop]
    finally:
        done.set()
        firing.join()
    assert all(right == left - (left > 2) for left, right in pairs) and pairs[-1][0] >= 5
