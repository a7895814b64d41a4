"""`import grabbergui` as a program uses it, on the simulated camera and over the networks."""

from __future__ import annotations

import asyncio
import contextlib
import inspect
import math
import pickle
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import grabbergui
from grabbergui.core.errors import FeatureAccessError, UsageError
from grabbergui.library.features import attribute_name
from patience import PATIENCE, until

FAST = "sim:?width=64&height=48&fps=200&exposure=1000"


def test_every_public_name_is_there_and_documented() -> None:
    for name in grabbergui.__all__:
        value = getattr(grabbergui, name)
        if name != "__version__":
            assert inspect.getdoc(value), name
            for member, method in vars(value).items() if inspect.isclass(value) else ():
                if inspect.isfunction(method) and not member.startswith("_"):
                    assert inspect.getdoc(getattr(value, member)), f"{name}.{member}"
    assert set(dir(grabbergui)) == set(grabbergui.__all__)


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="opne"):
        _ = grabbergui.opne


@pytest.mark.parametrize(
    ("feature", "attribute"),
    [
        ("ExposureTime", "exposure_time"),
        ("GevSCPSPacketSize", "gev_scps_packet_size"),
        ("OffsetX", "offset_x"),
        ("LUTEnable", "lut_enable"),
        ("DeviceID", "device_id"),
        ("Gain", "gain"),
        ("exposure_time", "exposure_time"),
    ],
)
def test_names_in_pythons_spelling(feature: str, attribute: str) -> None:
    assert attribute_name(feature) == attribute


def test_features_are_attributes_and_items(camera: grabbergui.Camera) -> None:
    camera.exposure_time = 2000
    assert camera.exposure_time == camera["ExposureTime"] == camera.read("ExposureTime") == 2000.0
    camera["Gain"] = 3
    assert camera.gain == 3.0
    camera.device_user_id = "left"
    assert camera["DeviceUserID"] == "left"
    assert "ExposureTime" in camera and "NoSuch" not in camera


def test_values_may_be_text_with_a_unit_and_numpy_numbers(camera: grabbergui.Camera) -> None:
    camera["ExposureTime"] = "2ms"
    assert camera.exposure_time == 2000.0
    camera.exposure_time = np.float32(1500)
    assert camera.exposure_time == 1500.0
    assert camera.write("ExposureTime", np.int64(1234)) == 1234.0


def test_a_setting_behind_a_selector(camera: grabbergui.Camera) -> None:
    camera["TriggerDelay[TriggerSelector=FrameBurstStart]"] = 500
    assert camera["TriggerDelay[TriggerSelector=FrameBurstStart]"] == 500.0
    assert camera["TriggerSelector"] == "FrameStart"


def test_completion_knows_the_features(camera: grabbergui.Camera) -> None:
    assert {"exposure_time", "device_serial_number", "grab"} <= set(dir(camera))
    assert "ExposureTime" in camera._ipython_key_completions_()


def test_what_is_misspelled_is_named_with_what_was_meant(camera: grabbergui.Camera) -> None:
    with pytest.raises(AttributeError, match="did you mean ExposureTime"):
        _ = camera.exposure_tim
    with pytest.raises(AttributeError, match="did you mean ExposureTime"):
        camera.exposure_tim = 5
    with pytest.raises(AttributeError, match="did you mean ExposureTime"):
        _ = camera.exposure_time_
    assert not hasattr(camera, "exposure__time")
    with pytest.raises(grabbergui.FeatureNotFoundError, match="did you mean"):
        camera["ExposureTim"] = 5


def test_wrong_values_say_what_is_allowed(camera: grabbergui.Camera) -> None:
    with pytest.raises(grabbergui.FeatureValueError, match="allowed: 10"):
        camera.exposure_time = -1
    with pytest.raises(grabbergui.FeatureValueError, match="one of"):
        camera.pixel_format = "Mono99"
    with pytest.raises(FeatureAccessError, match=r"camera\.execute"):
        _ = camera["TriggerSoftware"]


def test_grab_returns_a_frame_exposed_after_the_call(camera: grabbergui.Camera) -> None:
    for _ in range(5):
        called = time.monotonic()
        frame = camera.grab()
        assert frame.captured >= called and frame.raw().shape == (48, 64) and frame.rgb().shape == (48, 64, 3)
    assert camera.streaming


def test_frames_start_stop_and_end(camera: grabbergui.Camera) -> None:
    frames = list(camera.frames(10))
    assert len(frames) == 10 and not camera.streaming
    ids = [frame.frame_id for frame in frames]
    assert ids == sorted(set(ids))


def test_leaving_the_loop_stops_the_stream(camera: grabbergui.Camera) -> None:
    for frame in camera.frames():
        assert frame.complete
        break
    assert not camera.streaming
    with contextlib.suppress(ZeroDivisionError):
        for _ in camera.frames():
            raise ZeroDivisionError
    until(lambda: not camera.streaming)


def test_a_stream_that_ran_goes_on(camera: grabbergui.Camera) -> None:
    camera.start()
    assert len(list(camera.frames(2))) == 2
    assert camera.streaming


def test_no_frames_is_an_error_that_names_the_trigger(camera: grabbergui.Camera) -> None:
    camera["TriggerMode[TriggerSelector=FrameBurstStart]"] = "On"
    assert camera["TriggerMode"] == "Off"  # of the selected trigger
    with pytest.raises(
        grabbergui.FrameTimeoutError,
        match=r"camera\.trigger\(\).*TriggerMode\[TriggerSelector=FrameBurstStart\] to Off",
    ):
        camera.grab(timeout=0.2)
    assert camera["TriggerMode[TriggerSelector=FrameBurstStart]"] == "On"


def test_a_camera_is_not_sent_to_another_process(camera: grabbergui.Camera) -> None:
    with pytest.raises(TypeError, match="a camera cannot be sent to another process; open it there: 'sim:"):
        pickle.dumps(camera)
    assert pickle.loads(pickle.dumps(camera.grab())).complete


def test_closing_ends_a_wait(camera: grabbergui.Camera) -> None:
    camera["TriggerMode"] = "On"
    threading.Timer(0.2, camera.close).start()
    with pytest.raises(grabbergui.GrabberError):
        camera.grab(timeout=PATIENCE)


@pytest.mark.parametrize(
    "call",
    [
        lambda c: c.frames(-1),
        lambda c: c.bracket(),
        lambda c: c.bracket(ExposureTime=[1], Gain=[1, 2]),
        lambda c: c.bracket(ExposureTime=5),
        lambda c: c.bracket(ExposureTime="5ms"),
        lambda c: c.record("run.mcap", frames=0),
        lambda c: c.record("run.mcap", seconds=-1),
        lambda c: c.record("run.mcap", megabytes=math.nan),
        lambda c: c.record("run.mp4", codec="vp9"),
        lambda c: c.record("run.mp4", tiff=True),
    ],
)
def test_senseless_arguments_are_refused(camera: grabbergui.Camera, call: Any) -> None:
    with pytest.raises(UsageError):
        call(camera)


def test_what_is_no_source_is_refused() -> None:
    with pytest.raises(UsageError, match="write its URI"):
        grabbergui.open(Path("run.mcap"))  # type: ignore[arg-type]
    with pytest.raises(UsageError, match="there are control, monitor, take over"):
        grabbergui.open(FAST, access="write")  # type: ignore[arg-type]
    with pytest.raises(UsageError, match=r"as in open_all\(\['sim:'\]\)"):
        grabbergui.open_all("sim:")


def test_a_loop_waits_for_the_next_trigger_after_a_timeout(camera: grabbergui.Camera) -> None:
    camera["TriggerMode"] = "On"
    with camera.frames(timeout=0.05).started() as frames:
        with pytest.raises(grabbergui.FrameTimeoutError, match="waits for a trigger"):
            next(frames)
        camera.execute("TriggerSoftware")
        until(lambda: camera.statistics.frames, "the frame")
        assert next(frames).width == 64
    assert not camera.streaming


def test_asyncio_reads_writes_and_iterates_without_blocking(camera: grabbergui.Camera) -> None:
    async def main() -> tuple[int, int]:
        beats = frames = 0

        async def beat() -> None:
            nonlocal beats
            while True:
                await asyncio.sleep(0.005)
                beats += 1

        beating = asyncio.create_task(beat())
        async with camera:
            assert await camera.awrite("ExposureTime", 1500) == 1500.0 == await camera.aread("ExposureTime")
            assert (await camera.agrab(ExposureTime=2000)).chunks["ChunkExposureTime"] == 2000.0
            camera.stop()
            async for _ in camera.aframes(20):
                frames += 1
            assert (await camera.atrigger()).complete
        beating.cancel()
        return beats, frames

    beats, frames = asyncio.run(main())
    assert frames == 20 and beats > 5


def test_a_cancelled_loop_stops_the_stream(camera: grabbergui.Camera) -> None:
    async def endless() -> None:
        async for _ in camera.aframes():
            pass

    async def main() -> None:
        with pytest.raises(asyncio.TimeoutError):
            await asyncio.wait_for(endless(), 0.3)

    asyncio.run(main())
    until(lambda: not camera.streaming)


def test_several_cameras_are_opened_read_and_closed_as_one() -> None:
    with grabbergui.open_all([FAST, "sim:colour"]) as cameras:
        assert len(cameras) == 2 and [frame.width for frame in cameras.grab()] == [64, 1224]
        assert [len(frames) for frames in cameras.frames(3)] == [2, 2, 2]
        cameras.start()
        assert all(camera.streaming for camera in cameras)
        cameras.stop()
    with pytest.raises(grabbergui.GrabberError):
        cameras[0].grab()


def test_all_streams_of_a_group_start_before_a_frame_is_awaited() -> None:
    with grabbergui.open_all([f"{FAST}&serial=LEFT", f"{FAST}&serial=RIGHT"]) as cameras:
        for camera in cameras:
            camera["TriggerMode"] = "On"

        def fire() -> None:
            until(lambda: all(camera.streaming for camera in cameras), "both streams")
            for camera in cameras:
                camera.execute("TriggerSoftware")

        firing = threading.Thread(target=fire)
        firing.start()
        (pair,) = cameras.frames(1, timeout=PATIENCE)
        firing.join()
    assert len(pair) == 2


def test_if_one_does_not_open_none_stays_open() -> None:
    with pytest.raises(grabbergui.SourceNotFoundError):
        grabbergui.open_all(["sim:", "sim:nosuch"])


def test_a_group_reports_whatever_went_wrong_after_all_cameras_were_called(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with grabbergui.open_all([f"{FAST}&serial=LEFT", f"{FAST}&serial=RIGHT"]) as cameras:
        monkeypatch.setattr(cameras[0].grabber, "start", lambda **_: 1 / 0)
        with pytest.raises(ZeroDivisionError):
            cameras.start()
        assert [camera.streaming for camera in cameras] == [False, True]
