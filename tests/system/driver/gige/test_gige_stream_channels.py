"""Cameras with several stream channels: one of them, or all at once."""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterator
from contextlib import ExitStack, closing

import numpy as np
import pytest

from grabbergui import sources
from grabbergui.core.errors import UsageError
from grabbergui.core.grabber import FrameGrabber
from grabbergui.driver.gige.bootstrap import BootstrapRegister, StreamChannel
from grabbergui.driver.gige.device_memory import DeviceMemory
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.gige import registers as gev
from grabbergui.driver.sim.gige.faults import GigeFaults
from grabbergui.driver.sim.gige.server import GigeCamera
from patience import PATIENCE

SMALL = {reg.WIDTH: 256, reg.HEIGHT: 128, reg.FRAME_RATE: 50.0, reg.EXPOSURE_TIME: 1000.0}
LOSSES = [GigeFaults(), GigeFaults(loss=0.08, reorder=True, duplicate=True)]
_numbers = itertools.count(1)


@pytest.fixture
def stage() -> Iterator[ExitStack]:
    with ExitStack() as stack:
        yield stack


def opened(
    stage: ExitStack, options: str, faults: GigeFaults | None = None
) -> tuple[GigeCamera, FrameGrabber]:
    """Return a camera with two channels, and a grabber that has opened it."""
    address = f"127.17.{os.getpid() % 250 + 1}.{next(_numbers)}"
    camera = stage.enter_context(closing(GigeCamera(address, power_on=SMALL, faults=faults)))
    grabber = stage.enter_context(closing(sources.create(f"gige:{address}{options}")))
    grabber.open()
    return camera, grabber


def open_ports(camera: GigeCamera) -> list[bool]:
    return [bool(camera.control.memory.integer(channel.scp)) for channel in gev.CHANNELS]


def test_a_stream_that_starts_again_reads_only_what_may_have_changed(
    stage: ExitStack, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each request takes about a millisecond, and the stream rests meanwhile."""
    read: list[int] = []
    read_register = DeviceMemory.read_register

    def noted(memory: DeviceMemory, address: int) -> int:
        read.append(address)
        return read_register(memory, address)

    _, grabber = opened(stage, "?packet_size=1000")
    grabber.start()
    grabber.stop()
    monkeypatch.setattr(DeviceMemory, "read_register", noted)
    grabber.start()
    channel = StreamChannel(0)
    assert read.count(channel.packet_size) == 2, "before and after it is written"
    others = {address for address in read if address != channel.packet_size}
    assert others == {channel.source_port, BootstrapRegister.GVSP_CONFIGURATION}


@pytest.mark.parametrize("faults", LOSSES, ids=["clean", "lossy"])
@pytest.mark.parametrize("index", [0, 1])
def test_only_the_chosen_channel_is_received(stage: ExitStack, index: int, faults: GigeFaults) -> None:
    camera, grabber = opened(stage, f"?stream_channel={index}", faults)
    queue = stage.enter_context(closing(grabber.open_queue(4)))
    grabber.start()
    frames = [queue.get(PATIENCE) for _ in range(8)]
    assert open_ports(camera) == [index == 0, index == 1]
    assert all(frame.complete and frame.stream_channel == index for frame in frames)
    assert faults.loss == 0 or grabber.statistics().packets_resent, "requests name the channel"
    grabber.stop()
    assert open_ports(camera) == [False, False]


@pytest.mark.parametrize("faults", LOSSES, ids=["clean", "lossy"])
def test_all_channels_at_once(stage: ExitStack, faults: GigeFaults) -> None:
    camera, grabber = opened(stage, "?stream_channel=all", faults)
    queue = stage.enter_context(closing(grabber.open_queue(8)))
    grabber.start()
    frames = [queue.get(PATIENCE) for _ in range(20)]
    assert open_ports(camera) == [True, True]
    by_channel = [{frame.frame_id: frame for frame in frames if frame.stream_channel == at} for at in (0, 1)]
    both = by_channel[0].keys() & by_channel[1].keys()
    assert both, "each channel gets every frame"
    for frame_id in both:
        first, second = (channel[frame_id] for channel in by_channel)
        assert np.array_equal(first.raw(), second.raw())
        assert first.timestamp_ns == second.timestamp_ns
    assert grabber.statistics().frames >= 20, "counters are of both"
    grabber.stop()
    assert open_ports(camera) == [False, False]


def test_packet_size_and_delay_are_each_channels_own(stage: ExitStack) -> None:
    camera, grabber = opened(stage, "?stream_channel=1&packet_size=1000&packet_delay=5us")
    queue = stage.enter_context(closing(grabber.open_queue(4)))
    grabber.start()
    queue.get(PATIENCE)
    grabber.stop()
    memory, (first, second) = camera.control.memory, gev.CHANNELS
    assert [memory.integer(channel.scps) & 0xFFFF for channel in (first, second)] == [1500, 1000]
    assert [memory.integer(channel.scpd) for channel in (first, second)] == [0, 5000]
    assert grabber.feature("GevStreamChannelCount").value == 2
    grabber.write_feature("GevStreamChannelSelector", 1)
    assert grabber.feature("GevSCPSPacketSize").value == 1000
    grabber.write_feature("GevStreamChannelSelector", 0)
    assert grabber.feature("GevSCPSPacketSize").value == 1500


def test_a_channel_that_the_camera_lacks_is_refused_by_name(stage: ExitStack) -> None:
    with pytest.raises(UsageError, match=r"stream_channel=2: this camera has stream channels 0 to 1"):
        opened(stage, "?stream_channel=2")


@pytest.mark.parametrize("text", ["-1", "512", "both"])
def test_texts_that_are_no_channel(text: str) -> None:
    with pytest.raises(UsageError, match=f"stream_channel={text}: write a number from 0 to 511, or all"):
        sources.create(f"gige:127.17.0.1?stream_channel={text}")
