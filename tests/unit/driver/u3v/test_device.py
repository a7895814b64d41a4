"""Host and simulated camera on a bus within the process: frames, registers, events, chunks."""

from __future__ import annotations

import threading
import time

import numpy as np
import pytest

from grabbergui.core import frame as frame_module
from grabbergui.core.errors import AccessDeniedError, DeviceStatusError, PixelFormatError
from grabbergui.core.frame import Frame
from grabbergui.core.grabber import Access, ConnectionState, DeviceEvent
from grabbergui.driver.device import StreamRequest
from grabbergui.driver.device_grabber import DeviceGrabber
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.enumerations import EVENT_ID_BASE, EventSelector
from grabbergui.driver.u3v.bootstrap import Abrm
from grabbergui.driver.u3v.device_clock import DeviceClock
from patience import PATIENCE, until
from u3v_frames import grab


def test_fifty_frames_arrive_whole(plug_in) -> None:
    _, device = plug_in()
    camera = DeviceGrabber(device)
    camera.open()
    queue = camera.open_queue(50)
    camera.start()
    # Not all are kept: there are fewer buffers than that.
    seen = [
        (frame.frame_id, frame.complete, int(frame.raw()[0, 0]))
        for frame in (queue.get(PATIENCE) for _ in range(50))
    ]
    camera.stop()
    statistics = camera.statistics()
    camera.close()
    assert (statistics.frame_rate, statistics.bandwidth) == (0.0, 0.0)
    assert [frame_id for frame_id, _, _ in seen] == list(range(50))
    assert all(complete for _, complete, _ in seen)
    assert statistics.frames >= 50
    assert (statistics.incomplete, statistics.lost, statistics.packets_ignored) == (0, 0, 0)
    # A ramp that moves by as much from each frame to the next.
    steps = np.diff([value for _, _, value in seen]) % 256
    assert len(set(steps.tolist())) == 1
    assert steps[0] != 0


def test_a_consumer_that_keeps_every_buffer_costs_frames_not_the_stream(plug_in, monkeypatch) -> None:
    monkeypatch.setattr(frame_module, "MOST_BUFFERS", 32)
    _, device = plug_in()
    camera = DeviceGrabber(device)
    camera.open()
    queue = camera.open_queue(64)
    camera.start()
    until(lambda: camera.statistics().underruns > 5)
    queue.clear()
    frames = camera.statistics().frames
    until(lambda: camera.statistics().frames > frames + 5)
    camera.close()


@pytest.mark.parametrize("error", [ValueError("consumer"), PixelFormatError("consumer")])
def test_a_consumer_that_fails_ends_neither_stream_nor_connection(plug_in, caplog, error) -> None:
    _, device = plug_in()
    camera = DeviceGrabber(device)
    states: list[ConnectionState] = []
    camera.open()
    camera.connection_changed.connect(lambda state, reason: states.append(state))
    deliver, failed = camera._acquisition._deliver, threading.Event()

    def failing(frame: Frame) -> None:
        if not failed.is_set():
            failed.set()
            raise error
        deliver(frame)

    camera._acquisition._deliver = failing
    assert len(grab(camera, 5)) == 5
    assert failed.is_set() and not states
    assert "a consumer of frames failed" in caplog.text
    camera.close()


def test_a_frame_larger_than_a_transfer_is_put_together_without_a_copy(plug_in) -> None:
    _, device = plug_in(width=1224, height=1024, largest_transfer=65536)
    camera = DeviceGrabber(device)
    camera.open()
    frames = grab(camera, 3)
    camera.close()
    for frame in frames:
        assert frame.complete
        assert frame.raw().base is not None
        assert np.shares_memory(frame.raw(), frame.payload)
        ramp = frame.raw()
        assert (ramp == ramp[0]).all()


def test_time_stamps_are_on_the_hosts_clock(plug_in) -> None:
    _, device = plug_in()
    camera = DeviceGrabber(device)
    camera.open()
    before = time.time_ns()
    frames = grab(camera, 5)
    camera.close()
    after = time.time_ns()
    assert all(before - 50_000_000 < frame.received_ns < after for frame in frames)
    offsets = [frame.received_ns - frame.timestamp_ns for frame in frames]
    assert max(offsets) - min(offsets) < 1_000_000, "mapped, not the time of arrival"


def test_the_cameras_clock_is_in_nanoseconds_however_coarse_it_is(plug_in, monkeypatch) -> None:
    simulated, device = plug_in()
    read = simulated.registers.read

    def coarse(address: int, length: int) -> bytes:
        return (1000).to_bytes(8, "little") if address == Abrm.TIMESTAMP_INCREMENT else read(address, length)

    monkeypatch.setattr(simulated.registers, "read", coarse)
    device.open(Access.CONTROL)
    device.open_stream(StreamRequest(64 * 48), lambda frame: None)
    now = time.monotonic_ns()
    mapped = device._clock.host_time(simulated.model.timestamp(), arrival_ns=now + 50 * 10**9)
    assert mapped < now + 10 * 10**9, "the arrival stands where the clock is not believed"
    device.close()


@pytest.mark.parametrize("rate", [0.9, 0.5, 1e-3])
def test_a_clock_that_is_too_slow_dates_no_frame(monkeypatch, rate) -> None:
    now = [10**12]
    monkeypatch.setattr(time, "monotonic_ns", lambda: now[0])
    clock = DeviceClock()
    for _ in range(5):
        clock.synchronise(lambda: None, lambda: round(now[0] * rate))
        now[0] += 10**9
    assert clock.host_time(round(now[0] * rate), now[0] + 5) == now[0] + 5, "the arrival"
    clock.synchronise(lambda: None, lambda: now[0] - 10**12)
    assert clock.host_time(now[0] - 10**12, now[0] + 5) == now[0], "a clock that was set back"
    now[0] += 10**9
    clock.synchronise(lambda: None, lambda: now[0] - 10**12)
    assert clock.host_time(now[0] - 10**12, now[0] + 5) == now[0]


def test_readings_in_short_succession_judge_no_clock(monkeypatch) -> None:
    now = [10**12]
    monkeypatch.setattr(time, "monotonic_ns", lambda: now[0])
    clock = DeviceClock()
    for late in (0, 800_000, 0, 900_000):
        clock.synchronise(lambda: None, lambda late=late: now[0] - late)
        now[0] += 1_000_000
    assert clock.host_time(now[0], now[0] + 10**9) != now[0] + 10**9


def test_a_camera_whose_clock_makes_no_sense_is_not_lost(plug_in, monkeypatch) -> None:
    simulated, device = plug_in()
    read, lost = simulated.registers.read, []

    def cut_short(address: int, length: int) -> bytes:
        return read(address, length)[: 2 if address == Abrm.TIMESTAMP else length]

    monkeypatch.setattr(simulated.registers, "read", cut_short)
    device.on_lost = lost.append
    camera = DeviceGrabber(device)
    camera.open()
    assert len(grab(camera, 3)) == 3
    camera.close()
    assert not lost


def test_a_camera_that_refuses_to_be_halted_streams(plug_in, monkeypatch) -> None:
    simulated, device = plug_in()
    answer = simulated.control_request

    def stubborn(request_type: int, request: int, value: int, index: int) -> bytes | None:
        return None if (request_type, request) == (0x02, 3) else answer(request_type, request, value, index)

    monkeypatch.setattr(simulated, "control_request", stubborn)
    camera = DeviceGrabber(device)
    camera.open()
    assert len(grab(camera, 3)) == 3
    camera.close()


def test_features_are_read_and_written(plug_in) -> None:
    simulated, device = plug_in()
    camera = DeviceGrabber(device)
    camera.open()
    assert camera.write_feature("ExposureTime", 2500).value == 2500.0
    assert simulated.model.memory.number(reg.EXPOSURE_TIME) == 2500.0
    assert camera.feature("DeviceTLType").value == "USB3Vision"
    camera.write_feature("DeviceUserID", "left eye")
    camera.close()
    assert simulated.model.memory.get(reg.DEVICE_USER_ID) == "left eye"


def test_what_is_known_of_an_opened_camera(plug_in) -> None:
    _, device = plug_in()
    device.open(Access.CONTROL)
    assert (device.info.vendor, device.info.model) == ("grabbergui", "Simulated camera")
    assert device.info.uri == "u3v:SIM001"
    assert device.description().lstrip().startswith(b"<?xml")


def test_a_device_refuses_by_status(plug_in) -> None:
    _, device = plug_in()
    device.open(Access.CONTROL)
    with pytest.raises(DeviceStatusError, match="invalid address"):
        device.read(0x9999_0000, 4)
    with pytest.raises(DeviceStatusError, match="write protect"):
        device.write(0x0, b"\1\0\0\0")
    assert device.read(0, 4) == b"\1\0\1\0"


def test_monitor_access_writes_nothing(plug_in) -> None:
    _, device = plug_in()
    assert device.open(Access.MONITOR) is Access.MONITOR
    with pytest.raises(AccessDeniedError, match="reading only"):
        device.write(reg.WIDTH.address, bytes(4))


def test_events_reach_the_node_map_packet_by_packet(plug_in) -> None:
    _, device = plug_in()
    seen: list[tuple[int, bytes]] = []
    device.on_event = lambda event_id, packet: seen.append((event_id, packet))
    device.open(Access.CONTROL)
    device.write(reg.EVENT_NOTIFICATION[EventSelector.TEST].address, (1).to_bytes(4, "big"))
    device.write(reg.TEST_EVENT_GENERATE.address, (1).to_bytes(4, "big"))
    until(lambda: bool(seen))
    event_id, packet = seen[0]
    assert event_id == EVENT_ID_BASE + EventSelector.TEST
    assert packet[:4] == b"U3VE"


@pytest.mark.parametrize("alignment", [1, 4, 1024, 4096])
def test_a_strict_camera_of_any_alignment_streams(plug_in, alignment: int) -> None:
    _, device = plug_in(width=72, height=50, alignment=alignment, strict=True)
    camera = DeviceGrabber(device)
    camera.open()
    frames = grab(camera, 3)
    camera.close()
    assert [len(frame.payload) for frame in frames] == [3600] * 3


def test_chunks_lie_behind_the_image(plug_in) -> None:
    _, device = plug_in()
    camera = DeviceGrabber(device)
    camera.open()
    camera.write_feature("ChunkModeActive", True)
    frame = grab(camera, 2)[1]
    camera.close()
    assert len(frame.payload) > 64 * 48
    assert frame.raw().shape == (48, 64)
    length = int.from_bytes(frame.payload[-4:].tobytes(), "little")
    assert 0 < length < 100


def test_chunks_are_values_of_the_frame(plug_in) -> None:
    _, device = plug_in()
    camera = DeviceGrabber(device)
    camera.open()
    camera.write_feature("ChunkModeActive", True)
    camera.write_feature("ExposureTime", 1500.0)
    frames = grab(camera, 3)
    camera.close()
    ids = [frame.chunks["ChunkFrameID"] for frame in frames]
    assert ids == list(range(ids[0], ids[0] + 3))
    assert all(frame.chunks["ChunkTimestamp"] == frame.timestamp_ns for frame in frames)
    assert all(frame.chunks["ChunkExposureTime"] == 1500.0 for frame in frames)
    assert frames[0].raw().shape == (48, 64)


def test_events_are_features_and_a_signal(plug_in) -> None:
    _, device = plug_in()
    camera = DeviceGrabber(device)
    reported: list[DeviceEvent] = []
    camera.event_received.connect(reported.append)
    camera.open()
    camera.write_feature("EventSelector", "ExposureEnd")
    camera.write_feature("EventNotification", "On")
    frames = grab(camera, 2)
    last = frames[-1].frame_id + 1  # the camera counts from one
    until(lambda: reported and reported[-1].values["EventExposureEndFrameID"] >= last)
    assert {event.name for event in reported} == {"ExposureEnd"}
    assert [event.values["EventExposureEndFrameID"] for event in reported[:last]] == [*range(1, last + 1)]
    assert camera.feature("EventExposureEndFrameID").value in {
        event.values["EventExposureEndFrameID"] for event in reported
    }
    camera.close()
