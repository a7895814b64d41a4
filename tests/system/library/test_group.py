"""Several cameras as one: settings, frames, triggers."""

from __future__ import annotations

import itertools
import threading
import time
from collections.abc import Iterator
from typing import NoReturn

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


def test_an_assignment_sets_all_cameras(cameras: grabbergui.CameraGroup) -> None:
    cameras.exposure_time = 2000
    assert cameras.exposure_time == cameras["ExposureTime"] == [2000.0, 2000.0]
    cameras["Gain"] = 3
    assert [camera.gain for camera in cameras] == [3.0, 3.0] == cameras.read("gain")
    cameras.trigger_mode = "On"
    cameras.execute("timestamp_latch")
    assert cameras[1:].trigger_mode == ["On"]


@pytest.mark.parametrize("name", ["exposure_tme", "_exposure_time", "start"])
def test_what_sets_no_camera_is_refused(cameras: grabbergui.CameraGroup, name: str) -> None:
    with pytest.raises(AttributeError):
        setattr(cameras, name, 5000)


def test_a_method_that_a_group_lacks_is_refused(cameras: grabbergui.CameraGroup) -> None:
    with pytest.raises(AttributeError, match=r"no method bracket; call that of each camera: \[camera\.brack"):
        cameras.bracket(ExposureTime=[1000])


def raise_(error: Exception) -> NoReturn:
    raise error


def test_if_one_camera_refuses_the_others_keep_their_value(
    cameras: grabbergui.CameraGroup, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = cameras.exposure_time
    refused = grabbergui.FeatureAccessError("Gain cannot be used", "Gain")
    monkeypatch.setattr(cameras[1].grabber, "write_setting", lambda key, value: raise_(refused))
    with pytest.raises(grabbergui.FeatureAccessError, match="RIGHT: Gain cannot be used"):
        cameras.exposure_time = 3000
    monkeypatch.undo()
    assert cameras.exposure_time == before
    with pytest.raises(grabbergui.FeatureNotFoundError):
        cameras["NoSuch"] = 1


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


def test_a_loop_over_a_group_that_is_left_stops_all_streams(cameras: grabbergui.CameraGroup) -> None:
    for _ in cameras.frames():
        break
    assert not any(camera.streaming for camera in cameras)


def test_a_software_trigger_and_repr(cameras: grabbergui.CameraGroup) -> None:
    assert [frame.width for frame in cameras.trigger()] == [64, 64]
    assert "serial=LEFT" in repr(cameras) and len(cameras) == 2


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


def test_no_cameras_are_no_group() -> None:
    with pytest.raises(grabbergui.UsageError, match="name at least one source"):
        grabbergui.open_all([])


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
