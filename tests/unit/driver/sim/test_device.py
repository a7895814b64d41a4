"""`sim:` as users name it, streaming for real."""

import threading
import time
from itertools import pairwise

import numpy as np
import pytest

from grabbergui.core.errors import DeviceLostError, DeviceStatusError, SourceNotFoundError, UsageError
from grabbergui.core.frame import MOST_BUFFERS
from grabbergui.core.grabber import Access
from grabbergui.core.pfnc import by_name
from grabbergui.core.uri import SourceUri
from grabbergui.driver.device import StreamRequest
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.device import create, create_device, discover, served_at
from grabbergui.driver.sim.enumerations import EventSelector
from patience import PATIENCE, until


def uri(text):
    return SourceUri.parse(text)


def test_the_built_in_camera_is_always_found():
    info, colour = discover(0.1)
    assert (colour.uri, colour.serial) == ("sim:colour", "SIM002")
    assert create_device(uri("sim:colour")).model.memory.get(reg.PIXEL_FORMAT) == by_name("BayerRG8").code
    assert (info.uri, info.vendor, info.model, info.serial, info.bus) == (
        "sim:",
        "grabbergui",
        "Simulated camera",
        "SIM001",
        "Simulated",
    )


def test_every_simulated_camera_has_a_serial_number_of_its_own():
    serials = [create_device(uri(f"sim:{name}")).info.serial for name in ("", "colour", "scene", "board")]
    assert len(set(serials)) == len(serials)
    left, right = served_at(uri("sim:?fps=5"), "/left"), served_at(uri("sim:?fps=5"), "/right")
    assert create_device(left).info.serial != create_device(right).info.serial
    assert left == served_at(uri("sim:?fps=5"), "/left"), "a restarted server's camera is the same"
    assert served_at(uri("sim:?serial=X7"), "/left") == uri("sim:?serial=X7")


def test_options_are_power_on_values():
    device = create_device(uri("sim:?width=640&height=480&fps=60&pixel_format=BayerRG8&serial=X7&gain=1.5"))
    get = device.model.memory.get
    assert (get(reg.WIDTH), get(reg.HEIGHT), get(reg.FRAME_RATE), get(reg.GAIN_RAW)) == (640, 480, 60.0, 150)
    assert device.info.serial == get(reg.DEVICE_SERIAL_NUMBER) == "X7"
    assert device.info.user_name == ""


@pytest.mark.parametrize(("name", "kept"), [("ä" * 9, "ä" * 8), ("x" + "ä" * 9, "x" + "ä" * 7)])
def test_a_name_that_is_too_long_is_cut_between_letters(name, kept):
    camera = create(uri(f"sim:?user_id={name}"))
    camera.open()
    try:
        assert camera.feature("DeviceUserID").value == camera.info.user_name == kept
    finally:
        camera.close()


def test_a_fast_rate_shortens_the_exposure():
    get = create_device(uri("sim:?fps=400&height=480")).model.memory.get
    assert get(reg.FRAME_RATE) == pytest.approx(400)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("sim:?size=1", "width, height, fps"),
        ("sim:?width=641", "16 to 4096 in steps of 8"),
        ("sim:?fps=many", "0.5 to 1000"),
        ("sim:?pixel_format=Mono9", "pixel_format=Mono9; allowed: Mono8, "),
        ("sim:?test_pattern=Bogus", "allowed: Off, Black, White, GreyHorizontalRamp, "),
        ("sim:?gain=inf", "0 to 24"),
        ("sim:?gain=nan", "0 to 24"),
        ("sim:?gain=25", "allowed: 0 to 24$"),
        ("sim:?exposure=inf", "10 to 1000000"),
    ],
)
def test_options_that_make_no_sense_are_refused(text, says):
    with pytest.raises(UsageError, match=says):
        create(uri(text))


def test_an_unknown_serial_number_is_not_found():
    with pytest.raises(SourceNotFoundError, match="SIM999"):
        create(uri("sim:SIM999"))


def test_refusals_carry_a_status():
    device = create_device(uri("sim:"))
    with pytest.raises(DeviceLostError):
        device.read(reg.WIDTH.address, 4)
    device.open(Access.CONTROL)
    with pytest.raises(DeviceStatusError) as caught:
        device.write(reg.SENSOR_WIDTH_REGISTER.address, bytes(4))
    assert caught.value.status == 0x8004
    device.close()


@pytest.fixture
def streaming():
    device = create_device(uri("sim:?width=64&height=48&fps=1000&exposure=100"))
    device.open(Access.CONTROL)
    frames = []
    arrived = threading.Semaphore(0)

    def deliver(frame):
        frames.append(frame)
        arrived.release()

    def take(count):
        for _ in range(count):
            assert arrived.acquire(timeout=PATIENCE)
        return frames

    device.open_stream(StreamRequest(64 * 48), deliver)
    device.write(reg.ACQUISITION_START.address, bytes((0, 0, 0, 1)))
    yield device, take
    device.close()


def test_frames_come_numbered_and_stamped(streaming):
    device, take = streaming
    frames = take(5)
    assert [frame.frame_id for frame in frames[:5]] == [1, 2, 3, 4, 5]
    assert all(b.timestamp_ns > a.timestamp_ns for a, b in pairwise(frames))
    assert abs(frames[0].received_ns - time.time_ns()) < 5e9
    assert frames[0].raw().shape == (48, 64) and frames[0].complete
    assert device.stream_statistics().frames >= 5


def test_each_create_is_a_camera_of_its_own(streaming):
    device, _ = streaming
    other = create_device(uri("sim:"))
    other.open(Access.CONTROL)
    device.write(reg.EXPOSURE_TIME.address, reg.EXPOSURE_TIME.encode(77.0))
    assert other.read(reg.EXPOSURE_TIME.address, 8) == reg.EXPOSURE_TIME.encode(10_000.0)
    other.close()


def test_held_frames_cost_underruns_not_memory(streaming):
    device, take = streaming
    frames = take(MOST_BUFFERS)
    first = frames[0].payload.copy()
    until(lambda: device.stream_statistics().underruns > 0)
    assert len(frames) == MOST_BUFFERS and np.array_equal(frames[0].payload, first)


def test_a_consumer_that_fails_does_not_end_the_stream(caplog):
    device = create_device(uri("sim:?width=64&height=48&fps=200"))
    device.open(Access.CONTROL)
    arrived = threading.Semaphore(0)

    def deliver(frame):
        arrived.release()
        if frame.frame_id == 1:
            raise ValueError("consumer")

    device.open_stream(StreamRequest(64 * 48), deliver)
    device.write(reg.ACQUISITION_START.address, bytes((0, 0, 0, 1)))
    assert all(arrived.acquire(timeout=PATIENCE) for _ in range(3))
    device.close()
    assert "a consumer of frames failed" in caplog.text


def test_closing_ends_the_thread(streaming):
    device, take = streaming
    take(1)
    device.close()
    device.close()
    assert not any(thread.name == "simulated camera" for thread in threading.enumerate())


def test_chunks_and_events_reach_the_listener():
    device = create_device(uri("sim:?width=64&height=48"))
    device.open(Access.CONTROL)
    heard = threading.Event()
    events, frames = [], []
    device.on_event = lambda *event: (events.append(event), heard.set())
    for register in (reg.CHUNK_MODE_ACTIVE, reg.EVENT_NOTIFICATION[EventSelector.FRAME_START]):
        device.write(register.address, bytes((0, 0, 0, 1)))
    got = threading.Event()
    device.open_stream(StreamRequest(64 * 48 + 72), lambda frame: (frames.append(frame), got.set()))
    device.write(reg.ACQUISITION_START.address, bytes((0, 0, 0, 1)))
    assert heard.wait(PATIENCE) and got.wait(PATIENCE)
    device.close()
    event_id, message = events[0]
    assert event_id == 0x9000 and message[10:12] == b"\x90\x00" and len(message) == 8 + 32
    assert frames[0].chunks["ChunkFrameID"] == 1
    assert frames[0].chunks["ChunkExposureTime"] == 10_000.0
    assert len(frames[0].payload) == 64 * 48 + 72
