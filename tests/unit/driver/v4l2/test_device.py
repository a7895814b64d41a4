"""A webcam as a GenICam camera: names, units, locks, formats, frames, loss."""

from __future__ import annotations

import errno
import mmap
import os
import time
from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("linuxpy.video.device", reason="linuxpy has Linux's video interface")

from fake_video import EXPOSURE, EXPOSURE_AUTO, RESET, FakeVideo
from grabbergui.core.errors import (
    DeviceLostError,
    FeatureAccessError,
    FeatureValueError,
    OtherCameraError,
    SourceNotFoundError,
    TransportError,
)
from grabbergui.core.features import AccessMode, FeatureKind
from grabbergui.core.frame import BufferPool
from grabbergui.core.grabber import ConnectionState
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.sfnc import Role
from grabbergui.driver.device import StreamRequest
from grabbergui.driver.device_grabber import DeviceGrabber
from grabbergui.driver.genapi.cleaning import clean_xml
from grabbergui.driver.genapi.loading import load
from grabbergui.driver.v4l2 import device as v4l2_device
from grabbergui.driver.v4l2 import video as video_module
from grabbergui.driver.v4l2.description import describe
from grabbergui.driver.v4l2.device import V4l2Device
from grabbergui.driver.v4l2.stream import V4l2Stream
from grabbergui.driver.v4l2.video import Control, ControlKind, FrameSizes, VideoDevice
from patience import PATIENCE, until

INFO = DeviceInfo(
    "v4l2:/dev/video7",
    "Acme",
    "Eye",
    "7",
    "V4L2",
    "/dev/video7",
    version="6.1.0",
    hardware_id="usb-1",
    interface="uvcvideo",
)


@pytest.fixture
def video() -> FakeVideo:
    return FakeVideo()


@pytest.fixture
def camera(video: FakeVideo, monkeypatch: pytest.MonkeyPatch) -> Iterator[DeviceGrabber]:
    monkeypatch.setattr(v4l2_device, "find", lambda: [INFO])
    camera = DeviceGrabber(V4l2Device("", DeviceInfo("v4l2:"), lambda path: video))  # type: ignore[arg-type, return-value]
    camera.open()
    yield camera
    camera.close()


def test_the_webcam_reports_its_identity(camera: DeviceGrabber) -> None:
    assert camera.info.title == "Acme Eye 7" and camera.info.uri == "v4l2:"
    assert camera.feature("DeviceSerialNumber").value == "7"
    assert [category.name for category in camera.feature_tree().members][:3] == [  # type: ignore[union-attr]
        "DeviceControl", "ImageFormatControl", "AcquisitionControl",
    ]  # fmt: skip


def test_exposure_is_in_microseconds(camera: DeviceGrabber, video: FakeVideo) -> None:
    exposure = camera.feature("ExposureTime")
    assert (exposure.value, exposure.unit, exposure.kind) == (10_000.0, "us", FeatureKind.FLOAT)
    assert (exposure.minimum, exposure.maximum, exposure.auto) == (300.0, 204_700.0, "ExposureAuto")
    camera.write_feature("ExposureTime", 5_000)
    assert video.values[EXPOSURE] == 50


def test_writing_a_value_switches_its_automatic_mode_off(camera: DeviceGrabber, video: FakeVideo) -> None:
    camera.write_feature("ExposureAuto", "Continuous")
    assert video.values[EXPOSURE_AUTO] == 3 and video.locked(EXPOSURE)
    camera.write_feature("ExposureTime", 20_000)
    assert (video.values[EXPOSURE_AUTO], video.values[EXPOSURE]) == (1, 200)


def test_menus_switches_and_buttons_are_features(camera: DeviceGrabber, video: FakeVideo) -> None:
    power = camera.feature("PowerLineFrequency")
    assert [entry.name for entry in power.entries] == ["Disabled", "N50Hz", "N60Hz"]
    assert [entry.display_name for entry in power.entries] == ["Disabled", "50 Hz", "60 Hz"]
    camera.write_feature("PowerLineFrequency", "N50Hz")
    camera.write_feature("ReverseX", True)
    camera.execute("PanReset")
    assert (video.values[0x00980918], video.values[0x00980914], video.pressed) == (1, 1, 1)
    assert RESET in video.values


def test_two_controls_of_one_name_are_two_features(camera: DeviceGrabber, video: FakeVideo) -> None:
    camera.write_feature("Gain2", -3)
    assert video.values[0x0098F900] == -3 and camera.feature("Gain").value == 0


def test_roles_are_found(camera: DeviceGrabber) -> None:
    found = {role: camera.role(role) for role in (Role.EXPOSURE, Role.GAIN, Role.FRAME_RATE)}
    assert list(found.values()) == ["ExposureTime", "Gain", "AcquisitionFrameRate"]


def test_formats_sizes_and_rates(camera: DeviceGrabber, video: FakeVideo) -> None:
    formats = camera.feature("PixelFormat")
    assert [entry.name for entry in formats.entries] == ["YUV422_8", "MJPG", "Mono8"]
    assert (camera.feature("AcquisitionFrameRate").maximum, camera.feature("Width").value) == (30.0, 640)
    assert camera.feature("Width").access is AccessMode.READ_ONLY
    camera.write_feature("Resolution", "R320x240")
    assert (video.size, camera.feature("Width").value) == ((320, 240), 320)
    camera.write_feature("AcquisitionFrameRate", 58.0)
    assert camera.feature("AcquisitionFrameRate").value == 60.0
    with pytest.raises(FeatureValueError, match="allowed"):
        camera.write_feature("ExposureTime", 1e9)


@pytest.mark.parametrize(
    ("name", "shape"), [("Mono8", (480, 640)), ("YUV422_8", (480, 640, 2)), ("MJPG", (480, 640, 3))]
)
def test_frames_arrive_in_every_format(camera: DeviceGrabber, name: str, shape: tuple[int, ...]) -> None:
    camera.write_feature("PixelFormat", name)
    queue, begun = camera.open_queue(), time.monotonic()
    camera.start()
    first, second = queue.get(PATIENCE), queue.get(PATIENCE)
    assert first.raw().shape == shape and first.rgb().shape == (480, 640, 3)
    assert second.frame_id > first.frame_id and begun - 5 < second.captured < time.monotonic() + 5
    ramp = first.mono()[240].astype(int)
    assert np.corrcoef(ramp, np.arange(640))[0, 1] > 0.99


def test_a_format_is_changed_while_it_streams(camera: DeviceGrabber) -> None:
    queue = camera.open_queue()
    camera.start()
    queue.get(PATIENCE)
    assert camera.pauses_for("Resolution")
    camera.write_feature("Resolution", "R320x240")
    until(lambda: queue.get(PATIENCE).width == 320)
    assert camera.streaming and camera.statistics().incomplete == 0


def test_one_that_was_left_in_a_format_that_cannot_be_shown_is_opened_and_says_so(
    video: FakeVideo, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(v4l2_device, "find", lambda: [INFO])
    video.code = "XYZ9"
    camera = DeviceGrabber(V4l2Device("", DeviceInfo("v4l2:"), lambda path: video))  # type: ignore[arg-type, return-value]
    with closing(camera):
        camera.open()
        with pytest.raises(TransportError, match="XYZ9, which cannot be shown; choose another PixelFormat"):
            camera.start()
        camera.write_feature("PixelFormat", "Mono8")
        queue = camera.open_queue()
        camera.start()
        assert queue.get(PATIENCE).raw().shape == (480, 640)


def test_frames_for_which_no_buffer_is_free_are_counted_once(
    video: FakeVideo, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(BufferPool, "take", lambda self: None)
    stream = V4l2Stream(video, StreamRequest(0), lambda frame: None, lambda why: None)  # type: ignore[arg-type]
    until(lambda: stream.statistics().underruns >= 2)
    stream.close()
    video.close()
    assert stream.statistics().incomplete <= 1


def test_frames_of_a_driver_without_that_clock_have_the_time_of_their_arrival(
    camera: DeviceGrabber, video: FakeVideo
) -> None:
    video.stamp = lambda: 0
    queue = camera.open_queue()
    before = time.time_ns()
    camera.start()
    frame = queue.get(PATIENCE)
    assert frame.timestamp_ns == 0 and before <= frame.received_ns <= time.time_ns()


def test_a_broken_image_costs_only_itself(camera: DeviceGrabber, video: FakeVideo) -> None:
    camera.write_feature("PixelFormat", "MJPG")
    whole = video.image()
    size = whole.index(b"\xff\xc0") + 5  # in the frame's header
    video.image = lambda: whole[:size] + b"\xf0\0\xf0\0" + whole[size + 4 :]  # type: ignore[method-assign]
    queue = camera.open_queue()
    camera.start()
    until(lambda: camera.statistics().incomplete >= 2)
    del video.image  # type: ignore[method-assign]
    assert queue.get(PATIENCE).raw().shape == (480, 640, 3)


def test_a_stream_that_the_bus_has_no_room_for_leaves_no_buffers_behind(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    freed: list[object] = []
    maps = [mmap.mmap(-1, 4096) for _ in range(2)]
    api = SimpleNamespace(
        create_mmap_buffers=lambda *_: maps,
        stream_on=refuse,
        stream_off=lambda *_: None,
        free_buffers=lambda *which: freed.append(which),
        ioctl=lambda *_: None,
        IOC=video_module.v4l2.IOC,
        Memory=video_module.v4l2.Memory,
    )
    monkeypatch.setattr(video_module, "v4l2", api)
    (path := tmp_path / "video7").touch()
    with closing(VideoDevice(str(path))) as device, pytest.raises(TransportError, match="choose a smaller"):
        device.begin(2)
    assert len(freed) == 1 and all(each.closed for each in maps)


def test_a_device_that_is_unplugged_between_two_calls_of_its_stream_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise OSError(errno.ENODEV, os.strerror(errno.ENODEV))

    (path := tmp_path / "video7").touch()
    with closing(VideoDevice(str(path))) as device:
        monkeypatch.setattr(video_module.v4l2, "ioctl", refuse)
        with pytest.raises(DeviceLostError, match="video7 was unplugged"):
            device.queue(0)


def test_a_webcam_that_is_unplugged_comes_back_as_it_was(
    camera: DeviceGrabber, video: FakeVideo, monkeypatch: pytest.MonkeyPatch
) -> None:
    states: list[ConnectionState] = []
    camera.connection_changed.connect(lambda state, why: states.append(state))
    camera.write_feature("ExposureTime", 20_000)
    queue = camera.open_queue()
    camera.start()
    queue.get(PATIENCE)
    fresh = FakeVideo()
    camera.device.opener = lambda path: fresh  # type: ignore[attr-defined]
    video.unplugged = True
    until(lambda: states[-2:] == [ConnectionState.LOST, ConnectionState.OPEN], str(states))
    assert fresh.values[EXPOSURE] == 200
    assert queue.get(PATIENCE).complete


def test_a_webcam_that_is_unplugged_without_a_stream_comes_back_as_it_was(
    camera: DeviceGrabber, video: FakeVideo
) -> None:
    states: list[ConnectionState] = []
    camera.connection_changed.connect(lambda state, why: states.append(state))
    camera.write_feature("ExposureTime", 20_000)
    fresh = FakeVideo()
    camera.device.opener = lambda path: fresh  # type: ignore[attr-defined]
    video.unplugged = True
    with pytest.raises(DeviceLostError, match="unplugged"):
        camera.write_feature("Gain", 9)
    until(lambda: states == [ConnectionState.LOST, ConnectionState.OPEN], str(states))
    assert fresh.values[EXPOSURE] == 200


def test_a_webcam_is_opened_again_although_another_is_the_first_now(
    camera: DeviceGrabber, monkeypatch: pytest.MonkeyPatch
) -> None:
    other = replace(INFO, uri="v4l2:/dev/video0", serial="8", address="/dev/video0", hardware_id="usb-2")
    camera.close()
    monkeypatch.setattr(v4l2_device, "find", lambda: [other])
    with pytest.raises(OtherCameraError, match="serial 8"):
        camera.open()
    monkeypatch.setattr(v4l2_device, "find", lambda: [other, INFO])
    camera.device.opener = lambda path: FakeVideo()  # type: ignore[attr-defined]
    camera.open()
    assert camera.info.serial == "7"


def test_no_webcam_is_an_error_that_says_what_is_there(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(v4l2_device, "find", lambda: [INFO])
    with pytest.raises(SourceNotFoundError, match=r"/dev/video9.*found: /dev/video7"):
        DeviceGrabber(V4l2Device("/dev/video9", DeviceInfo("v4l2:/dev/video9"))).open()


@pytest.mark.parametrize("name", ["/dev/video7", "video7", "7", "usb-1", "eye"])
def test_it_is_found_by_each_of_its_names(
    name: str, video: FakeVideo, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(v4l2_device, "find", lambda: [INFO])
    camera = DeviceGrabber(V4l2Device(name, DeviceInfo(f"v4l2:{name}"), lambda path: video))  # type: ignore[arg-type, return-value]
    camera.open()
    try:
        assert (camera.info.model, camera.info.uri) == ("Eye", f"v4l2:{name}")
    finally:
        camera.close()


def test_a_locked_setting_is_not_written(camera: DeviceGrabber) -> None:
    with pytest.raises(FeatureAccessError):
        camera.write_feature("DeviceSerialNumber", "8")


@pytest.mark.parametrize(
    ("menu", "entries"),
    [
        ({1: "Manual", 3: "Aperture Priority"}, ["Off", "Continuous"]),
        ({0: "Auto", 1: "Manual"}, ["Off", "Continuous"]),
        ({0: "Auto", 1: "Manual", 3: "Aperture Priority"}, ["Off", "Continuous", "Automatic"]),
    ],
)
def test_the_automatic_exposure_can_be_switched_on_whatever_the_driver_calls_it(
    menu: dict[int, str], entries: list[str], video: FakeVideo, monkeypatch: pytest.MonkeyPatch
) -> None:
    mode = Control(EXPOSURE_AUTO, "Auto Exposure", ControlKind.MENU, 0, 3, 1, menu)
    monkeypatch.setattr(v4l2_device, "find", lambda: [INFO])
    monkeypatch.setattr(video, "controls", lambda: [mode])
    camera = DeviceGrabber(V4l2Device("", DeviceInfo("v4l2:"), lambda path: video))  # type: ignore[arg-type, return-value]
    camera.open()
    try:
        assert [entry.name for entry in camera.feature("ExposureAuto").entries] == entries
        camera.write_feature("ExposureAuto", "Continuous")
        assert "Manual" not in menu[video.values[EXPOSURE_AUTO]]
    finally:
        camera.close()


@pytest.mark.parametrize(
    ("codes", "control"),
    [
        ([], Control(1, "Tint", ControlKind.INTEGER, 0, 9)),
        (["XYZ9"], Control(1, "Tint", ControlKind.INTEGER, 0, 9)),
        (["GREY"], Control(1, "", ControlKind.INTEGER, 0, 9)),
        (["GREY"], Control(1, "a\x01\x1b name\x7f", ControlKind.BOOLEAN)),
        (["GREY"], Control(1, "Mode", ControlKind.MENU)),
        (["GREY"], Control(1, "Mode", ControlKind.MENU, menu={0: "", 1: "\x02", 2: "<&>"})),
    ],
    ids=["no formats", "unknown formats", "no name", "control characters", "empty menu", "nameless entries"],
)
def test_whatever_a_driver_lists_makes_a_description_that_loads(codes: list[str], control: Control) -> None:
    layout = describe("a camera", codes, FrameSizes.listed([(640, 480)]), [control])
    nodes = load(clean_xml(layout.xml))
    assert nodes.has_node("Width")
    assert nodes.has_node("PixelFormat") == (codes == ["GREY"])
    assert nodes.has_node("Mode") == bool(control.menu)
