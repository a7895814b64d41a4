"""`aravis:` sources on Aravis's own fake camera and on our simulated one."""

from __future__ import annotations

import ipaddress
import os
import queue
import threading
from collections.abc import Iterator
from contextlib import ExitStack, closing
from typing import Any
from unittest.mock import Mock

import pytest

from grabbergui import sources
from grabbergui.core.errors import (
    AccessDeniedError,
    AckTimeoutError,
    DeviceLostError,
    DeviceStatusError,
    FeatureValueError,
    OtherCameraError,
    SourceNotFoundError,
    SourceUnavailableError,
    UsageError,
)
from grabbergui.core.grabber import Access, ConnectionState, FrameGrabber
from grabbergui.core.identity import DeviceInfo
from grabbergui.core.uri import SourceUri
from grabbergui.driver.aravis import device, library
from grabbergui.driver.aravis.device import FoundCamera
from grabbergui.driver.gige.bootstrap import StreamChannel
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.gige.server import GigeCamera
from patience import PATIENCE, until

try:
    library.load()
except SourceUnavailableError as missing:
    pytestmark = [pytest.mark.aravis, pytest.mark.skip(reason=str(missing))]
else:
    pytestmark = pytest.mark.aravis

ADDRESS = f"127.82.{os.getpid() % 250 + 1}.1"


@pytest.fixture
def simulated() -> Iterator[GigeCamera]:
    power_on = {reg.WIDTH: 64, reg.HEIGHT: 48, reg.FRAME_RATE: 50.0, reg.EXPOSURE_TIME: 1000.0}
    with closing(GigeCamera(ADDRESS, power_on=power_on)) as camera:
        yield camera


@pytest.fixture
def opened(simulated: GigeCamera) -> Iterator[FrameGrabber]:
    before = set(threading.enumerate())
    grabber = sources.create(f"aravis:{ADDRESS}")
    grabber.open()
    yield grabber
    grabber.close()
    # A packet ring of our own driver is freed by a thread that ends by itself.
    until(lambda: set(threading.enumerate()) <= before, "the end of all threads")


def test_frames_arrive_whole_and_in_order(opened: FrameGrabber) -> None:
    frames = opened.open_queue(30)
    opened.start()
    grabbed = [frames.get(PATIENCE) for _ in range(20)]
    opened.stop()
    ids = [frame.frame_id for frame in grabbed]
    assert ids == sorted(set(ids))
    assert {(frame.raw().shape, frame.pixel_format.name) for frame in grabbed} == {((48, 64), "Mono8")}
    statistics = opened.statistics()
    assert statistics.frames >= 20 and statistics.bytes == statistics.frames * 64 * 48
    assert statistics.packets >= 20 * 5


def test_the_same_node_map_serves(opened: FrameGrabber, simulated: GigeCamera) -> None:
    assert opened.write_feature("ExposureTime", 2500.0).value == 2500.0
    assert simulated.model.memory.number(reg.EXPOSURE_TIME) == 2500.0
    with pytest.raises(FeatureValueError, match="ExposureTime"):
        opened.write_feature("ExposureTime", -1.0)
    assert opened.info.bus == "Aravis"


def test_a_format_changes_while_streaming(opened: FrameGrabber) -> None:
    frames = opened.open_queue(2)
    opened.start()
    frames.get(PATIENCE)
    opened.write_feature("Width", 128)
    until(lambda: frames.get(PATIENCE).width == 128, "the new width")
    assert opened.feature("Width").value == 128


def test_chunks_are_values(opened: FrameGrabber) -> None:
    opened.write_feature("ChunkModeActive", True)
    frames = opened.open_queue(2)
    opened.start()
    frame = frames.get(PATIENCE)
    assert frame.chunks["ChunkFrameID"] >= 1 and frame.chunks["ChunkExposureTime"] == 1000.0


def test_frames_that_are_kept_stay_as_they_are(opened: FrameGrabber) -> None:
    frames = opened.open_queue(30)
    opened.start()
    kept = [frames.get(PATIENCE) for _ in range(15)]
    copies = [frame.payload.copy() for frame in kept]
    opened.close()
    assert all((frame.payload == copy).all() for frame, copy in zip(kept, copies, strict=True))


def test_a_held_camera_is_refused_and_can_be_read(simulated: GigeCamera) -> None:
    with (
        closing(sources.create(f"gige:{ADDRESS}")) as holder,
        closing(sources.create(f"aravis:{ADDRESS}")) as grabber,
    ):
        holder.open()
        with pytest.raises(AccessDeniedError, match="another application controls"):
            grabber.open()
        grabber.open(Access.MONITOR)
        assert grabber.feature("Width").value == 64 and not grabber.feature("Width").access.writable
        with pytest.raises(AccessDeniedError, match="only with control of the camera"):
            grabber.start()


def test_reading_only_leaves_control_to_others(simulated: GigeCamera) -> None:
    with (
        closing(sources.create(f"aravis:{ADDRESS}")) as looker,
        closing(sources.create(f"gige:{ADDRESS}")) as operator,
    ):
        looker.open(Access.MONITOR)
        operator.open()
        assert operator.write_feature("Width", 80).value == 80


def test_closing_gives_control_back_at_once(simulated: GigeCamera) -> None:
    for _ in range(3):
        grabber = sources.create(f"aravis:{ADDRESS}")
        grabber.open()
        assert simulated.control.controlled
        grabber.close()
        assert not simulated.control.controlled


def test_what_the_camera_refuses_is_reported(opened: FrameGrabber) -> None:
    device: Any = opened.device  # type: ignore[attr-defined]
    with pytest.raises(DeviceStatusError, match="reading 4 bytes at 0x1FFFF0"):
        device.read(0x1FFFF0, 4)


def test_after_closing_nothing_crashes(opened: FrameGrabber) -> None:
    device: Any = opened.device  # type: ignore[attr-defined]
    opened.close()
    with pytest.raises(DeviceLostError, match="not open"):
        device.read(0, 4)
    device.close_stream()
    assert device.stream_statistics().frame_rate == 0


def test_control_that_went_elsewhere_is_reported(opened: FrameGrabber, simulated: GigeCamera) -> None:
    states: queue.Queue[ConnectionState] = queue.Queue()
    opened.connection_changed.connect(lambda state, why: states.put(state))
    simulated.control.release()
    assert states.get(timeout=PATIENCE) is ConnectionState.LOST
    assert states.get(timeout=PATIENCE) is ConnectionState.OPEN


def test_a_refused_write_notices_that_control_is_gone(opened: FrameGrabber, simulated: GigeCamera) -> None:
    """A camera that restarted between two heartbeats of Aravis is lost; it does not refuse this feature."""
    states: queue.Queue[ConnectionState] = queue.Queue()
    opened.write_feature("ExposureTime", 1500.0)
    opened.connection_changed.connect(lambda state, why: states.put(state))
    simulated.control.release()
    with pytest.raises(DeviceLostError, match="is lost"):
        opened.write_feature("ExposureTime", 1600.0)
    assert states.get(timeout=PATIENCE) is ConnectionState.LOST
    assert states.get(timeout=PATIENCE) is ConnectionState.OPEN
    assert opened.feature("ExposureTime").value == 1500.0


def test_a_camera_that_answers_neither_write_nor_read_is_lost(
    opened: FrameGrabber, monkeypatch: pytest.MonkeyPatch
) -> None:
    def time_out(failure: library.Failure) -> None:
        raise AckTimeoutError("Aravis answered: timeout")

    states: queue.Queue[tuple[ConnectionState, str]] = queue.Queue()
    opened.connection_changed.connect(lambda state, why: states.put((state, why)))
    with monkeypatch.context() as silence:
        silence.setattr(library.Failure, "check", time_out)
        with pytest.raises(DeviceLostError, match="does not answer"):
            opened.write_feature("ExposureTime", 1600.0)
        assert states.get(timeout=PATIENCE) == (ConnectionState.LOST, "the camera does not answer")
        with pytest.raises(DeviceLostError):
            opened.write_feature("ExposureTime", 1600.0)
    assert states.get(timeout=PATIENCE)[0] is ConnectionState.OPEN


def twin_at(address: str, model: str = "Twin") -> GigeCamera:
    """Another camera of the same serial number."""
    power_on = {reg.DEVICE_SERIAL_NUMBER: "TWIN", reg.DEVICE_MODEL_NAME: model, reg.DEVICE_USER_ID: address}
    return GigeCamera(address, power_on=power_on)


def test_of_two_cameras_of_one_serial_both_in_use_the_named_address_answers() -> None:
    addresses = [ADDRESS, f"{ADDRESS}1"]
    with ExitStack() as stack:
        for address in addresses:
            stack.enter_context(closing(twin_at(address)))
            stack.enter_context(closing(sources.create(f"gige:{address}"))).open()
        for address in addresses * 3:
            with closing(sources.create(f"aravis:{address}")) as named:
                named.open(Access.MONITOR)
                assert named.feature("DeviceUserID").value == address == named.info.address


def test_another_camera_at_the_named_address_is_refused_and_named() -> None:
    first = twin_at(ADDRESS)
    with closing(sources.create(f"aravis:{ADDRESS}")) as grabber:
        grabber.open()
        grabber.close()
        first.close()
        refused = pytest.raises(OtherCameraError, match=r"Twin.*Another|Another.*Twin")
        with closing(twin_at(ADDRESS, "Another")), refused:
            grabber.open()


def test_its_own_fake_camera_is_listed_and_opened(
    aravis_camera: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert device.discover(0.1) == []
    monkeypatch.setenv(device.SEARCH, "1")
    infos = {info.serial: info for info in device.discover(0.1)}
    info = infos["GV01"]
    assert (info.vendor, info.model, info.address) == ("Aravis", "Fake", "127.0.0.1")
    with closing(sources.create(info.uri)) as grabber:
        grabber.open()
        assert grabber.info.serial == "GV01" and grabber.info.bus == "GigE Vision by Aravis"
        assert grabber.write_feature("GainRaw", 5).value == 5
        frames = grabber.open_queue(8)
        grabber.start()
        assert frames.get(PATIENCE).raw().shape == (512, 512)


@pytest.mark.parametrize(("address", "plain"), [("127.82.0.9", True), ("192.168.0.9", False)])
def test_on_the_loopback_it_is_a_plain_socket_whatever_the_camera_is_named_by(
    monkeypatch: pytest.MonkeyPatch, address: str, plain: bool
) -> None:
    found = FoundCamera("Acme-Model-77", "00:11:22:33:44:55", address, "Acme", "Model", "77", "GigEVision")
    aravis = Mock(**{"arv_open_device.return_value": 1, "g_signal_connect_data.return_value": 1})
    monkeypatch.setattr(device, "load", lambda: aravis)
    monkeypatch.setattr(device, "find_cameras", lambda: [found])
    opened = device.AravisDevice("77", DeviceInfo("aravis:77", address="77"))
    opened.open(Access.CONTROL)
    assert aravis.arv_gv_device_set_stream_options.called is plain
    opened.close()


def test_an_unknown_name_is_an_error_that_lists_what_is_there(aravis_camera: Any) -> None:
    with pytest.raises(SourceNotFoundError, match="Aravis-Fake-GV01"):
        sources.create("aravis:nobody").open()


def test_options_are_refused() -> None:
    with pytest.raises(UsageError, match="no options"):
        sources.create("aravis:?packet_size=9000")


def test_without_the_library_the_message_names_the_package(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(library, "_places", lambda: iter(["libaravis-of-no-machine.so"]))
    library.load.cache_clear()
    try:
        with pytest.raises(SourceUnavailableError, match="apt install libaravis"):
            device.create(SourceUri.parse("aravis:"))
    finally:
        library.load.cache_clear()


def test_our_driver_listens_in_on_what_aravis_controls(opened: FrameGrabber) -> None:
    device: Any = opened.device  # type: ignore[attr-defined]
    opened.start()
    # Aravis streams to itself only, so its controller names the group by hand.
    device.write(StreamChannel(0).destination, ipaddress.IPv4Address("239.192.3.4").packed)
    with closing(sources.create(f"gige:{ADDRESS}")) as listener:
        with pytest.raises(AccessDeniedError):
            listener.open()
        listener.open(Access.MONITOR)
        frames = listener.open_queue(20)
        listener.start()
        grabbed = [frames.get(PATIENCE) for _ in range(10)]
        assert all(frame.raw().shape == (48, 64) for frame in grabbed)
        assert opened.write_feature("ExposureTime", 1100.0).value == 1100.0
