"""The thread that receives a stream: how it is scheduled, and what it survives."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Iterator
from contextlib import closing, contextmanager

import pytest

from grabbergui import sources
from grabbergui.core.frame import Frame
from grabbergui.core.frame_queue import FrameQueue
from grabbergui.core.scheduling import realtime_threads_permitted
from grabbergui.driver.gige.stream.block import Block
from grabbergui.driver.gige.stream.frame_builder import FrameBuilder
from grabbergui.driver.sim import registers as reg
from grabbergui.driver.sim.gige.server import GigeCamera
from patience import until

SMALL = {reg.WIDTH: 320, reg.HEIGHT: 240, reg.FRAME_RATE: 30.0, reg.EXPOSURE_TIME: 1000.0}


def policies() -> list[int]:
    """Return the scheduling policies of the threads of this process that receive streams."""
    threads = [thread for thread in threading.enumerate() if thread.name == "gige-receiver"]
    return [os.sched_getscheduler(thread.native_id or 0) & ~os.SCHED_RESET_ON_FORK for thread in threads]


@contextmanager
def streaming(address: str, query: str = "") -> Iterator[FrameQueue]:
    """Stream from a simulated camera at this address; yield a queue of its frames."""
    with (
        closing(GigeCamera(address, power_on=SMALL)),
        closing(sources.create(f"gige:{address}{query}")) as camera,
    ):
        camera.open()
        frames = camera.open_queue(4)
        camera.start()
        yield frames


@pytest.mark.skipif(sys.platform != "linux", reason="Linux schedules threads by these calls")
@pytest.mark.skipif(not realtime_threads_permitted(), reason="needs the right to real-time priority")
def test_a_stream_that_is_easy_to_follow_is_received_with_real_time_priority() -> None:
    with streaming(f"127.88.{os.getpid() % 250 + 1}.1") as frames:
        frames.get(10.0)
        until(lambda: policies() == [os.SCHED_RR])
        frames.clear()
        assert frames.get(10.0).complete


def test_a_block_that_cannot_become_a_frame_ends_no_stream(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    build = FrameBuilder.build

    def failing_at_first(builder: FrameBuilder, block: Block) -> Frame:
        if block.block_id < 4:
            raise ZeroDivisionError("a height of 0")
        return build(builder, block)

    monkeypatch.setattr(FrameBuilder, "build", failing_at_first)
    address = f"127.88.{os.getpid() % 250 + 1}.3"
    with streaming(address) as frames:
        assert frames.get(10.0).frame_id >= 4
    warned = [record for record in caplog.records if "ZeroDivisionError: a height of 0" in record.message]
    assert len(warned) == 1
