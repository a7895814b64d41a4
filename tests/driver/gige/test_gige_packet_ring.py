"""A stream through a packet ring, the default where it is allowed: the same frames as through the socket."""

from __future__ import annotations

import errno
import logging
import socket
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest
from packet_sockets import may_open_packet_sockets, without_the_right

from grabbergui import sources
from grabbergui.core.grabber import FrameGrabber
from grabbergui.driver.gige.stream import batches, channel, ring_memory
from grabbergui.driver.gige.stream.ring_memory import Geometry, Ring
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.gige.server import GigeCamera
from grabbergui.driver.sim.gige.stream import Faults
from patience import PATIENCE, until

ADDRESS, OTHER = "127.16.7.1", "127.16.7.3"
WIDTH, HEIGHT = 640, 256


pytestmark = pytest.mark.skipif(not may_open_packet_sockets(), reason="packet sockets need CAP_NET_RAW")


@contextmanager
def streaming(
    *, at: str = ADDRESS, segmentation: bool = False, loss: float = 0.0, options: str = ""
) -> Iterator[FrameGrabber]:
    camera = GigeCamera(
        at,
        segmentation=segmentation,
        faults=Faults(loss=loss),
        power_on={
            reg.WIDTH: WIDTH,
            reg.HEIGHT: HEIGHT,
            reg.FRAME_RATE: 50.0,
            reg.EXPOSURE_TIME: 1000.0,
            reg.TEST_PATTERN: int(reg.TestPattern.GREY_HORIZONTAL_RAMP_MOVING),
        },
    )
    grabber = sources.create(f"gige:{at}?packet_size=1500{options}")
    try:
        grabber.open()
        yield grabber
    finally:
        grabber.close()
        camera.close()


def check_frames(grabber: FrameGrabber, count: int = 8) -> None:
    """Every pixel of some frames; a moving ramp shows a packet in the wrong place."""
    queue = grabber.open_queue(4)
    grabber.start()
    for _ in range(count):
        pixels = queue.get(PATIENCE).raw()
        expected = (np.arange(WIDTH) + int(pixels[0, 0])) & 0xFF
        assert (pixels == expected).all()
    queue.close()


def system_calls_forbidden(monkeypatch: pytest.MonkeyPatch) -> None:
    """No packet may come through the UDP socket."""

    def refuse(*_: object) -> None:
        raise AssertionError("a datagram was read from the socket")

    monkeypatch.setattr(batches, "BatchSource", refuse)


def test_frames_come_without_a_system_call(monkeypatch: pytest.MonkeyPatch) -> None:
    system_calls_forbidden(monkeypatch)
    with streaming() as grabber:
        check_frames(grabber)
        grabber.stop()
        check_frames(grabber)  # a ring of the next stream
        counters = grabber.statistics()
    assert (counters.packets_ignored, counters.incomplete) == (0, 0)


def test_lost_packets_are_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    system_calls_forbidden(monkeypatch)
    with streaming(loss=0.02) as grabber:
        check_frames(grabber, 20)
        assert grabber.statistics().packets_resent > 0


def test_packets_from_elsewhere_are_kept_out_by_the_kernel(monkeypatch: pytest.MonkeyPatch) -> None:
    system_calls_forbidden(monkeypatch)
    with streaming() as grabber:
        check_frames(grabber, 2)
        device = grabber.device  # type: ignore[attr-defined]
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
            stranger.bind(("127.16.7.2", 0))
            for _ in range(20):
                stranger.sendto(b"x" * 100, ("127.0.0.1", device._stream.channels[0].port))
        check_frames(grabber, 2)
        assert grabber.statistics().packets_ignored == 0


def test_packets_that_come_joined_are_taken_from_the_socket(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.INFO), streaming(segmentation=True) as grabber:
        check_frames(grabber)
        counters = grabber.statistics()
        grabber.stop()
        check_frames(grabber)  # of a stream without a ring, which costs 10 to 30 ms
    said = [record.getMessage() for record in caplog.records]
    assert len([text for text in said if "no longer through a packet ring" in text]) == 1
    assert (counters.incomplete, counters.lost) == (0, 0)


def ring_forbidden(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise AssertionError("a packet ring was opened")

    monkeypatch.setattr(channel, "PacketRing", refuse)


def test_the_socket_serves_where_no_ring_is_wanted(monkeypatch: pytest.MonkeyPatch) -> None:
    ring_forbidden(monkeypatch)
    with streaming(options="&packet_ring=0") as grabber:
        check_frames(grabber)
        assert grabber.statistics().packets_ignored == 0


@pytest.mark.parametrize(("options", "level"), [("", "DEBUG"), ("&packet_ring=1", "WARNING")])
def test_without_the_right_to_it_the_socket_serves(
    caplog: pytest.LogCaptureFixture, options: str, level: str
) -> None:
    caplog.set_level(logging.DEBUG, channel.__name__)
    with without_the_right(), streaming(options=options) as grabber:
        check_frames(grabber, 2)
    said = [(record.levelname, record.getMessage()) for record in caplog.records]
    reason = "Operation not permitted; it needs CAP_NET_RAW"
    assert [logged for logged, text in said if reason in text] == [level]


def test_without_memory_for_it_the_socket_serves(
    caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise OSError(errno.ENOMEM, "Cannot allocate memory")

    monkeypatch.setattr(channel, "PacketRing", refuse)
    with streaming(options="&packet_ring=1") as grabber:
        check_frames(grabber, 2)
    (said,) = [text for text in caplog.messages if "not through a packet ring" in text]
    assert said.endswith("Cannot allocate memory")


def test_two_cameras_and_two_channels_have_a_ring_each(monkeypatch: pytest.MonkeyPatch) -> None:
    system_calls_forbidden(monkeypatch)
    with streaming(options="&stream_channel=all") as first, streaming(at=OTHER) as second:
        queue = first.open_queue(8)
        first.start()
        check_frames(second)
        channels = {queue.get(PATIENCE).stream_channel for _ in range(8)}
        queue.close()
        assert channels == {0, 1}
        for grabber in (first, second):
            statistics = grabber.statistics()
            assert statistics.packets_ignored == 0
            assert statistics.packets_duplicate < statistics.packets / 10  # late ones, asked for again


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[Ring]:
    """The rings that the test makes."""
    rings: list[Ring] = []

    class KnownRing(Ring):
        def __init__(self, size: Geometry) -> None:
            super().__init__(size)
            rings.append(self)

    monkeypatch.setattr(ring_memory, "Ring", KnownRing)
    return rings


def test_a_stream_that_pauses_keeps_its_ring(made: list[Ring], monkeypatch: pytest.MonkeyPatch) -> None:
    system_calls_forbidden(monkeypatch)
    with streaming() as grabber:
        queue = grabber.open_queue(4)
        grabber.start()
        for format_name in ("Mono12p", "Mono8", "BayerRG8") * 3:
            grabber.write_feature("PixelFormat", format_name)
            assert queue.get(PATIENCE).pixel_format.name == format_name
        assert len(made) == 1
        assert grabber.statistics().packets_duplicate == 0
    assert made[0].socket.fileno() < 0  # freed


@pytest.mark.parametrize("lost", [False, True])
def test_a_closed_camera_has_no_ring(made: list[Ring], lost: bool) -> None:
    with streaming() as grabber:
        check_frames(grabber, 2)
        if lost:
            grabber.device.report_lost("as in a test")  # type: ignore[attr-defined]
            until(lambda: len(made) == 2 and grabber.streaming)
            check_frames(grabber, 2)
            assert made[0].socket.fileno() < 0
        grabber.close()
        assert [ring.socket.fileno() for ring in made] == [-1] * (1 + lost)


def test_a_camera_that_starts_again_has_a_ring_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """As after a lost connection."""
    system_calls_forbidden(monkeypatch)
    with streaming() as grabber:
        for _ in range(3):
            check_frames(grabber, 2)
            grabber.stop()
            grabber.close()
            grabber.open()
        check_frames(grabber, 2)
