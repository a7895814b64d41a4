"""One camera: settings, frames, callbacks, files."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from typing_extensions import assert_type

import grabbergui

Value = int | float | bool | str


def settings(camera: grabbergui.Camera) -> None:
    camera.exposure_time = 5_000
    camera.exposure_time = "5ms"
    camera.exposure_time = np.float32(5_000)
    camera.width = np.int64(640)
    camera["ExposureTime"] = np.uint8(100)
    camera["TriggerMode"] = "On"
    camera.device_user_id = "left"
    assert_type(camera.exposure_time, float)
    assert_type(camera.pixel_format, str)
    assert_type(camera.width, int)
    assert_type(camera["Gain"], Value)
    assert_type(camera.write("Gain", np.float64(3)), Value)
    assert_type(camera.feature("Gain"), grabbergui.Feature)
    assert_type("Gain" in camera, bool)
    assert_type(camera.state, Literal["open", "streaming", "lost", "closed"])
    assert_type(camera.load_settings(Path("a.yaml")), grabbergui.LoadReport)


def frames(camera: grabbergui.Camera) -> None:
    frame = camera.grab(ExposureTime=5_000, Gain=np.float32(3))
    assert_type(frame, grabbergui.Frame)
    assert_type(frame.rgb(), NDArray[np.uint8])
    assert_type(frame.bgr(), NDArray[np.uint8])
    assert_type(frame.raw(), NDArray[Any])
    assert_type(np.asarray(frame), NDArray[Any])
    assert_type(camera.bracket(ExposureTime=[1_000, 2_000.0]), list[grabbergui.Frame])
    loop = camera.frames(100, depth=16)
    for each in loop:
        assert_type(each, grabbergui.Frame)
        assert_type(each.components[0].kind, grabbergui.ComponentKind)
    assert_type(loop.dropped, int)
    with loop.started() as waiting:
        assert_type(next(waiting), grabbergui.Frame)
    with camera.record("run.mcap", seconds=5) as recording:
        assert_type(recording.progress, grabbergui.RecordingProgress)


async def asynchronous(camera: grabbergui.Camera) -> None:
    assert_type(await camera.agrab(Gain=3), grabbergui.Frame)
    async for frame in camera.aframes(10):
        assert_type(frame, grabbergui.Frame)


def on_changes(names: frozenset[str]) -> None:
    """Take the names of features that changed."""


def on_event(event: grabbergui.DeviceEvent) -> None:
    """Take an event."""


def callbacks(camera: grabbergui.Camera) -> None:
    assert_type(camera.on("change", on_changes), Callable[[], None])
    camera.on("event", on_event)
    camera.on("lost", print)
    camera.on("lost", on_event)  # type: ignore[call-overload]  # pyright: ignore
    camera.on("loss", print)  # type: ignore[call-overload]  # pyright: ignore


def files(camera: grabbergui.Camera) -> None:
    assert_type(camera.files.list(), tuple[grabbergui.CameraFile, ...])
    assert_type(camera.files.read("UserFile"), bytes)
    assert_type(camera.files.write("UserFile", b"").verified, bool)
