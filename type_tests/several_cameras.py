"""Several cameras, and the search for them."""

from __future__ import annotations

from typing_extensions import assert_type

import grabbergui

Value = int | float | bool | str


def found() -> None:
    for info in grabbergui.discover(0.5):
        assert_type(info, grabbergui.DeviceInfo)
        assert_type(grabbergui.open(info, access="monitor"), grabbergui.Camera)
    grabbergui.open("sim:", access="write")  # type: ignore[arg-type]  # pyright: ignore


def group(cameras: grabbergui.CameraGroup) -> None:
    cameras.exposure_time = 5_000
    cameras["Gain"] = 3
    assert_type(cameras[0], grabbergui.Camera)
    assert_type(cameras[1:], grabbergui.CameraGroup)
    assert_type(cameras["Gain"], list[Value])
    assert_type(cameras.grab(Gain=3), list[grabbergui.Frame])
    assert_type(cameras.trigger_group(1), list[grabbergui.Frame])
    loop = cameras.frames(10, depth=2)
    for frames in loop:
        assert_type(frames, tuple[grabbergui.Frame, ...])
    assert_type(loop.dropped, tuple[int, ...])


def errors(camera: grabbergui.Camera) -> None:
    try:
        camera.grab()
    except TimeoutError as error:
        assert_type(error, TimeoutError)
    except grabbergui.FeatureError as error:
        assert_type(error.feature, str)
