"""End to end with cameras that others wrote."""

from __future__ import annotations

import struct
import threading
import time
from contextlib import closing, nullcontext
from dataclasses import replace
from typing import Any

import pytest

from grabbergui.core.errors import (
    AccessDeniedError,
    DeviceLostError,
    DeviceStatusError,
    SourceNotFoundError,
    UsageError,
)
from grabbergui.core.frame import Frame, FrameStatus
from grabbergui.core.grabber import Access
from grabbergui.core.uri import SourceUri
from grabbergui.driver.device import StreamRequest
from grabbergui.driver.gige.bootstrap import BootstrapRegister
from grabbergui.driver.gige.control_link import ControlLink
from grabbergui.driver.gige.device import GigeDevice, GigeOptions, create, discover
from grabbergui.driver.gige.gvcp import Status
from grabbergui.driver.gige.stream.packet_size import PacketSizePolicy
from patience import PATIENCE, TRIES, attempts, until

ARAVIS = pytest.mark.aravis
ARAVIS_GAIN_RAW = 0x110
ARAVIS_ACQUISITION = 0x124
ARAVIS_PAYLOAD = 512 * 512
VIVA_WIDTH = 0x2000


class Collector:
    """Takes frames from the receiving thread; keeps copies, since a consumer may not hold every buffer."""

    def __init__(self) -> None:
        self.frames: list[Frame] = []
        self._changed = threading.Condition()

    def __call__(self, frame: Frame) -> None:
        with self._changed:
            self.frames.append(replace(frame, payload=frame.payload.copy()))
            self._changed.notify_all()

    def wait_for(self, count: int, timeout: float = 20.0) -> list[Frame]:
        with self._changed:
            assert self._changed.wait_for(lambda: len(self.frames) >= count, timeout), (
                f"{len(self.frames)} frames of {count}"
            )
            return self.frames[:count]


def opened(name: str = "127.0.0.1", access: Access = Access.CONTROL, **options: Any) -> GigeDevice:
    device = GigeDevice(name, GigeOptions(**options))
    assert device.open(access) is access
    return device


@ARAVIS
@pytest.mark.parametrize("name", ["", "127.0.0.1", "GV01", "gv01"])
def test_is_found_by_every_name(aravis_camera: Any, name: str) -> None:
    with closing(opened(name, Access.MONITOR)) as device:
        assert (device.info.vendor, device.info.model, device.info.serial) == ("Aravis", "Fake", "GV01")
        assert device.info.uri == f"gige:{name or 'GV01'}"
        assert device._link.local_address == "127.0.0.1"


@ARAVIS
def test_the_camera_of_aravis_is_listed(aravis_camera: Any) -> None:
    (info,) = [info for info in discover(0.5) if info.address == "127.0.0.1"]
    assert (info.uri, info.bus, info.interface, info.note) == ("gige:GV01", "GigE Vision", "lo", "")


@ARAVIS
def test_an_unknown_name_is_an_error_that_lists_what_is_there(aravis_camera: Any) -> None:
    with pytest.raises(SourceNotFoundError, match="found: gige:GV01"):
        opened("GV99", search_timeout=1.0)


@ARAVIS
@pytest.mark.parametrize("batched", [True, False])
def test_streams_fifty_complete_frames(aravis_camera: Any, batched: bool) -> None:
    for _ in range(TRIES):  # this camera sends nothing twice, and a busy machine may lose some
        with closing(opened(batched=batched)) as device:
            take = Collector()
            device.open_stream(StreamRequest(ARAVIS_PAYLOAD), take)
            device.write(ARAVIS_ACQUISITION, struct.pack(">I", 1))
            frames = take.wait_for(50)
            device.write(ARAVIS_ACQUISITION, struct.pack(">I", 0))
            device.close_stream()
            statistics = device.stream_statistics()
            assert statistics.frames == len(take.frames)
            assert statistics.bytes == ARAVIS_PAYLOAD * len(take.frames)
            (channel,) = device._stream.channels
            assert channel.port > 0 and channel.packet_size == 1400
        if not statistics.packets_missing:
            break
    assert statistics.incomplete == statistics.lost == statistics.packets_missing == 0
    assert {(frame.width, frame.height, frame.pixel_format.name) for frame in frames} == {(512, 512, "Mono8")}
    ids = [frame.frame_id for frame in frames]
    assert ids == list(range(ids[0], ids[0] + 50))
    assert len({frame.payload.tobytes() for frame in frames[:5]}) == 5, "the image moves"
    assert frames[-1].timestamp_ns - frames[0].timestamp_ns > 49 * 20e6, "25 frames/s or less"
    assert abs(frames[-1].received_ns - frames[-1].timestamp_ns) < 1e9, "this camera keeps the host's time"


@ARAVIS
@pytest.mark.parametrize("asked, held", [("576", 576), ("keep", 1400), ("auto", 1400), ("9000", 9000)])
def test_packet_size_is_what_was_asked_for(aravis_camera: Any, asked: str, held: int) -> None:
    with closing(opened(packet_size=PacketSizePolicy.parse(asked))) as device:
        take = Collector()
        device.open_stream(StreamRequest(ARAVIS_PAYLOAD), take)
        device.write(ARAVIS_ACQUISITION, struct.pack(">I", 1))
        take.wait_for(3)
        assert device._stream.channels[0].packet_size == held
        assert device.stream_statistics().incomplete == 0


@ARAVIS
def test_registers_keep_what_is_written(aravis_camera: Any) -> None:
    with closing(opened()) as device:
        device.write(ARAVIS_GAIN_RAW, struct.pack(">I", 5))
        assert device.read(ARAVIS_GAIN_RAW, 4) == b"\0\0\0\5"
        device.write(ARAVIS_GAIN_RAW + 3, b"\7")
        assert device.read(ARAVIS_GAIN_RAW, 4) == b"\0\0\0\7", "a byte inside a word"
        assert device.read(0x48, 32).rstrip(b"\0") == b"Aravis"
        assert device.read(0x49, 5) == b"ravis", "unaligned address and length"


@ARAVIS
def test_description_is_the_cameras_xml(aravis_camera: Any) -> None:
    with closing(opened(access=Access.MONITOR)) as device:
        xml = device.description()
    assert xml.startswith(b"<?xml") and xml.rstrip().endswith(b"</RegisterDescription>")


@ARAVIS
def test_incomplete_frames_are_counted_and_by_choice_delivered(start_aravis: Any) -> None:
    start_aravis("-r", "20")
    for deliver_incomplete in (False, True):
        with closing(opened()) as device:
            take = Collector()
            device.open_stream(StreamRequest(ARAVIS_PAYLOAD, deliver_incomplete), take)
            device.write(ARAVIS_ACQUISITION, struct.pack(">I", 1))
            until(lambda: device.stream_statistics().incomplete >= 5)
            statistics = device.stream_statistics()
            device.write(ARAVIS_ACQUISITION, struct.pack(">I", 0))
        assert statistics.packets_missing >= statistics.incomplete
        broken = [frame for frame in take.frames if frame.status is FrameStatus.INCOMPLETE]
        assert bool(broken) is deliver_incomplete
        for frame in broken:
            assert frame.payload.nbytes == ARAVIS_PAYLOAD


@ARAVIS
def test_a_second_controller_is_refused_but_may_look_on(aravis_camera: Any) -> None:
    with closing(opened()) as first:
        with pytest.raises(AccessDeniedError, match="another application"):
            opened()
        with closing(opened(access=Access.MONITOR)) as second:
            assert second.read(ARAVIS_GAIN_RAW, 4) == first.read(ARAVIS_GAIN_RAW, 4)
            with pytest.raises(AccessDeniedError):
                second.write(ARAVIS_GAIN_RAW, b"\0\0\0\1")
            with pytest.raises(AccessDeniedError, match="multicast"):
                second.open_stream(StreamRequest(ARAVIS_PAYLOAD), Collector())


@ARAVIS
def test_control_outlives_the_heartbeat_timeout_and_ends_on_close(aravis_camera: Any) -> None:
    for timeout in (0.6, 3.0):  # the longer where a busy machine lets even the heartbeat's thread wait
        lost: list[str] = []
        with closing(opened()) as device:
            device.on_lost = lost.append
            device.write(BootstrapRegister.HEARTBEAT_TIMEOUT_MS, struct.pack(">I", round(1000 * timeout)))
            time.sleep(3.3 * timeout)  # the time itself is tested: no command of ours meanwhile
            if not lost:
                assert device.read(BootstrapRegister.CCP, 4) == b"\0\0\0\2"
                break
    assert not lost
    for watch in attempts(1.0):  # the next program gets control at once
        with watch, closing(opened()) as device:
            device.write(ARAVIS_GAIN_RAW, b"\0\0\0\1")


@ARAVIS
@pytest.mark.parametrize("promise", ["known", "closed"])
def test_a_dead_camera_is_known_within_two_seconds_and_closing_does_not_wait_for_it(
    start_aravis: Any, promise: str
) -> None:
    unmeasured = nullcontext()
    for watch in attempts({"known": 2.0, "closed": 0.5}[promise]):
        camera = start_aravis()
        lost: list[str] = []
        device = opened()
        device.on_lost = lost.append
        with watch if promise == "known" else unmeasured:
            camera.kill()
            until(lambda lost=lost: lost)
        assert "did not answer" in lost[0]
        with pytest.raises(DeviceLostError):
            device.read(ARAVIS_GAIN_RAW, 4)
        with watch if promise == "closed" else unmeasured:
            device.close()
        assert len(lost) == 1


@ARAVIS
def test_the_same_device_opens_again_after_its_camera_came_back(start_aravis: Any) -> None:
    camera = start_aravis()
    lost: list[str] = []
    with closing(opened("GV01")) as device:
        device.on_lost = lost.append
        camera.kill()
        until(lambda: lost)
        start_aravis()
        device.open(Access.CONTROL)
        take = Collector()
        device.open_stream(StreamRequest(ARAVIS_PAYLOAD), take)
        device.write(ARAVIS_ACQUISITION, struct.pack(">I", 1))
        take.wait_for(3)


def test_opening_writes_nothing_but_the_privilege(viva_camera: Any) -> None:
    before = viva_camera.writes()
    with closing(opened()) as device:
        device.description()
        assert viva_camera.writes() == before + 1
        assert viva_camera.controller().startswith("127.0.0.1:")
    assert viva_camera.writes() == before + 2, "and closing nothing but its release"
    assert viva_camera.controller() is None


def test_looking_on_writes_nothing(viva_camera: Any) -> None:
    before = viva_camera.writes()
    with closing(opened(access=Access.MONITOR)) as device:
        assert b"RegisterDescription" in device.description()
    assert viva_camera.writes() == before


def test_lost_packets_are_asked_for_again(start_viva: Any) -> None:
    dropped = [(2, 5), (2, 6), (3, 0), (4, 1), (5, 211), (6, 100)]
    camera = start_viva(drop_packets=dropped)
    with closing(create(SourceUri.parse("gige:127.0.0.1"))) as grabber:
        grabber.open()
        queue = grabber.open_queue(32)
        grabber.start()
        frames = [queue.get(PATIENCE) for _ in range(12)]
        grabber.stop()
        statistics = grabber.statistics()
    assert [frame.frame_id for frame in frames] == list(range(1, 13))
    assert all(frame.complete for frame in frames)
    assert statistics.incomplete == statistics.lost == statistics.packets_missing == 0
    # A lost trailer costs nothing, since all pixels are there without it. On a busy machine packets come so
    # late that they are asked for again, and then twice.
    assert statistics.packets_resent >= len(dropped) - 1
    assert statistics.packets_resent == len(dropped) - 1 or statistics.packets_duplicate
    assert camera.controller() is None


def test_without_resend_the_frame_is_incomplete(start_viva: Any) -> None:
    start_viva(drop_packets=[(2, 5), (2, 6)], packet_resend=False)
    with closing(create(SourceUri.parse("gige:127.0.0.1?incomplete=1"))) as grabber:
        grabber.open()
        queue = grabber.open_queue(32)
        grabber.start()
        frames = [queue.get(PATIENCE) for _ in range(4)]
        statistics = grabber.statistics()
    assert [frame.complete for frame in frames] == [True, False, True, True]
    assert frames[1].missing_bytes == 2 * 1464
    assert not frames[1].payload[4 * 1464 : 6 * 1464].any()
    assert (statistics.incomplete, statistics.packets_missing) == (1, 2)


def test_a_slow_command_stops_neither_heart_nor_stream(start_viva: Any) -> None:
    start_viva(delay_ack={0x20030: 1.2})
    lost: list[str] = []
    with closing(opened()) as device:
        device.on_lost = lost.append
        begun = time.monotonic()
        device.write(0x20030, struct.pack(">d", 8000.0))
        assert time.monotonic() - begun > 1.0, "answered after the camera had asked for patience"
        assert not lost


def test_control_taken_away_is_reported(viva_camera: Any) -> None:
    lost: list[str] = []
    with closing(opened()) as device:
        device.on_lost = lost.append
        viva_camera.revoke_control()
        until(lambda: lost)
        assert "control" in lost[0]


def test_a_refusal_names_the_status(viva_camera: Any) -> None:
    with (
        closing(ControlLink("127.0.0.1")) as link,
        pytest.raises(DeviceStatusError, match="BAD_ALIGN") as caught,
    ):
        link.read_register(BootstrapRegister.CCP + 2)
    assert caught.value.status == Status.BAD_ALIGNMENT


@pytest.mark.parametrize("uri", ["gige:?packet_size=1", "gige:?packets=1", "gige:?incomplete=perhaps"])
def test_malformed_options_are_refused(uri: str) -> None:
    with pytest.raises(UsageError):
        create(SourceUri.parse(uri))
