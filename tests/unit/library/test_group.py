"""Several cameras as one: settings, frames, triggers."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NoReturn

import pytest

import grabbergui

FAST = "sim:?width=64&height=48&fps=200&exposure=1000"


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


def test_a_name_is_in_a_group_if_all_cameras_have_it(cameras: grabbergui.CameraGroup) -> None:
    assert "exposure_time" in cameras and "ExposureTime" in cameras and "exposure_tme" not in cameras
    assert cameras[1] in cameras and cameras[1] not in cameras[:1]


@pytest.mark.parametrize("name", ["exposure_tme", "_exposure_time", "start"])
def test_what_sets_no_camera_is_refused(cameras: grabbergui.CameraGroup, name: str) -> None:
    with pytest.raises(AttributeError):
        setattr(cameras, name, 5000)


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


def test_a_loop_over_a_group_that_is_left_stops_all_streams(cameras: grabbergui.CameraGroup) -> None:
    for _ in cameras.frames():
        break
    assert not any(camera.streaming for camera in cameras)


def test_a_software_trigger_and_repr(cameras: grabbergui.CameraGroup) -> None:
    assert [frame.width for frame in cameras.trigger()] == [64, 64]
    assert "serial=LEFT" in repr(cameras) and len(cameras) == 2


def test_no_cameras_are_no_group() -> None:
    with pytest.raises(grabbergui.UsageError, match="name at least one source"):
        grabbergui.open_all([])
