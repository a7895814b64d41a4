"""Streams that share a link or are shared: pauses between packets, multicast beside another controller."""

from __future__ import annotations

import itertools
import os
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grabbergui import sources
from grabbergui.core.errors import AccessDeniedError, UsageError
from grabbergui.core.grabber import Access, FrameGrabber
from grabbergui.driver.gige.stream.packet_delay import ETHERNET_BYTES, PacketDelayPolicy
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.gige import registers as gev
from grabbergui.driver.sim.gige.server import GigeCamera
from patience import PATIENCE

_numbers = itertools.count(1)
GIGABIT = 125e6


@pytest.fixture
def simulate() -> Iterator[Callable[..., GigeCamera]]:
    """Starts a small simulated camera at an address of its own."""
    with ExitStack() as stack:

        def start(**registers: Any) -> GigeCamera:
            power_on = {reg.WIDTH: 320, reg.HEIGHT: 240, reg.FRAME_RATE: 30.0, reg.EXPOSURE_TIME: 1000.0}
            address = f"127.84.{os.getpid() % 250 + 1}.{next(_numbers)}"
            return stack.enter_context(closing(GigeCamera(address, power_on=power_on, **registers)))

        yield start


def opened(stack: ExitStack, uri: str, access: Access = Access.CONTROL) -> FrameGrabber:
    grabber = stack.enter_context(closing(sources.create(uri)))
    grabber.open(access)
    return grabber


@pytest.mark.parametrize(
    ("delay", "bandwidth", "pause"),
    [
        ("", "", None),
        ("0", "", 0.0),
        ("800ns", "", 8e-7),
        ("10us", "", 1e-5),
        ("1.5ms", "", 1.5e-3),
        ("", "62.5MB", 1500 / 62.5e6 - 1538 / GIGABIT),
        ("", "1GB/s", 0.0),
    ],
)
def test_a_pause_is_given_or_follows_from_the_bandwidth(
    delay: str, bandwidth: str, pause: float | None
) -> None:
    assert PacketDelayPolicy.parse(delay, bandwidth).pause(1500, GIGABIT) == pytest.approx(pause)


@given(st.floats(1e5, 1e9), st.integers(576, 16000))
def test_the_bandwidth_that_results_is_the_one_asked_for_or_the_links(rate: float, size: int) -> None:
    pause = PacketDelayPolicy(bytes_per_second=rate).pause(size, GIGABIT)
    assert pause is not None
    result = size / (pause + (size + ETHERNET_BYTES) / GIGABIT)
    assert result == pytest.approx(min(rate, size * GIGABIT / (size + ETHERNET_BYTES)))


@pytest.mark.parametrize(
    "options",
    [
        "packet_delay=10",
        "packet_delay=2s",
        "packet_delay=101ms",
        "bandwidth=fast",
        "bandwidth=1B",
        "bandwidth=60MB&packet_delay=1us",
        "multicast=10.0.0.1",
        "multicast=all",
    ],
)
def test_nonsense_is_refused_with_an_example(options: str) -> None:
    with pytest.raises(UsageError, match=r"write|say the same"):
        sources.create(f"gige:127.0.0.1?{options}")


def test_the_camera_holds_the_pause_and_keeps_it(simulate: Callable[..., GigeCamera]) -> None:
    camera = simulate()
    with ExitStack() as stack:
        for options, ticks in (("?packet_delay=20us", 20_000), ("", 20_000), ("?packet_delay=0", 0)):
            grabber = opened(stack, f"gige:{camera.address}{options}")
            frames = grabber.open_queue()
            assert isinstance(grabber.feature("GevSCPD").value, int)
            grabber.start()
            assert frames.get(PATIENCE).complete
            assert camera.control.memory.integer(gev.CHANNELS[0].scpd) == ticks
            assert grabber.feature("GevSCPD").value == ticks, "GenApi's cache does not hide it"
            grabber.close()


def test_a_bandwidth_bounds_the_rate_at_which_a_frame_comes(simulate: Callable[..., GigeCamera]) -> None:
    camera = simulate()
    with ExitStack() as stack:
        grabber = opened(stack, f"gige:{camera.address}?bandwidth=2MB&packet_size=1500")
        frames = grabber.open_queue(30)
        grabber.start()
        begun = time.monotonic()
        for _ in range(10):
            assert frames.get(PATIENCE).complete
        # 10 frames of 76,800 bytes at 2 MB/s; the camera would take a third of a second for them.
        assert time.monotonic() - begun > 9 * 76_800 / 2e6 * 0.9


def test_others_listen_in_addition_to_the_controller(simulate: Callable[..., GigeCamera]) -> None:
    camera = simulate()
    group = f"239.192.{os.getpid() % 250}.7"
    with ExitStack() as stack:
        operator = opened(stack, f"gige:{camera.address}?multicast={group}")
        listeners = [opened(stack, f"gige:{camera.address}", Access.MONITOR) for _ in range(2)]
        queues = [grabber.open_queue(40) for grabber in (operator, *listeners)]
        operator.start()
        for listener in listeners:
            listener.start()
        begin = max(queue.get(PATIENCE).frame_id for queue in queues)
        for queue in queues:
            frame = queue.get(PATIENCE)
            while frame.frame_id <= begin + 10:
                frame = queue.get(PATIENCE)
            assert frame.complete and frame.raw().shape == (240, 320)
        listeners[0].close()
        with pytest.raises(AccessDeniedError, match="this program controls"):
            opened(stack, f"gige:{camera.address}")
        assert operator.write_feature("ExposureTime", 1200.0).value == 1200.0, "control is the operator's"
        assert listeners[1].feature("ExposureTime").value == 1200.0
        assert not listeners[1].feature("ExposureTime").access.writable


def test_a_stream_to_the_controller_alone_is_refused_with_the_remedy(
    simulate: Callable[..., GigeCamera],
) -> None:
    camera = simulate()
    with ExitStack() as stack:
        operator = opened(stack, f"gige:{camera.address}")
        listener = opened(stack, f"gige:{camera.address}", Access.MONITOR)
        with pytest.raises(AccessDeniedError, match=r"sends no frames yet.* multicast group"):
            listener.start()
        operator.start()
        with pytest.raises(AccessDeniedError, match=r"frames to 127\.0\.0\.1 alone.* multicast group"):
            listener.start()
