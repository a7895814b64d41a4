"""A stream through a packet ring: the same frames as through the socket, without its system calls."""

from __future__ import annotations

import errno
import logging
import socket
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest

from grabbergui import sources
from grabbergui.core.grabber import FrameGrabber
from grabbergui.driver.gige.stream import packet_ring
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.gige.server import GigeCamera
from grabbergui.driver.sim.gige.stream import Faults
from patience import PATIENCE

ADDRESS = "127.16.7.1"
WIDTH, HEIGHT = 640, 256


def may_open_packet_sockets() -> bool:
    try:
        socket.socket(socket.AF_PACKET, socket.SOCK_DGRAM, 0).close()
    except (PermissionError, AttributeError):
        return False
    return True


pytestmark = pytest.mark.skipif(not may_open_packet_sockets(), reason="packet sockets need CAP_NET_RAW")


@contextmanager
def streaming(*, segmentation: bool = False, loss: float = 0.0, options: str = "") -> Iterator[FrameGrabber]:
    camera = GigeCamera(
        ADDRESS,
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
    grabber = sources.create(f"gige:{ADDRESS}?packet_size=1500&packet_ring=1{options}")
    try:
        grabber.open()
        yield grabber
    finally:
        grabber.close()
        camera.close()


def check_frames(grabber: FrameGrabber, count: int = 8) -> None:
    """Every pixel of some frames; a moving ramp tells a packet in the wrong place."""
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

    monkeypatch.setattr(packet_ring, "BatchSource", refuse)


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


def test_the_ring_goes_round(monkeypatch: pytest.MonkeyPatch) -> None:
    system_calls_forbidden(monkeypatch)
    monkeypatch.setattr(packet_ring, "LEAST_SLOTS", 300)
    monkeypatch.setattr(packet_ring, "MOST_BYTES", 300 * 1500)
    with streaming() as grabber:
        check_frames(grabber, 20)


def test_packets_from_elsewhere_are_kept_out_by_the_kernel(monkeypatch: pytest.MonkeyPatch) -> None:
    system_calls_forbidden(monkeypatch)
    with streaming() as grabber:
        check_frames(grabber, 2)
        device = grabber.device  # type: ignore[attr-defined]
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
            stranger.bind(("127.16.7.2", 0))
            for _ in range(20):
                stranger.sendto(b"x" * 100, ("127.0.0.1", device._stream.port))
        check_frames(grabber, 2)
        assert grabber.statistics().packets_ignored == 0


def test_packets_that_come_joined_are_taken_from_the_socket(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.INFO), streaming(segmentation=True) as grabber:
        check_frames(grabber)
    assert [record for record in caplog.records if "packets come joined" in record.getMessage()]


def test_without_the_right_to_it_the_socket_serves(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(packet_ring.socket, "socket", _NoPacketSockets)
    with streaming() as grabber:
        check_frames(grabber, 2)
    warned = [record.getMessage() for record in caplog.records if record.levelname == "WARNING"]
    assert any("Operation not permitted; it needs CAP_NET_RAW" in text for text in warned)


class _NoPacketSockets(socket.socket):
    """As an unprivileged process meets them."""

    def __init__(self, family: int = socket.AF_INET, *arguments: int, **options: int) -> None:
        if family == socket.AF_PACKET:
            raise PermissionError(errno.EPERM, "Operation not permitted")
        super().__init__(family, *arguments, **options)
